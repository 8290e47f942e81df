"""The sea bed: sand with ripples, stones that cast shadows, algae; and the surface of the cable.

World coordinates belong to the cable: p across it and q along it, both in radii of the cable, so
that its borders lie at p = -1 and p = 1 whatever the altitude of the camera.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.simulation.texture import (
    TiledTexture,
    cloud_response,
    frequencies,
    smooth_step,
    spectral_noise,
)

BED_SIZE = 64
"""Extent of the tile of the bottom, across and along [radii]."""

CABLE_LENGTH = 160
"""Length after which the surface of the cable repeats [radii]."""

CABLE_REACH = 2
"""The texture of the cable covers p = -2 to 2, so that growth can stand out over the borders."""

STONES_PER_AREA = 0.22
"""Stones on a square of one radius."""

LIGHT = (-0.8, 0.6)
"""Where the light comes from, across and along; stones are bright on that side."""


@dataclass(frozen=True, slots=True)
class CableChannels:
    """Names of the channels of the cable's texture, each between 0 and 1."""

    surface: int = 0
    growth: int = 1
    growth_tone: int = 2
    burial: int = 3


CHANNELS = CableChannels()


@dataclass(frozen=True, slots=True)
class Stone:
    """A stone on the bottom.

    Attributes
    ----------
    row, column : float
        Its middle in the tile [texels].
    radius : float
        Of its longer axis [radii of the cable].
    tone : float
        Its reflected light, relative to the bottom's.
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


def make_bed(resolution: int, rng: np.random.Generator) -> TiledTexture:
    """Make a bottom.

    Parameters
    ----------
    resolution : int
        Texels per radius of the cable.

    Returns
    -------
    TiledTexture
        One channel: reflected light, about 0.1 (dark algae) to 0.9 (a white shell).
    """
    side = BED_SIZE * resolution
    shape = (side, side)
    sediment = spectral_noise(cloud_response(shape, resolution, (9.0, 9.0), 0.12), shape, rng)
    height = 0.05 * sediment + _ripples(shape, resolution, rng)
    albedo = 0.31 + 0.045 * sediment
    _strew_stones(height, albedo, resolution, rng)
    algae = _algae(shape, resolution, rng)
    grain = spectral_noise(cloud_response(shape, resolution, (0.25, 0.25), 0.04, 1.0), shape, rng)
    height += 0.012 * grain + 0.05 * algae * grain
    albedo += 0.012 * grain
    albedo *= 1 - algae * (0.45 - 0.1 * grain)
    tile = np.clip(albedo * _relief(height, resolution), 0.03, 0.95)
    return TiledTexture.from_tile(tile.astype(np.float32), resolution)


def make_cable(resolution: int, clutter: float, rng: np.random.Generator) -> TiledTexture:
    """Make the surface of a cable with what grows on it and the sand that buries it.

    Parameters
    ----------
    resolution : int
        Texels per radius of the cable.
    clutter : float
        0 (a clean cable, free everywhere) to 1 (about four tenths of the borders hidden).

    Returns
    -------
    TiledTexture
        Four channels, see `CableChannels`.
    """
    shape = (CABLE_LENGTH * resolution, 2 * CABLE_REACH * resolution)
    small = _cover(shape, resolution, (0.8, 1.5), 0.10 * clutter, rng)
    large = _cover(shape, resolution, (3.0, 4.0), 0.18 * clutter, rng)
    growth = np.maximum(small, large)
    burial = _cover(shape, resolution, (3.0, 9.0), 0.18 * clutter, rng)
    tufts = spectral_noise(cloud_response(shape, resolution, (0.6, 0.6), 0.1, 1.2), shape, rng)
    kinds = spectral_noise(cloud_response(shape, resolution, (5.0, 5.0), 1.0), shape, rng)
    tone = np.clip(0.25 + 0.1 * tufts + 0.05 * kinds, 0.05, 0.7)
    surface = _cable_surface(shape, resolution, clutter, rng)
    channels = np.stack((surface, growth, tone, burial), axis=-1)
    return TiledTexture.from_tile(np.ascontiguousarray(channels, dtype=np.float32), resolution)


def _relief(height: Image, resolution: float) -> Image:
    """Shade a height map [radii] that repeats, by a light that stands obliquely."""
    across = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * (resolution / 2)
    along = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) * (resolution / 2)
    slope = -(LIGHT[0] * across + LIGHT[1] * along)
    return np.clip(1 + 0.55 * np.tanh(slope), 0.25, 1.7)


def _ripples(shape: tuple[int, int], resolution: float, rng: np.random.Generator) -> Image:
    """Return the height of sand ripples, which come and go over the bottom [radii]."""
    direction = rng.uniform(0.0, np.pi)
    wavelength = rng.uniform(1.3, 2.0)
    across, along = frequencies(shape, resolution)
    u = across * np.cos(direction) + along * np.sin(direction)
    v = along * np.cos(direction) - across * np.sin(direction)
    spread = 0.16 / wavelength
    band = np.exp(-((np.abs(u) - 1 / wavelength) ** 2 + (v / 0.8) ** 2) / (2 * spread**2))
    waves = spectral_noise(band, shape, rng)
    patches = spectral_noise(cloud_response(shape, resolution, (20.0, 20.0), 3.0), shape, rng)
    return 0.045 * waves * smooth_step(patches, -0.5, 1.2)


def _strew_stones(height: Image, albedo: Image, resolution: int, rng: np.random.Generator) -> None:
    """Lay stones of all sizes on the bottom, small ones most; changes both maps in place."""
    side = height.shape[0]
    count = int(STONES_PER_AREA * BED_SIZE**2)
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
    u = x * np.cos(turn) + y * np.sin(turn)
    v = (y * np.cos(turn) - x * np.sin(turn)) / stone.stretch
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
    """Return where algae cover the bottom, 0 to 1."""
    patches = spectral_noise(cloud_response(shape, resolution, (7.0, 7.0), 0.15, 1.5), shape, rng)
    return smooth_step(patches, 0.75, 1.9)


def _cover(
    shape: tuple[int, int],
    resolution: float,
    size: tuple[float, float],
    share: float,
    rng: np.random.Generator,
) -> Image:
    """Return patches, 0 to 1, that hide the given share of the two borders' length."""
    noise = spectral_noise(cloud_response(shape, resolution, size, 0.15, 2.2), shape, rng)
    if share <= 0.0:
        return np.zeros(shape, dtype=np.float32)
    borders = noise[:, [shape[1] // 4, 3 * shape[1] // 4]]
    threshold = float(np.quantile(borders, 1 - share))
    # Fade out to the rim of the texture, where it would be cut off along a straight line.
    across = np.abs((np.arange(shape[1]) + 0.5) / resolution - CABLE_REACH)
    noise = noise - (4 * smooth_step(across, 1.3, 1.95)).astype(np.float32)
    return smooth_step(noise, threshold - 0.12, threshold + 0.12)


def _cable_surface(
    shape: tuple[int, int], resolution: float, clutter: float, rng: np.random.Generator
) -> Image:
    """Return the reflected light of the cable's skin: stained, scratched, thinly overgrown."""
    stains = spectral_noise(cloud_response(shape, resolution, (1.5, 5.0), 0.2), shape, rng)
    specks = spectral_noise(cloud_response(shape, resolution, (0.3, 0.5), 0.06, 1.0), shape, rng)
    thin = smooth_step(
        spectral_noise(cloud_response(shape, resolution, (1.0, 3.0), 0.12, 1.4), shape, rng),
        0.2,
        1.4,
    )
    contrast = 0.4 + 0.6 * clutter
    clean = 0.66 - 0.18 * clutter
    surface = clean * (1 + contrast * (0.12 * stains + 0.07 * specks - 0.3 * thin))
    return np.clip(surface, 0.15, 0.95)
