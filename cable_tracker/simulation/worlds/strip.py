"""A cable's own coordinates in a picture, a plane in perspective; crisp strips on a plain ground.

Crisp strips are the least that a tracker must find at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, eight_bits
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, STATE_SIZE, WIDTH, CableState
from cable_tracker.simulation.dive import SimulatedFrame, make_frame
from cable_tracker.simulation.worlds.motion import WORLD_RATE
from cable_tracker.tracking.image_frame import to_image
from cable_tracker.tracking.parameter_table import pixel_scale

LEAST_SCALE = 0.06
"""The ground is not followed farther than to where it is so small, relative to the foot point."""

STRIP_WIDTHS = (4.0, 200.0)
"""Narrowest and widest strip, drawn uniformly in the logarithm [px at 320 px]."""

STRIP_SKEW = float(np.deg2rad(25.0))
"""Largest angle between a border and the centreline [rad]."""

LEAST_BORDER = 0.5
"""Smallest share of the picture's height along which each border is in view."""

PLACES_TRIED = 30
"""Number of places drawn before the skew is made smaller."""

NARROWEST_SHARE = 0.25
"""Smallest width of the strip in the picture as a share of its nominal width: no tip is in view."""

STRIP_GROUND = (70.0, 170.0)
"""Grey levels of the ground."""

STRIP_STEP = (35.0, 75.0)
"""Step of the borders, brighter or darker [grey levels]."""

STRIP_NOISE = (2.0, 5.0)
"""Standard deviation of the noise [grey levels]."""

STRIP_BLUR = 0.6
"""Standard deviation of the blur [px at 320 px]."""

STRIP_DRIFT = 0.2
"""Standard deviation of the steps of d from frame to frame [px at 320 px]."""


@dataclass(frozen=True, slots=True, eq=False)
class StripView:
    """Coordinates of pixels on the bottom relative to a cable, float32 arrays of one shape.

    Attributes
    ----------
    u : Image
        Across the cable [radii]: its borders are at -1 and 1.
    v : Image
        Along it, from its foot point [radii].
    radius : Image
        Extent of a radius in the picture there [px].
    """

    u: Image
    v: Image
    radius: Image


def pixel_grid(image_size: tuple[int, int]) -> tuple[Image, Image]:
    """Return x and y of all pixels in the image frame, float32, shape (H, W) each [px]."""
    width, height = image_size
    x, y = to_image(
        np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32), image_size
    )
    columns, rows = np.meshgrid(x, y)
    return columns, rows


def view_strip(state: FloatArray, x: Image, y: Image) -> StripView:
    """Return the coordinates of image points on the bottom, relative to a cable.

    Parameters
    ----------
    state : FloatArray
        d, alpha, w, beta first, shape (4,) or more [px, rad].
    x, y : Image
        Coordinates in the image frame [px].
    """
    distance, angle, width, skew = (float(value) for value in state[:4])
    cos, sin = np.float32(np.cos(angle)), np.float32(np.sin(angle))
    across = x * cos + y * sin - np.float32(distance)
    along = y * cos - x * sin
    half = np.float32(width / 2)
    radius = half - along * np.float32(np.tan(skew))
    radius = np.maximum(radius, np.float32(LEAST_SCALE) * half)
    return StripView(across / radius, along / radius, radius)


def border_points(
    state: FloatArray, image_size: tuple[int, int], spacing: float
) -> tuple[Image, Image]:
    """Return points along both borders inside an image, at a spacing [px].

    Returns
    -------
    (Image, Image)
        x and y of the left border's points, then of the right one's, float32, shape (1, K) [px].
    """
    distance, angle, half = state[0], state[ANGLE], state[WIDTH] / 2
    reach = float(np.hypot(*image_size)) / 2 + abs(float(distance)) + float(half)
    along = np.arange(-reach, reach, spacing)
    offset = half - along * np.tan(state[SKEW])
    usable = offset > LEAST_SCALE * half
    across = distance + np.concatenate((-offset[usable], offset[usable]))
    along = np.concatenate((along[usable], along[usable]))
    x = across * np.cos(angle) - along * np.sin(angle)
    y = across * np.sin(angle) + along * np.cos(angle)
    width, height = image_size
    inside = (np.abs(x) <= (width - 1) / 2) & (np.abs(y) <= (height - 1) / 2)
    return x[inside][None].astype(np.float32), y[inside][None].astype(np.float32)


def random_strip(image_size: tuple[int, int], rng: np.random.Generator) -> FloatArray:
    """Draw a strip at any place and angle, both borders of which are in view.

    The skew is that of a uniform draw, as far as no tip of the strip comes into view.

    Returns
    -------
    FloatArray
        d, alpha, w, beta and zeros, shape (8,) [px, rad].
    """
    scale = pixel_scale(image_size[0])
    state = np.zeros(STATE_SIZE)
    # Width and skew are settled first, so that wide and skewed strips are not fewer than others.
    state[WIDTH] = scale * float(np.exp(rng.uniform(*np.log(STRIP_WIDTHS))))
    steepest = np.arctan(state[WIDTH] / image_size[1])
    state[SKEW] = np.clip(rng.uniform(-STRIP_SKEW, STRIP_SKEW), -steepest, steepest)
    while True:
        for _ in range(PLACES_TRIED):
            state[DISTANCE] = rng.uniform(-0.5, 0.5) * float(np.hypot(*image_size))
            state[ANGLE] = rng.uniform(-np.pi / 2, np.pi / 2)
            if _shows_both_borders(state, image_size):
                return state
        state[SKEW] *= 0.8


def _shows_both_borders(state: FloatArray, image_size: tuple[int, int]) -> bool:
    spacing = 2.0
    x, y = border_points(state, image_size, spacing)
    view = view_strip(state, x, y)
    least = LEAST_BORDER * image_size[1] / spacing
    if min(int((view.u < 0).sum()), int((view.u > 0).sum())) < least:
        return False
    return bool(view.radius.min() >= NARROWEST_SHARE * state[WIDTH] / 2)


def simulate_strip(seed: int, frame_count: int = 10) -> Iterator[SimulatedFrame]:
    """Yield frames of 640 x 480 of a random strip that drifts a little, at 25 frames per second.

    Parameters
    ----------
    seed : int
        Not negative; each is another strip.
    frame_count : int
        Number of frames.
    """
    image_size = 640, 480
    rng = np.random.default_rng((3, seed))
    state = random_strip(image_size, rng)
    scale = pixel_scale(image_size[0])
    ground, noise = float(rng.uniform(*STRIP_GROUND)), float(rng.uniform(*STRIP_NOISE))
    step = float(rng.uniform(*STRIP_STEP) * rng.choice((-1.0, 1.0)))
    x, y = pixel_grid(image_size)
    for index in range(frame_count):
        view = view_strip(state, x, y)
        cover = np.clip((1 - np.abs(view.u)) * view.radius + np.float32(0.5), 0.0, 1.0)
        image: Image = cv2.GaussianBlur(ground + step * cover, (0, 0), STRIP_BLUR * scale)
        grain: Image = rng.standard_normal(image.shape, np.float32)
        image = image + np.float32(noise) * grain
        picture = eight_bits(image)
        truth = CableState.from_array(wrap_state(state))
        yield SimulatedFrame(make_frame(index, WORLD_RATE, picture, truth), 1.0)
        state[DISTANCE] += STRIP_DRIFT * scale * rng.standard_normal()
