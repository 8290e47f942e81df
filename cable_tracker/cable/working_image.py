"""The picture in which borders are measured: grey, float32, of a moderate width."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.gradients import GAUSSIAN_MAD, GradientField, gradient_field
from cable_tracker.cable.parameters import REFERENCE_WIDTH
from cable_tracker.errors import FrameError

MINIMUM_SIDE = 16
"""Smallest height and width of a frame that a cable can be measured in [px]."""

SMALLEST_SIGMA = 0.5
"""Sigma that filters keep in narrow pictures [px]; below it, they fall between the pixels."""

REGION_SIGMA = 3.0
"""Sigma of the Gaussian for `smooth` [px at the reference width]."""

CONTRAST_LAG, CONTRAST_STEP = 12, 4
"""Distance of the places whose difference is the contrast, and of those looked at [px]."""

SMALLEST_CONTRAST = 0.3
"""Smallest scale of the contrast [grey levels]."""

MAXIMUM_SIDE = 32_766
"""Largest height and width of a frame that OpenCV looks up pixels in [px]."""


@dataclass(frozen=True, eq=False)
class WorkingImage:
    """A frame made ready for measuring.

    Attributes
    ----------
    pixels : Image
        Grey levels, float32, shape (h, w).
    frame_size : (int, int)
        Width and height of the frame that it was made from [px].
    filter_sigma : float
        Sigma of the Gaussian for `gradients` [px at the reference width].
    """

    pixels: Image
    frame_size: tuple[int, int]
    filter_sigma: float = 1.6

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [px]."""
        return self.pixels.shape[1], self.pixels.shape[0]

    @property
    def reduction(self) -> float:
        """Working pixels per frame pixel, at most 1."""
        return self.size[0] / self.frame_size[0]

    @property
    def scale(self) -> float:
        """Working pixels per pixel of an image of the reference width."""
        return self.size[0] / REFERENCE_WIDTH

    @cached_property
    def smooth(self) -> Image:
        """The picture without its fine texture, float32, shape (h, w)."""
        return np.asarray(cv2.GaussianBlur(self.pixels, (0, 0), REGION_SIGMA * self.scale))

    @cached_property
    def contrast_scale(self) -> float:
        """Robust standard deviation of `smooth` over a few pixels [grey levels].

        What slow changes of the light alone make of two places as far apart as the inside and the
        outside of a border.
        """
        lag = max(1, round(CONTRAST_LAG * self.scale))
        sparse = self.smooth[::CONTRAST_STEP, ::CONTRAST_STEP]
        across = self.smooth[::CONTRAST_STEP, lag::CONTRAST_STEP]
        down = self.smooth[lag::CONTRAST_STEP, ::CONTRAST_STEP]
        differences = (
            np.abs(across - sparse[:, : across.shape[1]]).ravel(),
            np.abs(down - sparse[: down.shape[0]]).ravel(),
        )
        scale = GAUSSIAN_MAD * float(np.median(np.concatenate(differences)))
        return max(scale, SMALLEST_CONTRAST)

    @cached_property
    def gradients(self) -> GradientField:
        """The gradients of the picture, worked out when they are first asked for."""
        return gradient_field(self.pixels, max(self.filter_sigma * self.scale, SMALLEST_SIGMA))

    def to_working(self, points: FloatArray) -> FloatArray:
        """Turn points (..., 2) of the frame's image frame into that of the working picture.

        Both have their origin at the image centre, so only the scale differs.
        """
        return points * self.reduction


def check_frame(image: Image) -> None:
    """Refuse what is no grey picture.

    Raises
    ------
    FrameError
        The array has not two dimensions, is too small or large, of an unknown dtype, or not finite.
    """
    if image.ndim != 2:
        raise FrameError(f"a grey picture has shape (height, width), not {image.shape}")
    if min(image.shape) < MINIMUM_SIDE:
        height, width = image.shape
        raise FrameError(f"{width}x{height} px is too small; at least {MINIMUM_SIDE} px each way")
    if max(image.shape) > MAXIMUM_SIDE:
        height, width = image.shape
        raise FrameError(f"{width}x{height} px is too large; at most {MAXIMUM_SIDE} px each way")
    if image.dtype not in (np.uint8, np.float32):
        raise FrameError(f"grey levels must be uint8 or float32, not {image.dtype}")
    if image.dtype == np.float32 and not np.isfinite(image).all():
        raise FrameError("the picture has pixels that are NaN or infinite")


def make_working_image(image: Image, working_width: int, filter_sigma: float = 1.6) -> WorkingImage:
    """Reduce a wider frame to the working width by averaging over areas.

    Parameters
    ----------
    image : Image
        Grey levels, uint8 or float32, shape (H, W).
    working_width : int
        Wanted width [px].
    filter_sigma : float
        See `WorkingImage`.
    """
    height, width = image.shape
    pixels = image
    if width > working_width:
        size = (working_width, max(1, round(height * working_width / width)))
        pixels = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return WorkingImage(
        np.ascontiguousarray(pixels, dtype=np.float32), (width, height), filter_sigma
    )
