"""Light on ground and cable alike, and particles in the water."""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import Image
from map_pictures.camera import STREAKED, blur_by_motion, random_shifts
from map_pictures.surface import logistic, nearest_random_point

LEAST_TEXTURE = 0.04
"""Standard deviation of the fine texture, over the mean, from which on ground shows in a shadow."""


def add_uneven_light(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture that is lit unevenly, by lamps here and there."""
    strength = rng.random() * rng.standard_normal((3, 4), np.float32)
    light = cv2.resize(strength, levels.shape[::-1], interpolation=cv2.INTER_CUBIC)
    lit: Image = levels * np.exp(0.5 * light)
    return lit


def add_light_pools(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with pools and bands of light or shade, on ground and cable alike.

    Round pools may have a sharp rim; what is long fades out, or it could be a cable.
    """
    light = np.zeros_like(levels)
    for _ in range(rng.integers(1, 5)):
        longer, turn = 15.0 * 20.0 ** rng.random(), math.pi * rng.random()
        shorter = longer * rng.uniform(0.08, 1.0)
        along, aside = random_coordinates(levels.shape, turn, rng)
        outside = np.hypot(along / np.float32(longer), aside / np.float32(shorter)) - 1.0
        sharpest = 0.03 if shorter > 0.5 * longer else 0.2
        rim = np.float32(sharpest ** rng.random())
        light += np.float32(rng.uniform(-1.2, 1.2)) * logistic(-outside / rim)
    lit: Image = levels * np.exp(light).astype(np.float32)
    return lit


def add_caustics(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture under a net of light, as waves make it, on ground and cable alike."""
    height, width = levels.shape
    _, mesh = nearest_random_point(round(20.0 * 20.0 ** rng.random()), max(height, width), rng)
    lines = ((mesh != np.roll(mesh, 1, 0)) | (mesh != np.roll(mesh, 1, 1))).astype(np.float32)
    lines = cv2.GaussianBlur(lines, (0, 0), rng.uniform(0.7, 4.0))
    across, down = random_shifts(levels.shape, 10.0, (8, 10), rng)
    across += np.arange(width, dtype=np.float32)
    down += np.arange(height, dtype=np.float32)[:, None]
    net = cv2.remap(lines, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    light = np.float32(rng.uniform(0.2, 1.5)) * net / max(float(net.max()), 0.01)
    return np.asarray(levels * (1.0 + light), np.float32)


def add_light_bands(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with soft, straight bands and steps of light or shade, on ground and cable.

    Such are the beams of lamps, the edges of the vehicle's own shadow, and what a lens darkens.
    """
    light = np.zeros_like(levels)
    for _ in range(rng.integers(1, 4)):
        turn, half = math.pi * rng.random(), 8.0 * 19.0 ** rng.random()
        _, aside = random_coordinates(levels.shape, turn, rng)
        # Softer than the border of any cable that is as wide, however it is blurred.
        rim = np.float32(max(half * rng.uniform(0.2, 0.6), 4.0))
        light += np.float32(0.4 * rng.normal()) * logistic((half - np.abs(aside)) / rim)
    lit: Image = levels * np.exp(light).astype(np.float32)
    return lit


def add_frame_shadows(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with shadows of the vehicle's own frame: straight, crisp bands.

    The ground shows through them, which tells them from one. Ground that shows nothing is left as
    it is.
    """
    fine = levels - cv2.GaussianBlur(levels, (0, 0), 6.0)
    if float(fine.std()) < LEAST_TEXTURE * float(levels.mean()):
        return levels
    shade = np.zeros_like(levels)
    turn = math.pi * rng.random()
    for _ in range(rng.integers(1, 4)):
        if rng.random() < 0.3:
            turn = math.pi * rng.random()
        _, aside = random_coordinates(levels.shape, turn, rng)
        half, rim = 2.5 * 16.0 ** rng.random(), np.float32(0.4 * 8.0 ** rng.random())
        within = logistic((np.float32(half) - np.abs(aside)) / rim)
        shade = np.maximum(shade, np.float32(rng.uniform(0.15, 0.7)) * within)
    return np.asarray(levels * (1.0 - shade), np.float32)


def random_coordinates(
    shape: tuple[int, ...], turn: float, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return pixel coordinates along a direction and across it, from a random origin [px]."""
    height, width = shape
    across = np.arange(width, dtype=np.float32) - np.float32(rng.uniform(0, width))
    down = np.arange(height, dtype=np.float32)[:, None] - np.float32(rng.uniform(0, height))
    return (
        across * math.cos(turn) + down * math.sin(turn),
        down * math.cos(turn) - across * math.sin(turn),
    )


def add_marine_snow(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with particles in the water before it, bright and out of focus."""
    height, width = levels.shape
    snow = np.zeros_like(levels)
    largest = rng.uniform(1.0, 4.0)
    for _ in range(round(5.0 * 20.0 ** rng.random())):
        middle = (int(rng.integers(width)), int(rng.integers(height)))
        cv2.circle(snow, middle, round(largest * rng.random()), rng.random(), cv2.FILLED)
    snow = cv2.GaussianBlur(snow, (0, 0), rng.uniform(0.5, 1.5))
    if rng.random() < STREAKED:
        snow = blur_by_motion(snow, rng)
    return levels + np.float32(100.0 * rng.random()) * snow
