"""The sea bed: sand with ripples, stones that cast shadows, algae, gravel; and a cable's surface.

Coordinates on the bottom are in multiples of `BED_UNIT`. On a cable they are p across and q along
it, both in radii of the cable, so that its borders lie at p = -1 and p = 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.simulation.rendering.appearance import Bottom, Skin
from cable_tracker.simulation.rendering.texture import (
    TiledTexture,
    cloud_response,
    frequencies,
    nearest_places,
    ripple_response,
    smooth_step,
    spectral_noise,
    turned,
)

BED_UNIT = 0.08
"""Unit of the structures of the bottom [m]."""

BED_SIZE = 64
"""Extent of the tile of the bottom, across and along [units]."""

CABLE_LENGTH = 160
"""Length after which the surface of the cable repeats [radii]."""

CABLE_REACH = 2
"""The texture of the cable covers p = -2 to 2, so that growth can stand out over the borders."""

STONES_PER_AREA = 0.22
"""Stones on a square of one unit."""

PEBBLES_PER_AREA = 7.0
"""Pebbles on a square of one unit where the bottom is gravel."""

LAY_SPACING = 0.5
"""Distance between the wires wound around the cable [radii]; divides `CABLE_LENGTH`."""

DRIFT_LENGTHS = (6.0, 20.0)
"""Shortest and longest stretch at which sand lies over one side of a cable [radii]."""

DRIFT_RAMP = 3.0
"""Way over which such sand creeps up the cable and recedes again [radii]."""

MOST_SILT = 0.45
"""A film of silt is never as opaque as to hide a border."""

LARGEST_BULGE = 2.0
"""Crusts are cut off here [standard deviations]."""

NEVER_BURIED = -3.0
"""Level of sand on a cable that lies free everywhere."""

LIGHT = (-0.8, 0.6)
"""Direction of the light, across and along; stones are bright on that side."""


@dataclass(frozen=True, slots=True)
class CableChannels:
    """Names of the channels of the cable's texture.

    All are between 0 and 1 but two: the level of the sand, which covers the cable where it is
    positive (see `burial_cover`), and the outline, by which the visible border is farther out than
    the bare cable's [radii]; the latter depends on the side of the cable alone.
    """

    surface: int = 0
    growth: int = 1
    growth_tone: int = 2
    sand: int = 3
    turf: int = 4
    outline: int = 5


CHANNELS = CableChannels()


@dataclass(frozen=True, slots=True)
class Stone:
    """A stone on the bottom.

    Attributes
    ----------
    row, column : float
        Centre in the tile [texels].
    radius : float
        Radius along the longer axis [units].
    tone : float
        Reflectance relative to the bottom's.
    turn : float
        Direction of its longer axis [rad].
    stretch : float
        Shorter axis over longer axis.
    """

    row: float
    column: float
    radius: float
    tone: float
    turn: float
    stretch: float


def make_bed(resolution: int, bottom: Bottom, rng: np.random.Generator) -> TiledTexture:
    """Make a bottom.

    Parameters
    ----------
    resolution : int
        Texels per unit.

    Returns
    -------
    TiledTexture
        One channel: reflected light, about 0.1 (dark algae) to 0.9 (a white shell).
    """
    side = BED_SIZE * resolution
    shape = (side, side)
    sediment = spectral_noise(cloud_response(shape, resolution, (9.0, 9.0), 0.12), shape, rng)
    ripples = _ripples(shape, resolution, bottom.ripple_angle, rng)
    height = 0.05 * sediment + bottom.ripples * ripples
    albedo = bottom.tone * (1 + 0.145 * sediment)
    if bottom.gravel > 0:
        _spread_gravel(height, albedo, resolution, bottom.gravel, rng)
    _strew_stones(height, albedo, resolution, bottom, rng)
    algae = bottom.algae * _algae(shape, resolution, rng)
    grain = spectral_noise(cloud_response(shape, resolution, (0.25, 0.25), 0.04, 1.0), shape, rng)
    height += 0.012 * grain + 0.05 * algae * grain
    albedo += 0.012 * grain
    albedo *= 1 - np.minimum(algae, 1.3) * (0.45 - 0.1 * grain)
    tile = np.clip(albedo * _relief(height, resolution), 0.03, 0.95)
    return TiledTexture.from_tile(tile.astype(np.float32), resolution)


def make_cable(resolution: int, skin: Skin, rng: np.random.Generator) -> TiledTexture:
    """Make the surface of a cable with what grows on it and beside it and the sand that buries it.

    Parameters
    ----------
    resolution : int
        Texels per radius of the cable.

    Returns
    -------
    TiledTexture
        Six channels, see `CableChannels`; p = -1 and p = 1 are at 1 and 3 across.
    """
    shape = (CABLE_LENGTH * resolution, 2 * CABLE_REACH * resolution)
    small = _patches(shape, resolution, (0.8, 1.5), share=0.10 * skin.cover, crest=0.3, rng=rng)
    large = _patches(shape, resolution, (3.0, 4.0), share=0.18 * skin.cover, crest=0.6, rng=rng)
    sand = _patches(shape, resolution, (3.0, 9.0), share=0.18 * skin.cover, crest=1.4, rng=rng)
    growth = burial_cover(np.maximum(small, large))
    tufts = spectral_noise(cloud_response(shape, resolution, (0.6, 0.6), 0.1, 1.2), shape, rng)
    kinds = spectral_noise(cloud_response(shape, resolution, (5.0, 5.0), 1.0), shape, rng)
    tone = np.clip(0.25 + 0.1 * tufts + 0.05 * kinds, 0.05, 0.7)
    surface = _cable_surface(shape, resolution, skin, rng)
    # What is not asked for draws nothing, and so leaves all that is drawn later as it is.
    turf = _turf(shape, resolution, skin, rng)
    outline = _outline(shape, resolution, skin.bulge, rng)
    if skin.drift > 0.0:
        sand = np.maximum(sand, _drifts(shape, resolution, skin.drift, rng))
    channels = np.stack((surface, growth, tone, sand, turf, outline), axis=-1)
    return TiledTexture.from_tile(np.ascontiguousarray(channels, dtype=np.float32), resolution)


def burial_cover(level: Image) -> Image:
    """Return the cover of a layer at a level above its surroundings, 0 to 1."""
    return smooth_step(level, -0.12, 0.12)


def _relief(height: Image, resolution: float) -> Image:
    """Shade a height map [units] that repeats, by a light that stands obliquely."""
    across = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * (resolution / 2)
    along = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) * (resolution / 2)
    slope = -(LIGHT[0] * across + LIGHT[1] * along)
    return np.clip(1 + 0.55 * np.tanh(slope), 0.25, 1.7)


def _ripples(
    shape: tuple[int, int], resolution: float, angle: float | None, rng: np.random.Generator
) -> Image:
    """Return the height of sand ripples, which come and go over the bottom [units].

    `angle` is that of the crests from the course of the cable [deg]; None: any.
    """
    drawn = rng.uniform(0.0, np.pi)
    direction = drawn if angle is None else float(np.deg2rad(angle))
    wavelength = rng.uniform(1.3, 2.0)
    u, v = turned(*frequencies(shape, resolution), direction)
    waves = spectral_noise(ripple_response(u, v, wavelength, (0.16, 0.8)), shape, rng)
    patches = spectral_noise(cloud_response(shape, resolution, (20.0, 20.0), 3.0), shape, rng)
    return 0.045 * waves * smooth_step(patches, -0.5, 1.2)


def _spread_gravel(
    height: Image, albedo: Image, resolution: int, share: float, rng: np.random.Generator
) -> None:
    """Cover part of the bottom with pebbles side by side; changes both maps in place."""
    side = height.shape[0]
    places = rng.integers(0, side, (int(PEBBLES_PER_AREA * BED_SIZE**2), 2))
    tones = rng.normal(1.0, 0.28, (side, side)).clip(0.4, 1.8)
    distance, pebbles = nearest_places(places, side, 2 * resolution, tones)
    size = resolution / np.sqrt(PEBBLES_PER_AREA)
    apart = distance / size
    dome = np.sqrt(np.clip(1 - (apart / 0.85) ** 2, 0.0, 1.0))
    beds = spectral_noise(
        cloud_response((side, side), resolution, (14.0, 14.0), 1.0), (side, side), rng
    )
    where = smooth_step(beds, 1.6 - 3.2 * share, 2.2 - 3.2 * share)
    tone = pebbles * (0.55 + 0.45 * dome)
    height += where * 0.12 * dome
    albedo *= 1 + where * (tone - 1)


def _strew_stones(
    height: Image, albedo: Image, resolution: int, bottom: Bottom, rng: np.random.Generator
) -> None:
    """Lay stones of all sizes on the bottom, small ones most; changes both maps in place."""
    side = height.shape[0]
    count = int(STONES_PER_AREA * BED_SIZE**2 * bottom.stones)
    radii = np.minimum(0.1 * (1 + rng.pareto(1.9, count)), 1.6)
    # Stones gather in fields and leave sand between them.
    field = rng.uniform(0, side, (10, 2))
    gathered = field[rng.integers(0, 10, count)] + rng.normal(0.0, 0.1 * side, (count, 2))
    anywhere = rng.uniform(0, side, (count, 2))
    centres = np.where(rng.random((count, 1)) < 0.55, gathered, anywhere)
    tones = np.clip(rng.normal(1.1, 0.3, count), 0.5, 2.4)
    turns = rng.uniform(0.0, np.pi, count)
    stretches = rng.uniform(0.65, 1.0, count)
    for values in np.column_stack((centres, radii, tones, turns, stretches)):
        _lay_stone(height, albedo, Stone(*values), resolution)


def _lay_stone(height: Image, albedo: Image, stone: Stone, resolution: int) -> None:
    side = height.shape[0]
    radius, turn = stone.radius * resolution, stone.turn
    reach = int(1.9 * radius) + 2
    offsets = np.arange(-reach, reach + 1)
    row, column = int(stone.row), int(stone.column)
    patch = np.ix_((row + offsets) % side, (column + offsets) % side)
    y = (offsets - (stone.row - row))[:, None] / radius
    x = (offsets - (stone.column - column))[None, :] / radius
    u, v = turned(x, y, turn)
    v /= stone.stretch
    bearing = np.arctan2(v, u)
    outline = 1 + 0.12 * np.sin(3 * bearing + 7 * turn) + 0.06 * np.sin(5 * bearing + 3 * turn)
    distance = np.hypot(u, v) / outline
    soft = max(1.0 / radius, 0.12)
    body = 1 - smooth_step(distance, 1 - soft, 1 + soft)
    shade = np.hypot(x + 0.35 * LIGHT[0], y + 0.35 * LIGHT[1])
    shadow = 0.5 * (1 - smooth_step(shade, 0.7, 1.5)) * (1 - body)
    dome = np.sqrt(np.clip(1.15 - np.minimum(distance, 1.0) ** 2, 0.0, None))
    height[patch] += 0.35 * stone.radius * dome * body
    albedo[patch] = albedo[patch] * (1 - shadow) * (1 + (stone.tone - 1) * body)


def _algae(shape: tuple[int, int], resolution: float, rng: np.random.Generator) -> Image:
    """Return the cover of algae, 0 to 1."""
    patches = spectral_noise(cloud_response(shape, resolution, (7.0, 7.0), 0.15, 1.5), shape, rng)
    return smooth_step(patches, 0.75, 1.9)


def _patches(
    shape: tuple[int, int],
    resolution: float,
    size: tuple[float, float],
    *,
    share: float,
    crest: float,
    rng: np.random.Generator,
) -> Image:
    """Return the level of patches that hide the given share of the two borders' length.

    `crest` is how much higher they must be to cover the top of the cable.
    """
    noise = spectral_noise(cloud_response(shape, resolution, size, 0.15, 2.2), shape, rng)
    if share <= 0.0:
        return np.asarray(NEVER_BURIED + np.float32(0.3) * np.clip(noise, -2, 2))
    borders = noise[:, _border_columns(shape)]
    threshold = np.float32(np.quantile(borders, 1 - share))
    # Fade out to the rim of the texture, where it would be cut off along a straight line.
    across = np.abs((np.arange(shape[1]) + 0.5) / resolution - CABLE_REACH)
    lowered = 4 * smooth_step(across, 1.3, 1.95) + crest * np.sqrt(np.clip(1 - across**2, 0, 1))
    return np.asarray(noise - threshold - lowered.astype(np.float32))


def _turf(shape: tuple[int, int], resolution: int, skin: Skin, rng: np.random.Generator) -> Image:
    """Return the cover of growth and sediment that resemble the bottom, 0 to 1."""
    turf = np.zeros(shape, dtype=np.float32)
    if skin.silt > 0.0:
        film = spectral_noise(cloud_response(shape, resolution, (2.0, 4.0), 0.15), shape, rng)
        turf = np.clip(np.float32(skin.silt) * (1 + 0.35 * film), 0.0, MOST_SILT)
    if skin.turf > 0.0:
        level = _patches(shape, resolution, (2.5, 5.0), share=skin.turf, crest=0.2, rng=rng)
        turf = np.maximum(turf, smooth_step(level, -0.3, 0.3))
    return turf


def _outline(
    shape: tuple[int, int], resolution: int, bulge: float, rng: np.random.Generator
) -> Image:
    """Return the outward shift of each border by crusts, constant across its side [radii]."""
    if bulge <= 0.0:
        return np.zeros(shape, dtype=np.float32)
    crusts = spectral_noise(cloud_response(shape, resolution, (1.5, 1.5), 0.12), shape, rng)
    borders = np.clip(crusts[:, _border_columns(shape)], -LARGEST_BULGE, LARGEST_BULGE)
    return np.asarray(np.float32(bulge) * np.repeat(borders, shape[1] // 2, axis=1))


def _drifts(
    shape: tuple[int, int], resolution: int, share: float, rng: np.random.Generator
) -> Image:
    """Return the level of sand that has drifted over one side of the cable, here and there."""
    level = np.full(shape, NEVER_BURIED, dtype=np.float32)
    p = ((np.arange(shape[1]) + 0.5) / resolution - CABLE_REACH).astype(np.float32)
    q = ((np.arange(shape[0]) + 0.5) / resolution).astype(np.float32)
    waves = spectral_noise(cloud_response(shape, resolution, (3.0, 3.0), 0.3), shape, rng)
    bare = float(np.mean(DRIFT_LENGTHS)) * (1 / share - 1)
    place = float(rng.uniform(0.0, bare))
    while place + DRIFT_LENGTHS[0] < CABLE_LENGTH:
        length = float(min(rng.uniform(*DRIFT_LENGTHS), CABLE_LENGTH - place))
        side, highest = float(rng.choice((-1, 1))), float(rng.uniform(-0.1, 0.65))
        risen = smooth_step(q, place, place + DRIFT_RAMP)
        risen = risen - smooth_step(q, place + length - DRIFT_RAMP, place + length)
        edge = highest + 0.13 * waves + (1 - risen[:, None]) * (2.5 - highest)
        level = np.maximum(level, side * p[None, :] - edge)
        place += length + bare * float(rng.uniform(0.5, 1.5))
    return level


def _border_columns(shape: tuple[int, int]) -> list[int]:
    """Return the columns of p = -1 and p = 1 in the texture of a cable."""
    return [shape[1] // 4, 3 * shape[1] // 4]


def _cable_surface(
    shape: tuple[int, int], resolution: float, skin: Skin, rng: np.random.Generator
) -> Image:
    """Return the reflected light of the cable's skin: wound, stained, thinly overgrown."""
    stains = spectral_noise(cloud_response(shape, resolution, (1.2, 2.5), 0.15), shape, rng)
    specks = spectral_noise(cloud_response(shape, resolution, (0.3, 0.4), 0.06, 1.0), shape, rng)
    fouled = spectral_noise(cloud_response(shape, resolution, (1.5, 4.0), 0.1, 1.3), shape, rng)
    thin = smooth_step(fouled, 0.3, 1.6)
    pattern = 0.09 * stains + 0.06 * specks - 0.25 * thin + 0.05 * _lay(shape, resolution)
    return np.asarray(np.clip(skin.tone * (1 + skin.stains * pattern), 0.04, 0.95))


def _lay(shape: tuple[int, int], resolution: float) -> Image:
    """Return the pattern of wires wound around the cable, -1 to 1."""
    p = (np.arange(shape[1]) + 0.5) / resolution - CABLE_REACH
    q = (np.arange(shape[0]) + 0.5) / resolution
    turn = np.arcsin(np.clip(p, -1.0, 1.0))
    return np.asarray(np.sin(2 * np.pi * (q[:, None] / LAY_SPACING + 1.2 * turn[None, :])))
