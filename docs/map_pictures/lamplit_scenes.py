"""Scenes in three dimensions that lamps light, for the network that looks at pictures.

A cable is a tube on, in or above a bottom with a relief. Lamps beside the camera, which may be low
and at one side, light both: flanks that look away from them lie in shadow, and everything throws
one. Light falls off with the square of the distance, is swallowed by the water, and lights the
water itself. So shadows fit what throws them, as those that are painted may not. Lengths are in
heights of the camera above the bottom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numba
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.simulation.rendering.camera import chain, rotation_about
from cable_tracker.simulation.rendering.texture import frequencies, spectral_noise
from cable_tracker.simulation.worlds.ground import photographed_texture, photographs_of
from cable_tracker.simulation.worlds.world import Split

SIZE = 320, 240
"""Columns and rows of a picture [px]."""

SIDE = 512
"""Rows and columns of reliefs and skins, which repeat [texels]."""

BOUNDS = 1.6
"""Half the length of the bottom that a relief spans before it repeats."""

EMPTY, FURROWED = 0.2, 0.3
"""Shares of the scenes without a cable, and with furrows or ridges in the bottom. Before its last
5000 steps the network in use saw 14 000 with 0.15 and 0.25 of them, and 4000 with 0.3 and 0.5."""

REPEATED = 12.0
"""Length after which a skin repeats [radii]."""

KEPT_NOISES = 24
"""Number of noises of a kind that are drawn; scenes move and turn them."""

SAMPLES = 6
"""Points of a lamp from which its shadows are cast."""

RELIEF_REACH, RELIEF_STEPS = 0.25, 14
"""How far the shadows of the relief reach, and in how many steps they are looked for."""

NEVER = 1e9
"""Length of a ray that meets nothing."""

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Tube:
    """A cable, straight.

    Attributes
    ----------
    point, direction : Vector
        A point of its axis, and the unit vector along it.
    radius : float
        Half its thickness.
    skin : Image
        Reflected light, (SIDE, SIDE), rows along it, columns around it.
    gloss : float
        Strength of its highlights.
    """

    point: Vector
    direction: Vector
    radius: float
    skin: Image
    gloss: float


NO_TUBE = Tube((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0, np.zeros((1, 1), np.float32), 0.0)
"""No ray meets it."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What is in view, and the light.

    Attributes
    ----------
    view : FloatArray
        Rotation from the camera (x right, y down, z ahead) to the bottom, (3, 3).
    focal_length : float
        [px].
    relief, albedo : Image
        Heights and reflected light of the bottom, each (SIDE, SIDE).
    tube : Tube or None
        None: there is no cable.
    lamps : FloatArray
        Positions, power and radius of the lamps, (L, 5).
    ambient, absorption, scattering : float
        Light from everywhere; per length of the way; light that the water throws back.
    beam : float
        Exponent of the cosine by which a lamp's light falls off from its middle.
    """

    view: FloatArray
    focal_length: float
    relief: Image
    albedo: Image
    tube: Tube | None
    lamps: FloatArray
    ambient: float
    absorption: float
    scattering: float
    beam: float


def lamplit_frame(seed: int) -> tuple[Image, Image]:
    """Return a picture, uint8 (H, W), and which share of each pixel is cable, uint8 to 255."""
    rng = np.random.default_rng((seed, 3))
    while True:
        scene = any_scene(rng)
        light, cable = rendered(scene)
        share = cable.mean()
        # A cable that hardly comes into view, or fills it, teaches nothing.
        if scene.tube is None or 0.01 < share < 0.75:
            return exposed(light, rng), np.round(255.0 * cable).astype(np.uint8)


def any_scene(rng: np.random.Generator) -> Scene:
    """Draw a scene."""
    focal_length = SIZE[0] * rng.uniform(0.6, 1.4)
    view = _any_view(rng)
    relief, marks = _any_relief(rng)
    albedo = _any_albedo(marks, rng)
    tube = (
        None if rng.random() < EMPTY else _any_tube(view, focal_length, float(albedo.mean()), rng)
    )
    return Scene(
        view=view,
        focal_length=focal_length,
        relief=relief,
        albedo=albedo,
        tube=tube,
        lamps=_any_lamps(rng),
        ambient=0.6 * rng.random() ** 3 if rng.random() < 0.7 else 0.0,
        absorption=0.1 + 1.0 * rng.random() ** 2,
        scattering=0.25 * rng.random() ** 3,
        beam=rng.choice((0.0, 1.0, 3.0, 8.0)),
    )


def _any_view(rng: np.random.Generator) -> FloatArray:
    """Return the rotation of a camera that looks down, tilted more or less, and turned."""
    pitch = math.radians(25.0 * rng.random() ** 2 * rng.choice((-1.0, 1.0)))
    roll, turn = math.radians(-4.0 * rng.normal()), 2.0 * math.pi * rng.random()
    down = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    turned, tilted, rolled = (
        rotation_about(axis, np.array([angle]))
        for axis, angle in ((2, turn), (0, pitch), (1, roll))
    )
    return chain(turned, down[None], tilted, rolled)[0]


def _any_tube(
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
        direction=_unit((math.cos(heading), math.sin(heading), rise)),
        radius=radius,
        skin=_any_skin(ground, rng),
        gloss=0.6 * rng.random() ** 2 if rng.random() < 0.4 else 0.0,
    )


def _any_skin(ground: float, rng: np.random.Generator) -> Image:
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


def _any_relief(rng: np.random.Generator) -> tuple[Image, Image]:
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


def _any_albedo(marks: Image, rng: np.random.Generator) -> Image:
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


def _any_lamps(rng: np.random.Generator) -> FloatArray:
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


def rendered(scene: Scene) -> tuple[Image, Image]:
    """Return the light of each pixel, float32 (H, W), and which share of it is cable."""
    tube = scene.tube or NO_TUBE
    light, cable = _rendered(
        scene.view,
        scene.focal_length,
        (scene.relief, scene.albedo),
        (tube.point, tube.direction, tube.radius, tube.gloss),
        tube.skin,
        scene.lamps,
        (scene.ambient, scene.absorption, scene.scattering, scene.beam),
        *SIZE,
    )
    return light, cv2.GaussianBlur(cable, (3, 3), 0.5)


@numba.njit(fastmath=True)
def _dot(first: Vector, second: Vector) -> float:
    return first[0] * second[0] + first[1] * second[1] + first[2] * second[2]


@numba.njit(fastmath=True)
def _ahead(begin: Vector, share: float, way: Vector) -> Vector:
    """Return a point some share of a way from its beginning."""
    return (begin[0] + share * way[0], begin[1] + share * way[1], begin[2] + share * way[2])


@numba.njit(fastmath=True)
def _unit(vector: Vector) -> Vector:
    return _ahead((0.0, 0.0, 0.0), 1.0 / max(math.sqrt(_dot(vector, vector)), 1e-9), vector)


@numba.njit(fastmath=True)
def _at(field: Image, x: float, y: float) -> float:
    """Read a field that repeats every 2 BOUNDS, between its texels."""
    scale = SIDE / (2.0 * BOUNDS)
    column, row = (x + BOUNDS) * scale, (y + BOUNDS) * scale
    left, above = math.floor(column), math.floor(row)
    right_share, below_share = column - left, row - above
    first_row, first_column = int(above) & (SIDE - 1), int(left) & (SIDE - 1)
    next_row, next_column = (first_row + 1) & (SIDE - 1), (first_column + 1) & (SIDE - 1)
    upper = (
        field[first_row, first_column] * (1.0 - right_share)
        + field[first_row, next_column] * right_share
    )
    lower = (
        field[next_row, first_column] * (1.0 - right_share)
        + field[next_row, next_column] * right_share
    )
    return upper * (1.0 - below_share) + lower * below_share


@numba.njit(fastmath=True)
def _bottom_met(eye: Vector, ray: Vector, relief: Image) -> float:
    """Return how far along a ray that goes down the bottom is met."""
    far = -eye[2] / ray[2]
    for _ in range(4):
        far = (_at(relief, eye[0] + far * ray[0], eye[1] + far * ray[1]) - eye[2]) / ray[2]
    return far


@numba.njit(fastmath=True)
def _bottom_normal(relief: Image, x: float, y: float) -> Vector:
    texel = 2.0 * BOUNDS / SIDE
    return _unit(
        (
            _at(relief, x - texel, y) - _at(relief, x + texel, y),
            _at(relief, x, y - texel) - _at(relief, x, y + texel),
            2.0 * texel,
        )
    )


@numba.njit(fastmath=True)
def _off_axis(point: Vector, axis_point: Vector, axis: Vector) -> tuple[Vector, float]:
    """Return where a point lies from a tube's axis, across it, and along it."""
    off = _ahead(point, -1.0, axis_point)
    along = _dot(off, axis)
    return _ahead(off, -along, axis), along


@numba.njit(fastmath=True)
def _tube_met(begin: Vector, ray: Vector, axis_point: Vector, axis: Vector, radius: float) -> float:
    """Return how far along a ray the tube is first met; NEVER if it is not."""
    if radius <= 0.0:
        return NEVER
    across, _ = _off_axis(begin, axis_point, axis)
    ray_across = _ahead(ray, -_dot(ray, axis), axis)
    a, b = _dot(ray_across, ray_across), _dot(ray_across, across)
    inside = b * b - a * (_dot(across, across) - radius * radius)
    if inside <= 0.0 or a < 1e-12:
        return NEVER
    far = (-b - math.sqrt(inside)) / a
    return far if far > 1e-6 else NEVER


@numba.njit(fastmath=True)
def _skin_at(skin: Image, off: Vector, along: float, axis: Vector, radius: float) -> float:
    """Return what a tube reflects at a point off its axis."""
    level = _unit((-axis[1], axis[0], 0.0))
    upright = (
        axis[1] * level[2] - axis[2] * level[1],
        axis[2] * level[0] - axis[0] * level[2],
        axis[0] * level[1] - axis[1] * level[0],
    )
    around = math.atan2(_dot(off, level), _dot(off, upright)) / (2.0 * math.pi)
    return _at(skin, around * 2.0 * BOUNDS, along / (REPEATED * radius) * 2.0 * BOUNDS)


@numba.njit(fastmath=True)
def _share_past_tube(  # noqa: PLR0917
    begin: Vector, lamp: FloatArray, turn: float, axis_point: Vector, axis: Vector, radius: float
) -> float:
    """Return which share of a lamp is seen from the bottom past the tube."""
    seen = 0
    for sample in range(SAMPLES):
        angle = turn + 2.0 * math.pi * sample / SAMPLES
        off = lamp[4] * math.sqrt((sample + 0.5) / SAMPLES)
        end = (
            lamp[0] + off * math.cos(angle),
            lamp[1] + off * math.sin(angle),
            lamp[2] + 0.5 * off * math.sin(2.0 * angle),
        )
        seen += _tube_met(begin, _ahead(end, -1.0, begin), axis_point, axis, radius) >= 1.0
    return seen / SAMPLES


@numba.njit(fastmath=True)
def _share_past_relief(begin: Vector, lamp: FloatArray, relief: Image) -> float:
    """Return which share of a lamp is seen past what rises near a point, softly."""
    way = (lamp[0] - begin[0], lamp[1] - begin[1], lamp[2] - begin[2])
    level = math.hypot(way[0], way[1])
    reach = min(RELIEF_REACH / max(level, 1e-6), 1.0)
    hidden = 0.0
    for step in range(1, RELIEF_STEPS + 1):
        walked = step / RELIEF_STEPS
        share = walked**1.5 * reach
        passed = _ahead(begin, share, way)
        above = _at(relief, passed[0], passed[1]) - passed[2]
        hidden = max(hidden, (above - 0.0005) / (0.002 + share * lamp[4] + 0.003 * walked))
    return 1.0 - min(hidden, 1.0)


@numba.njit(fastmath=True)
def _haze(eye: Vector, ray: Vector, way: float, lamp: FloatArray, absorption: float) -> float:
    """Return the light of a lamp that the water on a way throws back."""
    total = 0.0
    for share in (0.2, 0.5, 0.8):
        point = _ahead(eye, share * way, ray)
        off = (point[0] - lamp[0], point[1] - lamp[1], point[2] - lamp[2])
        near = _dot(off, off) + 0.05
        total += lamp[3] / near * math.exp(-absorption * (share * way + math.sqrt(near))) / 3.0
    return total


@numba.njit(fastmath=True)
def _strength(
    towards: Vector, away: float, lamp: FloatArray, absorption: float, beam: float
) -> float:
    """Return the light of a lamp at a point that faces it; it is aimed at what is in view."""
    aim = (lamp[0], lamp[1], lamp[2])
    ahead = max(_dot(towards, _unit(aim)), 0.0)
    return lamp[3] * ahead**beam / (away * away) * math.exp(-absorption * min(away, 3.0))


@numba.njit(fastmath=True)
def _mirrored(towards: Vector, ray: Vector, normal: Vector) -> float:
    """Return how strong a highlight is."""
    half = _unit(_ahead(towards, -1.0, ray))
    return max(_dot(half, normal), 0.0) ** 24


@numba.njit(fastmath=True)
def _rendered(  # noqa: PLR0917
    view: FloatArray,
    focal_length: float,
    bottom: tuple[Image, Image],
    tube: tuple[Vector, Vector, float, float],
    skin: Image,
    lamps: FloatArray,
    water: tuple[float, float, float, float],
    columns: int,
    rows: int,
) -> tuple[Image, Image]:
    """See `rendered`."""
    relief, albedo = bottom
    axis_point, axis, radius, gloss = tube
    ambient, absorption, scattering, beam = water
    light = np.zeros((rows, columns), np.float32)
    cable = np.zeros((rows, columns), np.float32)
    eye = (0.0, 0.0, 1.0)
    for row in range(rows):
        for column in range(columns):
            x = (column - 0.5 * (columns - 1)) / focal_length
            y = (row - 0.5 * (rows - 1)) / focal_length
            ray = _unit(
                (
                    view[0, 0] * x + view[0, 1] * y + view[0, 2],
                    view[1, 0] * x + view[1, 1] * y + view[1, 2],
                    min(view[2, 0] * x + view[2, 1] * y + view[2, 2], -0.1),
                )
            )
            far = _bottom_met(eye, ray, relief)
            met = _tube_met(eye, ray, axis_point, axis, radius)
            cable[row, column] = met < -eye[2] / ray[2]
            is_bottom = met >= far
            way = min(met, far)
            point = _ahead(eye, way, ray)
            off, along = _off_axis(point, axis_point, axis)
            if is_bottom:
                normal = _bottom_normal(relief, point[0], point[1])
                reflected = _at(albedo, point[0], point[1])
                # The tube hides a part of the light from everywhere.
                share_hidden = min(radius * radius / max(_dot(off, off), 1e-9), 1.0)
                openness = (0.5 + 0.5 * normal[2]) * (1.0 - 0.5 * share_hidden)
            else:
                normal = _unit(off)
                reflected = _skin_at(skin, off, along, axis, radius)
                openness = 0.5 + 0.5 * normal[2]
            received, shine, haze = ambient * openness, 0.0, 0.0
            for lamp in lamps:
                haze += _haze(eye, ray, way, lamp, absorption)
                way_up = (lamp[0] - point[0], lamp[1] - point[1], lamp[2] - point[2])
                towards = _unit(way_up)
                facing = _dot(towards, normal)
                if facing <= 0.0:
                    continue
                strength = _strength(
                    towards, math.sqrt(_dot(way_up, way_up)), lamp, absorption, beam
                )
                strength *= _share_past_relief(point, lamp, relief)
                if is_bottom:
                    above = (point[0], point[1], point[2] + 1e-4)
                    turn = 0.7 * (row * 7 + column * 3)
                    strength *= _share_past_tube(above, lamp, turn, axis_point, axis, radius)
                else:
                    shine += strength * gloss * _mirrored(towards, ray, normal)
                received += strength * facing
            seen = (received * reflected + shine) * math.exp(-absorption * way)
            light[row, column] = seen + 0.2 * scattering * way * (ambient + haze)
    return light, cable


def exposed(light: Image, rng: np.random.Generator) -> Image:
    """Return grey levels, uint8, as a camera exposes them, with its blur and noise."""
    brightest = float(np.quantile(light, rng.uniform(0.9, 0.999))) + 1e-6
    levels = np.minimum(light / np.float32(brightest), 1.5) ** np.float32(rng.uniform(0.5, 1.0))
    levels = np.float32(rng.uniform(80.0, 235.0)) * levels + np.float32(rng.uniform(0.0, 20.0))
    levels = cv2.GaussianBlur(levels, (0, 0), rng.uniform(0.4, 1.0))
    levels += np.float32(4.0 * rng.random()) * rng.standard_normal(levels.shape, np.float32)
    return np.clip(np.round(levels), 0, 255).astype(np.uint8)
