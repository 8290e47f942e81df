"""How a camera and a display record a picture, and how it is turned and bent."""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import Image
from map_pictures.surface import shares_at_pixels

BLURRED, STREAKED = 0.4, 0.4
"""Shares of the pictures that are blurred, and of these that are blurred one way, as by motion."""

CAPTIONED = 0.15
"""Share of the pictures with text, boxes and thin lines burned in."""


def record_by_camera(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture as a camera and a display record it."""
    levels = 255.0 * np.clip(levels / 255.0, 0.0, 1.0) ** np.float32(math.exp(0.3 * rng.normal()))
    if rng.random() < BLURRED:
        is_streaked = rng.random() < STREAKED
        levels = blur_by_motion(levels, rng) if is_streaked else _defocus(levels, rng)
    noise = np.float32(12.0) * rng.random() ** 3
    levels = levels + noise * rng.standard_normal(levels.shape, np.float32)
    if rng.random() < CAPTIONED:
        levels = _add_captions(levels, rng)
    return levels.astype(np.float32)


def _defocus(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture that is blurred alike in all directions."""
    return cv2.GaussianBlur(levels, (0, 0), 0.5 * 6.0 ** rng.random())


def blur_by_motion(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture that is blurred one way, as by motion while the shutter is open."""
    length, turn = 2.0 * 8.0 ** rng.random(), math.pi * rng.random()
    reach = math.ceil(0.5 * length)
    off = np.arange(-reach, reach + 1, dtype=np.float32)
    along = off * math.cos(turn) + off[:, None] * math.sin(turn)
    aside = off[:, None] * math.cos(turn) - off * math.sin(turn)
    within = np.maximum(1.0 - np.abs(aside), 0.0) * (np.abs(along) <= 0.5 * length)
    return cv2.filter2D(levels, -1, within / within.sum(), borderType=cv2.BORDER_REFLECT)


def _add_captions(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with what a display burns in: text, some of it in boxes, and thin lines."""
    height, width = levels.shape
    written = np.clip(levels, 0.0, 255.0).astype(np.uint8)
    for _ in range(rng.integers(1, 7)):
        place = (int(rng.integers(-20, width)), int(rng.integers(10, height)))
        length = int(rng.integers(2, 30))
        text = "".join(chr(each) for each in rng.integers(32, 127, length))
        font, size = int(rng.integers(0, 8)), rng.uniform(0.3, 0.9)
        level = abs(float(rng.choice((0.0, 255.0))) - 40.0 * rng.random() ** 2)
        thickness = int(rng.integers(1, 3))
        (long, tall), below = cv2.getTextSize(text, font, size, thickness)
        if rng.random() < 0.4:
            corner, opposite = (
                (place[0] - 3, place[1] + below),
                (place[0] + long + 3, place[1] - tall - 3),
            )
            cv2.rectangle(written, corner, opposite, 255.0 - level, cv2.FILLED)
        cv2.putText(written, text, place, font, size, level, thickness, cv2.LINE_AA)
    for _ in range(rng.integers(0, 4)):
        first, second = ((int(rng.integers(width)), int(rng.integers(height))) for _ in range(2))
        # Level or upright, as the lines of displays are.
        second = (second[0], first[1]) if rng.random() < 0.5 else (first[0], second[1])
        cv2.line(written, first, second, float(rng.choice((0.0, 255.0))), int(rng.integers(1, 3)))
    return np.asarray(written, np.float32)


def warp(levels: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return a picture, and its map, turned, enlarged or made smaller, and bent."""
    height, width = levels.shape
    angle, zoom = 0.25 * rng.normal(), math.exp(rng.uniform(-0.15, 0.5))
    cos, sin = math.cos(angle) / zoom, math.sin(angle) / zoom
    x = np.arange(width, dtype=np.float32) - 0.5 * (width - 1)
    y = np.arange(height, dtype=np.float32)[:, None] - 0.5 * (height - 1)
    across, down = random_shifts(levels.shape, 8.0, (3, 4), rng)
    across = across + np.float32(cos) * x - np.float32(sin) * y + np.float32(0.5 * (width - 1))
    down = down + np.float32(sin) * x + np.float32(cos) * y + np.float32(0.5 * (height - 1))
    moved = cv2.remap(levels, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    shares = shares_at_pixels(cells, levels.shape)
    shares = cv2.remap(shares, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return moved, cv2.resize(shares, cells.shape[::-1], interpolation=cv2.INTER_AREA)


def random_shifts(
    shape: tuple[int, ...], most: float, coarse: tuple[int, int], rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return by how much pixels (H, W) are shifted across and down where a picture is bent [px].

    `most`: largest standard deviation [px]; `coarse`: number of shifts that are drawn.
    """
    shifts = most * rng.random() * rng.standard_normal((2, *coarse), np.float32)
    across, down = (cv2.resize(each, shape[::-1], interpolation=cv2.INTER_CUBIC) for each in shifts)
    return across, down
