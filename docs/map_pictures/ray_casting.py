"""Rendering of lamplit scenes by ray casting: a tube on, in or above a bottom with a relief.

Lamps light both: flanks that look away from them lie in shadow, and everything throws one. Light
falls off with the square of the distance, is swallowed by the water, and lights the water itself.
Lengths are in heights of the camera above the bottom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numba
import numpy as np

from cable_tracker.arrays import FloatArray, Image

SIZE = 320, 240
"""Columns and rows of a picture [px]."""

SIDE = 512
"""Rows and columns of reliefs and skins, which repeat [texels]."""

BOUNDS = 1.6
"""Half the length of the bottom that a relief spans before it repeats."""

REPEATED = 12.0
"""Length after which a skin repeats [radii]."""

SAMPLES = 6
"""Points of a lamp from which its shadows are cast."""

RELIEF_REACH, RELIEF_STEPS = 0.25, 14
"""How far the shadows of the relief reach, and in how many steps they are looked for."""

MISS = 1e9
"""Length of a ray that meets nothing."""

EYE = 0.0, 0.0, 1.0
"""Position of the camera."""

Vector = tuple[float, float, float]

TubeShape = tuple[Vector, Vector, float, float]
"""Point and direction of the axis, radius and gloss; see `Tube`."""

Water = tuple[float, float, float, float]
"""Ambient light, absorption, scattering and beam; see `Scene`."""


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


def render_scene(scene: Scene) -> tuple[Image, Image]:
    """Return the light of each pixel, float32 (H, W), and which share of it is cable."""
    tube = scene.tube or NO_TUBE
    light, cable = _render(
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
def _point_along(begin: Vector, share: float, way: Vector) -> Vector:
    """Return a point some share of a way from its beginning."""
    return (begin[0] + share * way[0], begin[1] + share * way[1], begin[2] + share * way[2])


@numba.njit(fastmath=True)
def unit_vector(vector: Vector) -> Vector:
    """Return a vector divided by its length."""
    return _point_along((0.0, 0.0, 0.0), 1.0 / max(math.sqrt(_dot(vector, vector)), 1e-9), vector)


@numba.njit(fastmath=True)
def _texel_at(field: Image, x: float, y: float) -> float:
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
def _distance_to_bottom(eye: Vector, ray: Vector, relief: Image) -> float:
    """Return how far along a ray that goes down the bottom is met."""
    far = -eye[2] / ray[2]
    for _ in range(4):
        far = (_texel_at(relief, eye[0] + far * ray[0], eye[1] + far * ray[1]) - eye[2]) / ray[2]
    return far


@numba.njit(fastmath=True)
def _bottom_normal(relief: Image, x: float, y: float) -> Vector:
    texel = 2.0 * BOUNDS / SIDE
    return unit_vector(
        (
            _texel_at(relief, x - texel, y) - _texel_at(relief, x + texel, y),
            _texel_at(relief, x, y - texel) - _texel_at(relief, x, y + texel),
            2.0 * texel,
        )
    )


@numba.njit(fastmath=True)
def _off_axis(point: Vector, axis_point: Vector, axis: Vector) -> tuple[Vector, float]:
    """Return where a point lies from a tube's axis, across it, and along it."""
    off = _point_along(point, -1.0, axis_point)
    along = _dot(off, axis)
    return _point_along(off, -along, axis), along


@numba.njit(fastmath=True)
def _distance_to_tube(
    begin: Vector, ray: Vector, axis_point: Vector, axis: Vector, radius: float
) -> float:
    """Return how far along a ray the tube is first met; MISS if it is not."""
    if radius <= 0.0:
        return MISS
    across, _ = _off_axis(begin, axis_point, axis)
    ray_across = _point_along(ray, -_dot(ray, axis), axis)
    a, b = _dot(ray_across, ray_across), _dot(ray_across, across)
    inside = b * b - a * (_dot(across, across) - radius * radius)
    if inside <= 0.0 or a < 1e-12:
        return MISS
    far = (-b - math.sqrt(inside)) / a
    return far if far > 1e-6 else MISS


@numba.njit(fastmath=True)
def _skin_at(skin: Image, off: Vector, along: float, axis: Vector, radius: float) -> float:
    """Return what a tube reflects at a point off its axis."""
    level = unit_vector((-axis[1], axis[0], 0.0))
    upright = (
        axis[1] * level[2] - axis[2] * level[1],
        axis[2] * level[0] - axis[0] * level[2],
        axis[0] * level[1] - axis[1] * level[0],
    )
    around = math.atan2(_dot(off, level), _dot(off, upright)) / (2.0 * math.pi)
    return _texel_at(skin, around * 2.0 * BOUNDS, along / (REPEATED * radius) * 2.0 * BOUNDS)


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
        seen += (
            _distance_to_tube(begin, _point_along(end, -1.0, begin), axis_point, axis, radius)
            >= 1.0
        )
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
        passed = _point_along(begin, share, way)
        above = _texel_at(relief, passed[0], passed[1]) - passed[2]
        hidden = max(hidden, (above - 0.0005) / (0.002 + share * lamp[4] + 0.003 * walked))
    return 1.0 - min(hidden, 1.0)


@numba.njit(fastmath=True)
def _backscatter(
    eye: Vector, ray: Vector, way: float, lamp: FloatArray, absorption: float
) -> float:
    """Return the light of a lamp that the water on a way throws back."""
    total = 0.0
    for share in (0.2, 0.5, 0.8):
        point = _point_along(eye, share * way, ray)
        off = (point[0] - lamp[0], point[1] - lamp[1], point[2] - lamp[2])
        near = _dot(off, off) + 0.05
        total += lamp[3] / near * math.exp(-absorption * (share * way + math.sqrt(near))) / 3.0
    return total


@numba.njit(fastmath=True)
def _irradiance(
    towards: Vector, away: float, lamp: FloatArray, absorption: float, beam: float
) -> float:
    """Return the light of a lamp at a point that faces it; it is aimed at what is in view."""
    aim = (lamp[0], lamp[1], lamp[2])
    ahead = max(_dot(towards, unit_vector(aim)), 0.0)
    return lamp[3] * ahead**beam / (away * away) * math.exp(-absorption * min(away, 3.0))


@numba.njit(fastmath=True)
def _highlight(towards: Vector, ray: Vector, normal: Vector) -> float:
    """Return how strong a highlight is."""
    half = unit_vector(_point_along(towards, -1.0, ray))
    return max(_dot(half, normal), 0.0) ** 24


@numba.njit(fastmath=True)
def _camera_ray(view: FloatArray, x: float, y: float) -> Vector:
    """Return the direction of a ray from the camera; x right, y down, in focal lengths."""
    return unit_vector(
        (
            view[0, 0] * x + view[0, 1] * y + view[0, 2],
            view[1, 0] * x + view[1, 1] * y + view[1, 2],
            min(view[2, 0] * x + view[2, 1] * y + view[2, 2], -0.1),
        )
    )


@numba.njit(fastmath=True)
def _bottom_at(
    point: Vector, bottom: tuple[Image, Image], off: Vector, radius: float
) -> tuple[Vector, float, float]:
    """Return normal, reflected light and openness to the light from everywhere of the bottom.

    `off`: where the point lies from the axis of a tube of a radius, across it.
    """
    relief, albedo = bottom
    normal = _bottom_normal(relief, point[0], point[1])
    # The tube hides a part of the light from everywhere.
    share_hidden = min(radius * radius / max(_dot(off, off), 1e-9), 1.0)
    openness = (0.5 + 0.5 * normal[2]) * (1.0 - 0.5 * share_hidden)
    return normal, _texel_at(albedo, point[0], point[1]), openness


@numba.njit(fastmath=True)
def _lamp_at(
    point: Vector, normal: Vector, lamp: FloatArray, relief: Image, water: Water
) -> tuple[Vector, float, float]:
    """Return the direction to a lamp, its cosine with the normal, and the light past the relief.

    The light is 0 where the surface faces away from the lamp.
    """
    _, absorption, _, beam = water
    way_up = (lamp[0] - point[0], lamp[1] - point[1], lamp[2] - point[2])
    towards = unit_vector(way_up)
    facing = _dot(towards, normal)
    if facing <= 0.0:
        return towards, facing, 0.0
    strength = _irradiance(towards, math.sqrt(_dot(way_up, way_up)), lamp, absorption, beam)
    return towards, facing, strength * _share_past_relief(point, lamp, relief)


@numba.njit(fastmath=True)
def _render_pixel(  # noqa: PLR0917
    ray: Vector,
    turn: float,
    bottom: tuple[Image, Image],
    tube: TubeShape,
    skin: Image,
    lamps: FloatArray,
    water: Water,
) -> tuple[float, bool]:
    """Return the light along a ray from the camera, and whether it meets the cable.

    `turn`: angle about which the points of each lamp are turned, another for each pixel [rad].
    """
    relief = bottom[0]
    axis_point, axis, radius, gloss = tube
    ambient, absorption, scattering, _ = water
    far = _distance_to_bottom(EYE, ray, relief)
    met = _distance_to_tube(EYE, ray, axis_point, axis, radius)
    way = min(met, far)
    point = _point_along(EYE, way, ray)
    off, along = _off_axis(point, axis_point, axis)
    is_bottom = met >= far
    if is_bottom:
        normal, reflected, openness = _bottom_at(point, bottom, off, radius)
    else:
        normal = unit_vector(off)
        reflected = _skin_at(skin, off, along, axis, radius)
        openness = 0.5 + 0.5 * normal[2]
    received, shine, haze = ambient * openness, 0.0, 0.0
    for lamp in lamps:
        haze += _backscatter(EYE, ray, way, lamp, absorption)
        towards, facing, strength = _lamp_at(point, normal, lamp, relief, water)
        if facing <= 0.0:
            continue
        if is_bottom:
            above = (point[0], point[1], point[2] + 1e-4)
            strength *= _share_past_tube(above, lamp, turn, axis_point, axis, radius)
        else:
            shine += strength * gloss * _highlight(towards, ray, normal)
        received += strength * facing
    seen = (received * reflected + shine) * math.exp(-absorption * way)
    light = seen + 0.2 * scattering * way * (ambient + haze)
    return light, met < -EYE[2] / ray[2]


@numba.njit(fastmath=True)
def _render(  # noqa: PLR0917
    view: FloatArray,
    focal_length: float,
    bottom: tuple[Image, Image],
    tube: TubeShape,
    skin: Image,
    lamps: FloatArray,
    water: Water,
    columns: int,
    rows: int,
) -> tuple[Image, Image]:
    """Return the light of each pixel, and whether it shows the cable, both float32 (H, W)."""
    light = np.zeros((rows, columns), np.float32)
    cable = np.zeros((rows, columns), np.float32)
    for row in range(rows):
        for column in range(columns):
            x = (column - 0.5 * (columns - 1)) / focal_length
            y = (row - 0.5 * (rows - 1)) / focal_length
            ray = _camera_ray(view, x, y)
            turn = 0.7 * (row * 7 + column * 3)
            light[row, column], cable[row, column] = _render_pixel(
                ray, turn, bottom, tube, skin, lamps, water
            )
    return light, cable
