"""Scenes in three dimensions that lamps light, for the network that looks at pictures.

A cable is a tube on, in or above a bottom with a relief. Lamps beside the camera, which may be low
and at one side, light both: flanks that look away from them lie in shadow, and everything throws
one. Light falls off with the square of the distance, is swallowed by the water, and lights the
water itself. So shadows fit what throws them, as those that are painted may not. Lengths are in
heights of the camera above the bottom.
"""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.simulation.rendering.camera import chain, rotation_about
from cable_tracker.simulation.rendering.texture import frequencies, spectral_noise
from cable_tracker.simulation.worlds.catalogue import Split
from cable_tracker.simulation.worlds.ground import photographed_texture, photographs_of
from map_pictures.ray_casting import BOUNDS, SIDE, SIZE, Scene, Tube, render_scene, unit_vector

EMPTY, FURROWED = 0.2, 0.3
"""Shares of the scenes without a cable, and with furrows or ridges in the bottom. Before its last
5000 steps the network in use saw 14 000 with 0.15 and 0.25 of them, and 4000 with 0.3 and 0.5."""

KEPT_NOISES = 24
"""Number of noises of a kind that are drawn; scenes move and turn them."""


def lamplit_frame(seed: int) -> tuple[Image, Image]:
    """Return a picture, uint8 (H, W), and which share of each pixel is cable, uint8 to 255."""
    rng = np.random.default_rng((seed, 3))
    while True:
        scene = random_scene(rng)
        light, cable = render_scene(scene)
        share = cable.mean()
        # A cable that hardly comes into view, or fills it, teaches nothing.
        if scene.tube is None or 0.01 < share < 0.75:
            return expose(light, rng), np.round(255.0 * cable).astype(np.uint8)


def random_scene(rng: np.random.Generator) -> Scene:
    """Draw a scene."""
    focal_length = SIZE[0] * rng.uniform(0.6, 1.4)
    view = _random_view(rng)
    relief, marks = _random_relief(rng)
    albedo = _random_albedo(marks, rng)
    tube = (
        None
        if rng.random() < EMPTY
        else _random_tube(view, focal_length, float(albedo.mean()), rng)
    )
    return Scene(
        view=view,
        focal_length=focal_length,
        relief=relief,
        albedo=albedo,
        tube=tube,
        lamps=_random_lamps(rng),
        ambient=0.6 * rng.random() ** 3 if rng.random() < 0.7 else 0.0,
        absorption=0.1 + 1.0 * rng.random() ** 2,
        scattering=0.25 * rng.random() ** 3,
        beam=rng.choice((0.0, 1.0, 3.0, 8.0)),
    )


def _random_view(rng: np.random.Generator) -> FloatArray:
    """Return the rotation of a camera that looks down, tilted more or less, and turned."""
    pitch = math.radians(25.0 * rng.random() ** 2 * rng.choice((-1.0, 1.0)))
    roll, turn = math.radians(-4.0 * rng.normal()), 2.0 * math.pi * rng.random()
    down = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    turned, tilted, rolled = (
        rotation_about(axis, np.array([angle]))
        for axis, angle in ((2, turn), (0, pitch), (1, roll))
    )
    return chain(turned, down[None], tilted, rolled)[0]


def _random_tube(
    view: FloatArray, focal_length: float, ground: float, rng: np.random.Generator
) -> Tube:
    """Draw a cable through some point in view: half buried, lying, or hanging above the bottom."""
    narrow = rng.random() < 0.75
    width = math.exp(rng.uniform(*np.log((5.0, 160.0)))) if narrow else rng.uniform(15.0, 150.0)
    radius = min(0.5 * width / focal_length, 0.3)
    lying = rng.random()
    if lying < 0.25:
        height = radius * rng.uniform(-0.7, 0.6)
    elif lying < 0.7:
        height = radius * rng.uniform(0.6, 1.0)
    else:
        height = radius * (1.0 + 0.2 * 40.0 ** rng.random())
    height = min(height, 0.5)
    place = np.array([rng.uniform(-0.38, 0.38) * SIZE[0], rng.uniform(-0.38, 0.38) * SIZE[1]])
    ray = view @ np.array([*(place / focal_length), 1.0])
    point = np.array([0.0, 0.0, 1.0]) + (1.0 - height) / -ray[2] * ray
    heading = 2.0 * math.pi * rng.random()
    rise = rng.normal(0.0, 0.08) if lying > 0.7 else rng.normal(0.0, 0.01)
    return Tube(
        point=(float(point[0]), float(point[1]), float(point[2])),
        direction=unit_vector((math.cos(heading), math.sin(heading), rise)),
        radius=radius,
        skin=_random_skin(ground, rng),
        gloss=0.6 * rng.random() ** 2 if rng.random() < 0.4 else 0.0,
    )


def _random_skin(ground: float, rng: np.random.Generator) -> Image:
    """Return what a cable reflects: plain, banded, jointed, dirty, overgrown."""
    level = ground * math.exp(rng.normal(0.2, 0.8))
    skin = np.full((SIDE, SIDE), level, np.float32)
    along = np.arange(SIDE, dtype=np.float32)[:, None] / SIDE
    around = np.arange(SIDE, dtype=np.float32)[None] / SIDE
    for _ in range(rng.choice((0, 0, 1, 2))):
        count, wound = int(rng.integers(1, 9)), int(rng.choice((0, 0, 0, 1, 2)))
        phase = (count * along + wound * around + rng.random()) % 1.0
        skin *= np.where(phase < rng.uniform(0.03, 0.6), math.exp(0.9 * rng.normal()), 1.0)
    if rng.random() < 0.3:
        # One flank is clean and the other is not.
        half = np.sin(2.0 * math.pi * (around + rng.random())) > rng.uniform(-0.5, 0.5)
        skin *= np.where(half, math.exp(0.5 * rng.normal()), 1.0)
    skin *= np.exp(rng.uniform(0.0, 0.5) * _grain(rng))
    if rng.random() < 0.5:
        growth = _grain(rng)
        covered = growth > np.quantile(growth, rng.uniform(0.3, 1.0))
        grown = ground * math.exp(0.5 * rng.normal()) * np.exp(rng.uniform(0.1, 0.6) * _grain(rng))
        skin = np.where(covered, grown, skin)
    return np.clip(skin, 0.01, 1.0).astype(np.float32)


def _grain(rng: np.random.Generator) -> Image:
    """Return noise of mean 0 and standard deviation 1, of any roughness, (SIDE, SIDE)."""
    return _placed(_kept_noise(int(rng.integers(KEPT_NOISES)), 0.5, 2.2, 4.0, 64.0), rng)


def _placed(noise: Image, rng: np.random.Generator) -> Image:
    """Return noise that repeats, moved and turned, so that it may be used again."""
    moved = np.roll(noise, rng.integers(0, SIDE, 2), (0, 1))
    return np.ascontiguousarray(np.rot90(moved, int(rng.integers(4))))


@lru_cache(maxsize=128)
def _kept_noise(seed: int, smooth: float, rough: float, fine: float, coarse: float) -> Image:
    """Return noise of some roughness and coarseness within limits; drawn once for many scenes."""
    rng = np.random.default_rng((seed, 5))
    return _noise(rng.uniform(smooth, rough), fine * (coarse / fine) ** rng.random(), rng)


_FREQUENCIES = np.hypot(*frequencies((SIDE, SIDE), 1.0))


def _noise(slope: float, coarsest: float, rng: np.random.Generator) -> Image:
    """Return noise whose amplitudes fall as a power of the frequency, from a coarsest length on."""
    octaves = coarsest * _FREQUENCIES
    response = np.where(octaves > 1.0, np.maximum(octaves, 1.0) ** -slope, 0.0)
    return spectral_noise(response, (SIDE, SIDE), rng)


def _random_relief(rng: np.random.Generator) -> tuple[Image, Image]:
    """Return heights of a bottom, and how its stones differ in reflected light."""
    bumps = _kept_noise(int(rng.integers(KEPT_NOISES)), 1.5, 2.6, 30.0, 240.0)
    relief = np.float32(0.03 * rng.random() ** 2) * _placed(bumps, rng)
    y, x = np.mgrid[:SIDE, :SIDE].astype(np.float32) / np.float32(SIDE)
    if rng.random() < 0.3:
        relief = relief + _ripples(x, y, rng)
    if rng.random() < FURROWED:
        relief = relief + _furrows(x, y, rng)
    marks = np.zeros_like(relief)
    if rng.random() < 0.45:
        stones, marks = _stones(rng)
        relief = np.maximum(relief, relief * 0.3 + stones)
    return relief.astype(np.float32), marks


def _ripples(x: Image, y: Image, rng: np.random.Generator) -> Image:
    """Return ripples of the sand, warped."""
    over, down = rng.integers(-14, 15), rng.integers(-14, 15)
    warp = rng.uniform(0.0, 1.5) * _placed(_kept_noise(0, 2.5, 2.5, 200.0, 200.0), rng)
    wave = np.sin(2.0 * math.pi * (over * x + down * y) + warp)
    steep = np.float32(rng.uniform(0.0, 0.4))
    sharp = wave + steep * np.cos(2.0 * (2.0 * math.pi * (over * x + down * y) + warp))
    length = 2.0 * BOUNDS / max(math.hypot(over, down), 1.0)
    return np.asarray(rng.uniform(0.01, 0.06) * length * sharp, np.float32)


def _furrows(x: Image, y: Image, rng: np.random.Generator) -> Image:
    """Return straight furrows or ridges, as trawls and anchors leave them."""
    found = np.zeros_like(x)
    angle = 2.0 * math.pi * rng.random()
    across = (x - 0.5) * math.cos(angle) + (y - 0.5) * math.sin(angle)
    for _ in range(rng.integers(1, 4)):
        width = 0.004 * 15.0 ** rng.random()
        off = (across - rng.uniform(-0.25, 0.25)) / width
        profile = np.exp(-0.5 * off**2) - 0.6 * np.exp(-0.5 * ((np.abs(off) - 2.0) / 0.7) ** 2)
        found += rng.choice((-1.0, -1.0, 1.0)) * rng.uniform(0.1, 0.8) * width * profile
    return np.asarray(2.0 * BOUNDS * found * (1.0 + 0.2 * _grain(rng)), np.float32)


def _stones(rng: np.random.Generator) -> tuple[Image, Image]:
    """Return round stones: their heights, and how they differ in reflected light."""
    heights, marks = np.zeros((SIDE, SIDE), np.float32), np.zeros((SIDE, SIDE), np.float32)
    largest = 4.0 * 12.0 ** rng.random()
    flat = rng.uniform(0.3, 1.1)
    for _ in range(round(4.0 * 60.0 ** rng.random())):
        radius = largest * (0.15 + 0.85 * rng.random() ** 2)
        reach = math.ceil(1.5 * radius)
        rows, columns = (
            (int(each) + np.arange(-reach, reach + 1)) % SIDE for each in rng.integers(0, SIDE, 2)
        )
        off = np.arange(-reach, reach + 1, dtype=np.float32) / np.float32(radius)
        turn, thin = math.pi * rng.random(), rng.uniform(0.5, 1.0)
        one = off * math.cos(turn) + off[:, None] * math.sin(turn)
        other = (off[:, None] * math.cos(turn) - off * math.sin(turn)) / thin
        power = rng.choice((2.0, 2.0, 4.0, 8.0))
        cap = np.maximum(1.0 - np.abs(one) ** power - np.abs(other) ** power, 0.0) ** 0.5
        patch = np.ix_(rows, columns)
        heights[patch] = np.maximum(
            heights[patch], flat * radius * np.float32(2.0 * BOUNDS / SIDE) * cap
        )
        marks[patch] = np.where(cap > 0.0, rng.normal(), marks[patch])
    return heights, marks


def _random_albedo(marks: Image, rng: np.random.Generator) -> Image:
    """Return what the bottom reflects: mud, sand, gravel or a photograph of it."""
    if rng.random() < 0.4:
        paths = photographs_of(Split.TUNE)
        whole = photographed_texture(paths[int(rng.integers(len(paths)))])
        texture = cv2.resize(whole, (SIDE, SIDE), interpolation=cv2.INTER_AREA)
        texture = np.roll(texture, rng.integers(0, SIDE, 2), (0, 1))
    else:
        texture = _grain(rng)
    spread = rng.uniform(0.02, 0.5)
    changed = spread * texture + 0.4 * rng.random() * marks
    return np.clip(rng.uniform(0.1, 0.5) * np.exp(changed), 0.01, 1.0).astype(np.float32)


def _random_lamps(rng: np.random.Generator) -> FloatArray:
    """Return lamps: low ones at one side, others about the camera, or as high as the sun."""
    lamps, is_low = [], rng.random() < 0.5
    count = 1 if is_low else int(rng.choice((1, 2, 2, 3)))
    turn = 2.0 * math.pi * rng.random()
    for index in range(count):
        angle = turn + 2.0 * math.pi * index / count + 0.3 * rng.normal()
        if is_low:
            off, height = rng.uniform(0.5, 1.6), rng.uniform(0.3, 1.0)
        elif rng.random() < 0.15:
            off, height = rng.uniform(2.0, 20.0), 12.0
        else:
            off, height = rng.uniform(0.0, 0.6), rng.uniform(0.8, 1.3)
        radius = 0.002 + 0.12 * rng.random() ** 3 * math.hypot(off, height)
        power = (off**2 + height**2) * rng.uniform(0.4, 1.0)
        lamps.append([off * math.cos(angle), off * math.sin(angle), height, power, radius])
    return np.array(lamps)


def expose(light: Image, rng: np.random.Generator) -> Image:
    """Return grey levels, uint8, as a camera exposes them, with its blur and noise."""
    brightest = float(np.quantile(light, rng.uniform(0.9, 0.999))) + 1e-6
    levels = np.minimum(light / np.float32(brightest), 1.5) ** np.float32(rng.uniform(0.5, 1.0))
    levels = np.float32(rng.uniform(80.0, 235.0)) * levels + np.float32(rng.uniform(0.0, 20.0))
    levels = cv2.GaussianBlur(levels, (0, 0), rng.uniform(0.4, 1.0))
    levels += np.float32(4.0 * rng.random()) * rng.standard_normal(levels.shape, np.float32)
    return np.clip(np.round(levels), 0, 255).astype(np.uint8)
