"""What lies about cables, or on them: other ground, trenches, seams, plates, animals, ropes."""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.map.map_network import CELL
from map_pictures.grounds import GROUNDS, view_in_perspective, waves
from map_pictures.light import random_coordinates
from map_pictures.surface import Surface, coarse_noise, logistic, shares_at_pixels, surface

TRENCHED = 0.2
"""Share of the cables that lie in a trench."""

APART = 0.3
"""Share of other ground beside a cable that begins apart from it."""

SEAMED = 0.2
"""Share of the cables with a dark seam along one flank or both, where they touch the ground."""


def add_animals_and_rope(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with animals and, in every second one, a slack rope, in front of all."""
    deviation = float(levels.std()) + 3.0
    seen: Image = levels
    for _ in range(rng.integers(0, 6)):
        seen = _draw_in_front(seen, _animal(levels.shape, rng), deviation, rng)
    if rng.random() < 0.5:
        seen = _draw_in_front(seen, _slack_rope(levels.shape, rng), deviation, rng)
    return seen


def _draw_in_front(
    levels: Image, shape: Image, deviation: float, rng: np.random.Generator
) -> Image:
    """Return a picture with a shape (H, W), uint8, of one grey level, mostly with a shadow."""
    share = cv2.GaussianBlur(shape, (0, 0), rng.uniform(0.5, 1.5)).astype(np.float32) / 255.0
    if rng.random() < 0.7:
        shift = np.array([[1.0, 0.0, 5.0 * rng.normal()], [0.0, 1.0, 5.0 * rng.normal()]])
        shadow = cv2.warpAffine(share, shift, share.shape[::-1])
        levels = levels * (1.0 - np.float32(rng.uniform(0.1, 0.6)) * shadow)
    level = float(levels.mean()) + np.float32(2.0 * deviation * rng.normal())
    return np.asarray(levels + share * (level - levels), np.float32)


def _animal(shape: tuple[int, ...], rng: np.random.Generator) -> Image:
    """Return a star of some arms, or an ellipse, uint8 (H, W)."""
    drawn = np.zeros(shape, np.uint8)
    middle, size = rng.random(2) * shape[::-1], 4.0 * 8.0 ** rng.random()
    arms, depth = int(rng.integers(2, 9)), rng.uniform(0.2, 1.0)
    turns = 2.0 * math.pi * (np.arange(2 * arms) / (2 * arms) + rng.random())
    lengths = size * np.where(np.arange(2 * arms) % 2, depth, 1.0)
    tips = np.column_stack([np.cos(turns), rng.uniform(0.4, 1.0) * np.sin(turns)])
    outline = np.round(middle + lengths[:, None] * tips).astype(np.int32)
    return np.asarray(cv2.fillPoly(drawn, [outline[:, None]], 255.0, cv2.LINE_AA), np.uint8)


def _slack_rope(shape: tuple[int, ...], rng: np.random.Generator) -> Image:
    """Return a rope through any place that winds more than a cable does, uint8 (H, W)."""
    way = np.arange(-400.0, 400.0, 4.0)
    wave = 2.0 * math.pi * (way / rng.uniform(200.0, 500.0) + rng.random())
    heading = 2.0 * math.pi * rng.random() + rng.uniform(0.5, 1.4) * np.sin(wave)
    steps = 4.0 * np.column_stack([np.cos(heading), np.sin(heading)])
    path = np.cumsum(steps, axis=0)
    path += rng.random(2) * shape[::-1] - path[len(path) // 2]
    points = np.round(path).astype(np.int32)[:, None]
    drawn = np.zeros(shape, np.uint8)
    thickness = int(rng.integers(1, 10))
    return np.asarray(
        cv2.polylines(drawn, [points], False, 255.0, thickness, cv2.LINE_AA), np.uint8
    )


def add_ripples(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture whose bottom has ripples: bands as straight and clear as a cable.

    In one of five pictures they go over the cable, too, fainter.
    """
    height, width = levels.shape
    x = np.arange(width, dtype=np.float32) - 0.5 * width
    y = np.arange(height, dtype=np.float32)[:, None] - 0.5 * height
    direction, length, phase = math.pi * rng.random(), 8.0 * 12.0 ** rng.random(), rng.random()
    across = x * math.cos(direction) + y * math.sin(direction)
    along = y * math.cos(direction) - x * math.sin(direction)
    warp = 1.5 * rng.random() * np.sin(along / rng.uniform(20.0, 100.0) + 10.0 * phase)
    warp += rng.random() * np.sin(across / rng.uniform(40.0, 120.0))
    wave = np.sin(2.0 * math.pi * (across / length + phase) + warp)
    wave = np.sign(wave) * np.abs(wave) ** math.exp(rng.uniform(-1.5, 1.5))
    cable = shares_at_pixels(cells, levels.shape)
    over_cable = rng.uniform(0.0, 0.6) if rng.random() < 0.2 else 0.0
    share = 1.0 - cable * (1.0 - over_cable)
    return levels + np.float32(30.0 * rng.random() ** 2) * wave.astype(np.float32) * share


def add_other_ground(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture with other ground added, of one kind or two."""
    cable = shares_at_pixels(cells, levels.shape)
    for kind in rng.choice(len(GROUNDS), rng.integers(1, 3), replace=False):
        ground = view_in_perspective(GROUNDS[kind](rng), levels.shape, rng)
        ground *= np.float32(30.0 * rng.random() ** 2 / max(float(ground.std()), 0.3))
        levels = levels + ground * (1.0 - cable)
    return levels


def add_banks(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture with other ground along one side of the cable, or along both.

    Dumped rock, gravel, weed, or sand of another tone: it lies closest at the cable, or begins
    farther off, so that the ground between has two borders. Where there is no cable, it lies along
    any line: what has one border is none.
    """
    cable = shares_at_pixels(cells, levels.shape)
    outside, side = _sides(cells, levels.shape, rng)
    if rng.random() < APART:
        outside = outside - np.float32(5.0 * 16.0 ** rng.random())
    sides = (-1.0, 1.0) if rng.random() < 0.3 else (rng.choice((-1.0, 1.0)),)
    for each in sides:
        reach = 8.0 * 60.0 ** rng.random()
        # Single stones lie on the border; none lies farther in.
        is_beside = (each * side > 0.0) & (outside > -2.0)
        beside = np.where(is_beside, np.maximum(outside, 0.0) / np.float32(reach), np.inf)
        if rng.random() < 0.5:
            levels = _add_stones(levels, beside, rng)
        else:
            levels = _add_ground_beside(levels, beside, 1.0 - cable, rng)
    return levels


def _sides(cells: Image, shape: tuple[int, ...], rng: np.random.Generator) -> tuple[Image, Image]:
    """Return how far pixels lie outside the cable, below 0 inside, and aside of its axis [px].

    Without a cable they are those of any line.
    """
    rows, columns = np.nonzero(cells > 0.5)
    if len(rows) < 2:
        _, aside = random_coordinates(shape, math.pi * rng.random(), rng)
        return np.abs(aside), aside
    is_cable = (cells > 0.5).astype(np.uint8)
    off, deep = (
        cv2.distanceTransform(each, cv2.DIST_L2, cv2.DIST_MASK_5)
        for each in (1 - is_cable, is_cable)
    )
    outside = cv2.resize(CELL * (off - deep), shape[::-1], interpolation=cv2.INTER_LINEAR)
    middle = np.array([columns.mean(), rows.mean()])
    _, directions = np.linalg.eigh(np.cov(columns, rows))
    across = directions[:, 0]
    x = np.arange(shape[1], dtype=np.float32) - CELL * (middle[0] + 0.5)
    y = np.arange(shape[0], dtype=np.float32)[:, None] - CELL * (middle[1] + 0.5)
    return outside, (x * across[0] + y * across[1]).astype(np.float32)


def _add_stones(levels: Image, beside: Image, rng: np.random.Generator) -> Image:
    """Return a picture with stones, lit from one side, fewer the farther from the cable.

    `beside`: distance from it in units of that over which they become fewer, infinite elsewhere.
    """
    rows, columns = levels.shape
    dumped = levels.astype(np.float32)
    largest, light = 1.5 * 8.0 ** rng.random(), rng.normal(0.0, 0.7, 2)
    tone = dumped.mean() + (float(levels.std()) + 5.0) * 1.5 * rng.normal()
    spread, depth = 15.0 * rng.random(), rng.uniform(0.2, 0.9)
    number = round(
        min(2.5 * levels.size / (math.pi * largest**2) * 3.0 ** rng.uniform(-2, 1), 2500)
    )
    places = rng.random((number, 2)) * (columns, rows)
    far = beside[places[:, 1].astype(int), places[:, 0].astype(int)]
    for middle in places[rng.random(number) < np.exp(-far)]:
        radius = largest * rng.uniform(0.4, 1.0)
        axes, turn = np.array([1.0, rng.uniform(0.5, 1.0)]) * radius, 360.0 * rng.random()
        level = tone + spread * rng.normal()
        _draw_stone(
            dumped, middle + -0.4 * radius * light, 1.05 * axes, turn, level * (1.0 - depth)
        )
        _draw_stone(dumped, middle, 0.95 * axes, turn, level)
        _draw_stone(
            dumped, middle + 0.3 * radius * light, np.full(2, 0.5 * radius), 0.0, level + 8.0
        )
    return cv2.GaussianBlur(dumped, (3, 3), rng.uniform(0.3, 0.8))


def _draw_stone(
    picture: Image, middle: FloatArray, axes: FloatArray, turn: float, level: float
) -> None:
    """Draw a filled ellipse to an eighth of a pixel: half-axes [px] and turn [deg]."""
    centre, lengths = (
        tuple(int(each) for each in np.round(8.0 * values)) for values in (middle, axes)
    )
    ends = (turn, 0.0, 360.0)
    cv2.ellipse(picture, centre, lengths, *ends, float(level), cv2.FILLED, cv2.LINE_8, 3)


def _add_ground_beside(
    levels: Image, beside: Image, ground_share: Image, rng: np.random.Generator
) -> Image:
    """Return a picture with ground of another tone and grain beside the cable, ragged at its end.

    `beside` is that of `_add_stones`; `ground_share`: share of each pixel that is no cable.
    """
    rough = view_in_perspective(waves(rng), levels.shape, rng)
    rough *= np.float32(rng.uniform(0.0, 0.5) / max(float(rough.std()), 0.3))
    soft = np.float32(0.03 * 15.0 ** rng.random())
    shown = logistic((1.0 - np.minimum(beside, 20.0) + rough) / soft) * (beside < np.inf)
    deviation = float(levels.std()) + 3.0
    ground = view_in_perspective(GROUNDS[rng.integers(len(GROUNDS))](rng), levels.shape, rng)
    ground *= np.float32(1.5 * rng.random() * deviation / max(float(ground.std()), 0.3))
    level = np.float32(levels.mean() + deviation * rng.normal())
    kept = np.float32(rng.random())
    other = level + ground + kept * (levels - np.float32(levels.mean()))
    return np.asarray(levels + shown * ground_share * (other - levels), np.float32)


def add_seams(levels: Image, at: Surface, both: float, rng: np.random.Generator) -> Image:
    """Return a picture with a dark seam along both flanks of a cable, or along one.

    `both`: probability that it is along both.
    """
    dark = np.zeros_like(levels)
    for side in (-1.0, 1.0) if rng.random() < both else (rng.choice((-1.0, 1.0)),):
        half = np.float32(0.5 * min(2.0 + 7.0 * rng.random(), 0.35 * at.width))
        off = np.abs(at.outside - half * rng.uniform(-1.0, 1.0))
        ragged = coarse_noise(levels.shape, (30, 40), rng)
        ragged *= np.float32(0.4 * rng.random())
        soft = np.float32(0.3 * 6.0 ** rng.random())
        seam = logistic((half * (1.0 + ragged) - off) / soft) * (side * at.across > 0.0)
        dark = np.maximum(dark, np.float32(rng.uniform(0.1, 0.8)) * seam)
    return np.asarray(levels * (1.0 - dark), np.float32)


def add_trench(levels: Image, at: Surface, rng: np.random.Generator) -> Image:
    """Return a picture whose cable lies in a trench: walls, lit from one side, and its floor."""
    rough = coarse_noise(levels.shape, (30, 40), rng)
    slope, floor = rng.normal(0.0, 0.8), rng.normal(-0.2, 0.3)
    light = np.zeros_like(levels)
    for side in (-1.0, 1.0):
        begin = at.width * rng.uniform(0.0, 1.5)
        wall = at.width * rng.uniform(0.2, 1.5) + 3.0
        outside = at.outside + np.float32(0.25 * wall * rng.random()) * rough
        soft = np.float32(wall * rng.uniform(0.05, 0.2))
        before_top = logistic((begin + wall - outside) / soft)
        on_wall = logistic((outside - begin) / soft) * before_top
        strength = side * slope * rng.uniform(0.5, 1.0)
        light += (strength * on_wall + floor * before_top) * (side * at.across > 0.0)
    shown = logistic(at.outside / np.float32(0.7))
    return np.asarray(levels * np.exp(light * shown), np.float32)


def add_grooves(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture with grooves in the ground, as trawls and anchors leave them.

    Their slopes are lit from one side, the ground goes on in them, and they end at the cable.
    """
    cable = shares_at_pixels(cells, levels.shape)
    light = np.zeros_like(levels)
    turn, slope = math.pi * rng.random(), rng.normal(0.0, 0.7)
    for _ in range(rng.integers(1, 4)):
        _, aside = random_coordinates(levels.shape, turn + 0.1 * rng.normal(), rng)
        half = np.float32(3.0 * 12.0 ** rng.random())
        aside = aside + np.float32(0.5 * rng.random()) * half * coarse_noise(
            levels.shape, (12, 16), rng
        )
        off = aside / half
        # A round bottom with steeper or gentler walls, and what was thrown up beside it.
        power = 2.0 * 2.0 ** rng.random()
        depth = np.exp(-(np.abs(off) ** np.float32(power)))
        thrown_up = np.float32(rng.uniform(0.0, 0.5)) * np.exp(-(((np.abs(off) - 1.7) / 0.4) ** 2))
        walls = depth * np.abs(off) ** np.float32(power - 1.0) * np.sign(off)
        ridges = thrown_up * (np.abs(off) - 1.7) * np.sign(off)
        light += slope * (walls - 2.0 * ridges) - np.float32(0.4 * rng.random()) * depth
    return np.asarray(levels * np.exp(light * (1.0 - cable)), np.float32)


def add_parallel_cable(
    levels: Image, cells: Image, pose: FloatArray, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return a picture, and its map, with a second cable beside the first, wider or narrower."""
    distance, angle, width, _ = pose
    height, columns = levels.shape
    foot = (
        0.5 * (columns - 1) + distance * math.cos(angle),
        0.5 * (height - 1) - distance * math.sin(angle),
    )
    zoom, gap = rng.uniform(0.5, 1.6), width * 0.25 * 16.0 ** rng.random()
    apart = rng.choice((-1.0, 1.0)) * (0.5 * (1.0 + zoom) * width + gap)
    moved = cv2.getRotationMatrix2D(foot, 3.0 * rng.normal(), zoom)
    moved[:, 2] += apart * math.cos(angle), -apart * math.sin(angle)
    at = surface(pose, levels.shape)
    share = logistic(-at.outside / np.float32(0.7)).astype(np.float32)
    size = (columns, height)
    share = cv2.warpAffine(share, moved, size) * (at.outside > 0.0)
    other = cv2.warpAffine(levels.astype(np.float32), moved, size, borderMode=cv2.BORDER_REFLECT)
    both = np.maximum(cells, cv2.resize(share, cells.shape[::-1], interpolation=cv2.INTER_AREA))
    return np.asarray(levels + share * (other - levels), np.float32), both


def add_debris(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture with plates and blocks beside the cable, which cast their shadows one way.

    Their borders are as straight as those of a cable, and shorter.
    """
    height, width = levels.shape
    cable = shares_at_pixels(cells, levels.shape)
    deviation = np.float32(levels.std() + 5.0)
    light, found = 2.0 * math.pi * rng.random(), levels
    for _ in range(rng.integers(1, 9)):
        angles = np.sort(2.0 * math.pi * rng.random(rng.integers(3, 9)))
        radius = 6.0 * 15.0 ** rng.random()
        lengths = radius * rng.uniform(0.6, 1.0, len(angles))
        corners = np.column_stack([np.cos(angles), rng.uniform(0.5, 1.0) * np.sin(angles)])
        corners = lengths[:, None] * corners + rng.random(2) * (width, height)
        thrown = radius * rng.uniform(0.0, 0.8) * np.array([math.cos(light), math.sin(light)])
        soft = rng.uniform(0.3, 1.5)
        shadow = _filled(np.vstack([corners, corners + thrown]), levels.shape, soft)
        found = found * (1.0 - np.float32(rng.uniform(0.2, 0.9)) * shadow)
        ground = view_in_perspective(GROUNDS[rng.integers(len(GROUNDS))](rng), levels.shape, rng)
        block = found.mean() + deviation * np.float32(1.5 * rng.normal())
        block = block + np.float32(rng.random() ** 2 / max(ground.std(), 0.3)) * deviation * ground
        found = found + _filled(corners, levels.shape, soft) * (block - found)
    return np.asarray(found + cable * (levels - found), np.float32)


def _filled(corners: FloatArray, shape: tuple[int, ...], soft: float) -> Image:
    """Return the share of each pixel within the convex hull of some points (N, 2), (x, y) [px]."""
    filled = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(filled, cv2.convexHull(np.round(corners).astype(np.int32)), 255)
    return cv2.GaussianBlur(filled.astype(np.float32) / np.float32(255.0), (0, 0), soft)
