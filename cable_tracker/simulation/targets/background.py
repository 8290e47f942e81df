"""Water, bottom, surface and what drifts in it, in colour."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, eight_bits
from cable_tracker.simulation.rendering.texture import frequencies, spectral_noise
from cable_tracker.tracking.image_frame import image_centre

LEAST_MARGIN = 160
"""Least width of the panorama beyond the camera's first view, on each side [px]."""

SHALLOW, DEEP = np.array([165.0, 150.0, 75.0]), np.array([105.0, 82.0, 38.0])
"""Colour of the water above and below: blue, green, red."""

BLUR, NOISE = 0.7, 3.0
"""Standard deviations of the camera's blur [px] and of its sensor's noise [grey levels]."""

SAND = np.array([122.0, 128.0, 105.0])


@dataclass(frozen=True, slots=True, eq=False)
class TargetBackground:
    """Water, bottom or surface, and marine snow: all but the target.

    Attributes
    ----------
    panorama : Image
        Float32, larger than the picture by `margin` on every side, shape (H', W', 3).
    margin : int
        Width of the panorama beyond the camera's first view, on each side [px].
    flakes : FloatArray
        Marine snow: x, y as shares of the picture, speeds in shares per second, brightness; (K, 5).
    glitter : Image
        A seamless tile of light that wanders over everything, float32.
    """

    panorama: Image
    margin: int
    flakes: FloatArray
    glitter: Image

    def view(self, size: tuple[int, int], offset: tuple[float, float], time: float) -> Image:
        """Return the picture without a target, float32, shape (H, W, 3).

        `offset` shifts the view on the panorama, to the right and down [px].
        """
        width, height = size
        column, row = image_centre(size)
        centre = (self.margin + offset[0] + column, self.margin + offset[1] + row)
        picture = cv2.getRectSubPix(self.panorama, size, centre)
        side = self.glitter.shape[0]
        rows = (np.arange(height) + int(9.0 * time)) % side
        columns = (np.arange(width) + int(21.0 * time)) % side
        light = 1.0 + 0.035 * self.glitter[np.ix_(rows, columns)]
        lit: Image = picture * (light * (1.0 + 0.04 * math.sin(3.1 * time)))[..., None]
        return lit.astype(np.float32)

    def recorded(self, picture: Image, time: float, rng: np.random.Generator) -> Image:
        """Return a picture, float32 (H, W, 3), as the camera records it: with snow, blur and noise.

        Returns
        -------
        Image
            uint8, shape (H, W, 3).
        """
        blurred = cv2.GaussianBlur(self._with_snow(picture, time), (0, 0), BLUR)
        blurred += rng.normal(0.0, NOISE, picture.shape).astype(np.float32)
        return eight_bits(blurred)

    def _with_snow(self, picture: Image, time: float) -> Image:
        """Return a picture (H, W, 3) with the marine snow drawn over it."""
        snowy = picture.copy()
        height, width = picture.shape[:2]
        x = (self.flakes[:, 0] + self.flakes[:, 2] * time) % 1.0 * width
        y = (self.flakes[:, 1] + self.flakes[:, 3] * time) % 1.0 * height
        for column, row, light in zip(x, y, self.flakes[:, 4], strict=True):
            patch = snowy[int(row) : int(row) + 2, int(column) : int(column) + 2]
            patch += np.float32(light)
        return snowy


def random_background(
    size: tuple[int, int],
    rng: np.random.Generator,
    *,
    margin: float,
    surface: float | None = None,
) -> TargetBackground:
    """Draw a background at random.

    Parameters
    ----------
    size : (int, int)
        Width and height of the pictures [px].
    rng : numpy.random.Generator
        Source of the random numbers.
    margin : float
        Largest offset of the view [px].
    surface : float or None
        Height of the water's surface above the lower edge, as a share of the picture's height.
    """
    beside = max(math.ceil(margin) + 1, LEAST_MARGIN)
    width, height = size[0] + 2 * beside, size[1] + 2 * beside
    depth = np.linspace(0.0, 1.0, height)[:, None, None]
    panorama = np.tile((1.0 - depth) * SHALLOW + depth * DEEP, (1, width, 1)).astype(np.float32)
    panorama *= (1.0 + 0.05 * _clouds((height, width), 60.0, rng))[..., None]
    if surface is None:
        _lay_bottom(panorama, beside + int(size[1] * rng.uniform(0.6, 0.8)), rng)
    else:
        _lay_surface(panorama, beside + int(size[1] * (1.0 - surface)), rng)
    count = int(rng.integers(20, 45))
    flakes = np.stack(
        (
            rng.random(count), rng.random(count), rng.normal(0.0, 0.05, count),
            rng.uniform(0.01, 0.06, count), rng.uniform(10.0, 45.0, count),
        ),
        axis=1,
    )  # fmt: skip
    return TargetBackground(panorama, beside, flakes, _clouds((256, 256), 14.0, rng))


def _clouds(shape: tuple[int, int], length: float, rng: np.random.Generator) -> Image:
    across, along = frequencies(shape, 1.0)
    response = 1.0 / (1.0 + (length * np.hypot(across, along)) ** 2)
    return spectral_noise(response.astype(np.float32), shape, rng)


def _lay_bottom(panorama: Image, horizon: int, rng: np.random.Generator) -> None:
    """Paint sand with stones and growth below a horizon that the haze softens."""
    height, width = panorama.shape[:2]
    grain = 0.09 * _clouds((height, width), 5.0, rng) + 0.07 * _clouds((height, width), 40.0, rng)
    sand = (SAND * (1.0 + grain)[..., None]).astype(np.float32)
    colours = ((48, 62, 55), (70, 84, 76), (50, 70, 115), (62, 95, 60), (75, 70, 130))
    for _ in range(int(rng.integers(14, 26))):
        centre = (int(rng.uniform(0, width)), int(rng.uniform(horizon, height)))
        axes = (int(rng.uniform(4, 22)), int(rng.uniform(3, 12)))
        colour = tuple(float(c * rng.uniform(0.8, 1.2)) for c in colours[rng.integers(5)])
        cv2.ellipse(sand, centre, axes, rng.uniform(-30, 30), 0, 360, colour, -1, cv2.LINE_AA)
    sand *= (1.0 + 0.06 * _clouds((height, width), 3.0, rng))[..., None]
    share = np.clip((np.arange(height) - horizon) / 45.0, 0.0, 0.9)[:, None, None]
    panorama[:] = (1.0 - share) * panorama + share * sand


def _lay_surface(panorama: Image, line: int, rng: np.random.Generator) -> None:
    """Paint the bright, wavy under side of the surface above a line."""
    height, width = panorama.shape[:2]
    across, along = frequencies((height, width), 1.0)
    ripples = spectral_noise(
        (1.0 / (1.0 + (25.0 * across) ** 2 + (7.0 * along) ** 2)).astype(np.float32),
        (height, width), rng,
    )  # fmt: skip
    bright = np.array([205.0, 200.0, 150.0]) * (1.0 + 0.12 * ripples)[..., None]
    share = np.clip((line - np.arange(height)) / 10.0, 0.0, 0.85)[:, None, None]
    panorama[:] = (1.0 - share) * panorama + share * bright
