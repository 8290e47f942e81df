"""Grounds of any kind, from above, and how a camera sees them."""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import Image
from map_pictures.surface import coarse_noise, logistic, nearest_random_point


def view_in_perspective(ground: Image, shape: tuple[int, ...], rng: np.random.Generator) -> Image:
    """Return ground (H, W) as a camera sees it that is turned, and tilted more or less."""
    height, width = shape
    side, angle, far = len(ground), 2.0 * math.pi * rng.random(), rng.uniform(0.3, 1.0)
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [far, 1.0], [-far, 1.0]]) * rng.uniform(0.4, 0.7)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    source = (0.5 + 0.5 * corners @ turn) * side
    target = np.array([[0, height], [width, height], [width, 0], [0, 0]], np.float32)
    view = cv2.getPerspectiveTransform(source.astype(np.float32), target)
    return cv2.warpPerspective(ground, view, (width, height), borderMode=cv2.BORDER_REFLECT)


GROUND_SIDE = 400
"""Side of the ground that is made [px]."""


def waves(rng: np.random.Generator) -> Image:
    """Return noise of some wavelengths, longer one way."""
    ground = np.zeros((GROUND_SIDE, GROUND_SIDE), np.float32)
    stretch = math.exp(0.7 * rng.normal())
    for length in (2.0, 5.0, 12.0, 30.0):
        coarse = (
            max(round(GROUND_SIDE / (stretch * length)), 4),
            max(round(GROUND_SIDE * stretch / length), 4),
        )
        noise = rng.standard_normal(coarse, np.float32)
        ground += np.float32(rng.random()) * cv2.resize(noise, ground.shape)
    return ground


def _cobbles(rng: np.random.Generator) -> Image:
    """Return stones side by side, each of one grey level and lit from one side, dark between."""
    count = round(40.0 * 100.0 ** rng.random())
    off, stone = nearest_random_point(count, GROUND_SIDE, rng)
    levels = rng.standard_normal(int(stone.max()) + 1, np.float32)
    size = np.float32(GROUND_SIDE / math.sqrt(count))
    lit = np.gradient(off)[int(rng.integers(2))] * off / size
    seams = np.minimum(off / (np.float32(rng.uniform(0.3, 1.0)) * size), 1.0) ** 2
    return np.asarray(
        rng.random() * levels[stone] + rng.normal() * lit - 2.0 * rng.random() * seams, np.float32
    )


def _stones(rng: np.random.Generator) -> Image:
    """Return single stones, weed and shells: spots, longer or shorter, of any grey level."""
    ground = np.zeros((GROUND_SIDE, GROUND_SIDE), np.float32)
    longest = rng.uniform(3.0, 30.0)
    for _ in range(round(20.0 * 15.0 ** rng.random())):
        middle = tuple(int(each) for each in rng.integers(0, GROUND_SIDE, 2))
        length = longest * rng.random()
        axes = (round(length), round(length * rng.uniform(0.1, 1.0)))
        level = float(rng.normal())
        cv2.ellipse(ground, middle, axes, 360.0 * rng.random(), 0.0, 360.0, level, cv2.FILLED)
    return cv2.GaussianBlur(ground, (0, 0), rng.uniform(0.5, 2.0))


def _tracks(rng: np.random.Generator) -> Image:
    """Return crooked lines of any width, each with a side that is darker than the other."""
    ground = np.zeros((GROUND_SIDE, GROUND_SIDE), np.float32)
    for _ in range(rng.integers(2, 30)):
        steps = np.cumsum(rng.normal(0.0, 0.5, 12)) + 2.0 * math.pi * rng.random()
        path = np.cumsum(np.column_stack([np.cos(steps), np.sin(steps)]), axis=0)
        path = GROUND_SIDE * rng.random(2) + rng.uniform(4.0, 25.0) * path
        width, level = int(rng.integers(1, 8)), float(rng.normal())
        for shift, sign in ((0.0, 1.0), (float(width), -rng.random())):
            points = np.round(path + shift).astype(np.int32)[:, None]
            cv2.polylines(ground, [points], False, sign * level, width, cv2.LINE_AA)
    return cv2.GaussianBlur(ground, (0, 0), rng.uniform(0.5, 2.0))


def _boulders(rng: np.random.Generator) -> Image:
    """Return round stones, lit from one side, with shadows."""
    ground = np.zeros((GROUND_SIDE, GROUND_SIDE), np.float32)
    largest, light = rng.uniform(8.0, 60.0), rng.normal(0.0, 0.5, 2)
    for _ in range(rng.integers(3, 40)):
        middle, radius, level = GROUND_SIDE * rng.random(2), largest * rng.random(), rng.normal()
        axes = np.array([1.0, rng.uniform(0.5, 1.0)]) * radius
        turn, shadow = 360.0 * rng.random(), float(rng.uniform(-2.0, 0.0))
        for shift, size, lit in ((-0.5, 1.0, shadow), (0.0, 1.0, level), (0.3, 0.6, level + 0.5)):
            centre = tuple(int(each) for each in middle + shift * radius * light)
            lengths = tuple(round(size * each) for each in axes)
            cv2.ellipse(ground, centre, lengths, turn, 0.0, 360.0, float(lit), cv2.FILLED)
    return cv2.GaussianBlur(ground, (0, 0), rng.uniform(0.5, 3.0))


def _beds(rng: np.random.Generator) -> Image:
    """Return beds of mussels, weed or gravel: patches of one ground in nothing."""
    kinds = (waves, _cobbles, _stones)
    ground = kinds[rng.integers(len(kinds))](rng)
    coarse = rng.standard_normal((int(rng.integers(4, 16)),) * 2, np.float32)
    patches = cv2.resize(coarse, ground.shape, interpolation=cv2.INTER_CUBIC)
    within = patches > np.quantile(patches, rng.uniform(0.3, 0.9))
    scale = np.float32(rng.uniform(0.3, 1.5) / max(float(ground.std()), 0.3))
    return np.asarray(within * (scale * ground + np.float32(rng.normal())), np.float32)


def _step(rng: np.random.Generator) -> Image:
    """Return ground that is darker beyond one straight border: a shadow, a plate, a step."""
    across = np.arange(GROUND_SIDE, dtype=np.float32) / GROUND_SIDE - rng.uniform(0.2, 0.8)
    level = logistic(across * math.exp(rng.uniform(3.0, 6.5)))
    return np.tile(level.astype(np.float32), (GROUND_SIDE, 1))


def _ledges(rng: np.random.Generator) -> Image:
    """Return layers of rock, each of one grey level, with ragged edges that run side by side."""
    coarse, fine = (
        coarse_noise((GROUND_SIDE, GROUND_SIDE), (side, side), rng)
        for side in (int(rng.integers(4, 10)), int(rng.integers(30, 80)))
    )
    place = np.arange(GROUND_SIDE, dtype=np.float32) + 12.0 * rng.random() * coarse
    place += 4.0 * rng.random() * fine
    edges = np.sort(GROUND_SIDE * rng.random(int(rng.integers(2, 10))))
    levels = rng.random() * rng.standard_normal(len(edges) + 1, np.float32)
    nearest = np.min([np.abs(place - edge) for edge in edges], axis=0)
    seams = np.exp(-((nearest / rng.uniform(1.0, 4.0)) ** 2))
    layers = levels[np.searchsorted(edges, place)] - 2.0 * rng.random() * seams
    return np.asarray(layers, np.float32)


GROUNDS = (waves, _cobbles, _stones, _tracks, _boulders, _beds, _step, _ledges)
