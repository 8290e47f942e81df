"""Ground under and beside the cable: textures of mean 0 and standard deviation 1, made once.

The two splits have no kind of made texture in common, and no photograph.
"""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.errors import RecordingError
from cable_tracker.simulation.rendering.photographs import find_photographs, read_photograph
from cable_tracker.simulation.rendering.texture import (
    cloud_response,
    frequencies,
    nearest_places,
    ripple_response,
    smooth_step,
    spectral_noise,
    turned,
)
from cable_tracker.simulation.worlds.catalogue import Split

SIDE = 768
"""Rows and columns of a made texture [texels], about pixels of an image 320 px wide."""

VARIANTS = 3
"""Textures of each kind."""

PHOTOGRAPH_WIDTH = 640
"""Width of a photograph as a texture [texels]."""

CLIPPED = 3.0
"""Largest absolute value of textures [standard deviations]."""

FOLDER_VARIABLE = "CABLE_TRACKER_SEABED"
"""Environment variable that names the folder of photographs."""

KINDS = {
    Split.TUNE: ("clouds", "ripples", "stones"),
    Split.REPORT: ("cobbles", "grass", "ridges"),
}
"""Kinds of made textures."""


def photographs_folder() -> Path:
    """Return the folder of photographs of a sea bed.

    It is what the environment variable `FOLDER_VARIABLE` names, else ``../shared/data/seabed``
    beside the source checkout.

    Raises
    ------
    RecordingError
        There is no such folder.
    """
    named = os.environ.get(FOLDER_VARIABLE)
    beside = Path(__file__).resolve().parents[4] / "shared" / "data" / "seabed"
    folder = Path(named) if named else beside
    if not folder.is_dir():
        raise RecordingError(
            f"{folder} is no folder of photographs of a sea bed: name one with the environment"
            f" variable {FOLDER_VARIABLE}, or leave out the worlds that need it"
        )
    return folder


@lru_cache(maxsize=24)
def made_texture(split: Split, kind: str, variant: int) -> Image:
    """Return a texture that repeats, float32, shape (SIDE, SIDE).

    Parameters
    ----------
    split : Split
        Part of the seed.
    kind : str
        One of the kinds of the split.
    variant : int
        Number of the texture of that kind.
    """
    rng = np.random.default_rng((split.number, KINDS[split].index(kind), variant))
    return _normalised(_MAKERS[kind](rng))


@lru_cache(maxsize=12)
def photographed_texture(path: Path) -> Image:
    """Return a photograph as a texture that repeats by mirror images, float32.

    Light, bright red man-made things and black gloves are taken out of it.

    Raises
    ------
    RecordingError
        The file is no picture, or cannot be read.
    """
    picture = read_photograph(path, cv2.IMREAD_COLOR)
    if picture is None:
        raise RecordingError(f"{path} is no readable photograph: take it out of its folder")
    height = round(PHOTOGRAPH_WIDTH * picture.shape[0] / picture.shape[1])
    picture = cv2.resize(picture, (PHOTOGRAPH_WIDTH, height), interpolation=cv2.INTER_AREA)
    objects = _man_made(picture)
    values = _flat(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(np.float32), objects)
    upper = np.hstack((values, values[:, ::-1]))
    return np.ascontiguousarray(np.vstack((upper, upper[::-1])))


def photographs_of(split: Split) -> tuple[Path, ...]:
    """Return the photographs of a split: the first two fifths of all, or the last.

    What lies between belongs to neither: successive photographs may show the same place.

    Raises
    ------
    RecordingError
        There are fewer than five, or their folder cannot be read.
    """
    folder = photographs_folder()
    paths = find_photographs(folder)
    count = 2 * len(paths) // 5
    if count < 2:
        raise RecordingError(f"{folder} holds {len(paths)} photographs: give at least 5")
    return tuple(paths[:count] if split is Split.TUNE else paths[-count:])


def random_texture(split: Split, photographed: bool, rng: np.random.Generator) -> Image:
    """Draw one of the textures of a split.

    Raises
    ------
    RecordingError
        A photograph is wanted and cannot be had.
    """
    if photographed:
        paths = photographs_of(split)
        return photographed_texture(paths[int(rng.integers(len(paths)))])
    kinds = KINDS[split]
    return made_texture(split, kinds[int(rng.integers(len(kinds)))], int(rng.integers(VARIANTS)))


def sample_texture(texture: Image, x: Image, y: Image) -> Image:
    """Sample a repeating texture at places [texels], float32 arrays of one shape."""
    rows, columns = texture.shape
    return cv2.remap(
        texture, _wrap(x, columns), _wrap(y, rows), cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP
    )


def _wrap(places: Image, period: int) -> Image:
    """Return places within one period; much faster than `numpy.mod`."""
    turns = places * np.float32(1.0 / period)
    np.floor(turns, out=turns)
    turns *= np.float32(-period)
    turns += places
    return turns


def _normalised(values: Image | FloatArray) -> Image:
    values = values - values.mean()
    clipped = np.clip(values / values.std(), -CLIPPED, CLIPPED)
    return np.asarray((clipped - clipped.mean()) / clipped.std(), dtype=np.float32)


def _man_made(picture: Image) -> Image:
    """Return a mask of red and black objects in a colour photograph, uint8 0 or 1."""
    blue, green, red = (picture[..., channel].astype(np.int16) for channel in range(3))
    objects = ((red - green > 25) & (red > 90)) | (np.maximum(np.maximum(red, green), blue) < 14)
    mask = cv2.morphologyEx(objects.astype(np.uint8), cv2.MORPH_OPEN, np.ones((5, 5), np.uint8))
    return cv2.dilate(mask, np.ones((25, 25), np.uint8))


def _flat(values: Image, objects: Image) -> Image:
    """Take uneven light and masked objects out of a picture; other parts of it fill the gaps."""
    valid = (1 - objects).astype(np.float32)
    reach = values.shape[1] / 8

    def smooth(each: Image) -> Image:
        share = cv2.GaussianBlur(valid, (0, 0), reach)
        return np.asarray(cv2.GaussianBlur(each * valid, (0, 0), reach) / np.maximum(share, 1e-3))

    rest = values - smooth(values)
    rest /= np.maximum(np.sqrt(smooth(rest * rest)), 2.0)
    blend = cv2.GaussianBlur(valid, (0, 0), 3.0) * valid
    for shift in (0.5, 0.3, 0.7, 0.15):
        moved = np.roll(rest, round(shift * rest.shape[1]), axis=1)
        usable = np.roll(valid, round(shift * rest.shape[1]), axis=1)
        rest = np.where((blend < 1) & (usable > 0), blend * rest + (1 - blend) * moved, rest)
        blend = np.where(usable > 0, np.float32(1.0), blend).astype(np.float32)
    return _normalised(np.where(blend > 0, rest, 0.0))


def _noise(largest: float, smallest: float, slope: float, rng: np.random.Generator) -> Image:
    shape = (SIDE, SIDE)
    return spectral_noise(
        cloud_response(shape, 1.0, (largest, largest), smallest, slope), shape, rng
    )


def _clouds(rng: np.random.Generator) -> Image:
    return _noise(60.0, 1.0, 1.2, rng) + 0.5 * _noise(6.0, 1.0, 1.4, rng)


def _ripples(rng: np.random.Generator) -> Image:
    direction, wavelength = rng.uniform(0.0, np.pi), rng.uniform(12.0, 22.0)
    u, v = turned(*frequencies((SIDE, SIDE), 1.0), direction)
    waves = spectral_noise(ripple_response(u, v, wavelength, (0.2, 0.7)), (SIDE, SIDE), rng)
    return waves + 0.7 * _noise(40.0, 1.0, 1.2, rng)


def _stones(rng: np.random.Generator) -> Image:
    stones = smooth_step(_noise(14.0, 2.5, 2.4, rng), 0.7, 1.1)
    tones = 1.0 + 0.8 * _noise(18.0, 4.0, 2.0, rng)
    shadow = np.roll(stones, (3, 4), axis=(0, 1)) * (1 - stones)
    sand = _noise(50.0, 0.8, 1.1, rng)
    return np.asarray(1.3 * stones * tones - 1.2 * shadow + 0.6 * sand)


def _cobbles(rng: np.random.Generator) -> Image:
    count = int(rng.integers(1500, 5000))
    places = rng.integers(0, SIDE, (count, 2))
    tones = rng.standard_normal((SIDE, SIDE)).astype(np.float32)
    distance, tone = nearest_places(places, SIDE, 64, tones)
    apart = distance / (SIDE / np.sqrt(count))
    return np.asarray(0.6 * tone - 2.0 * apart + 0.4 * _noise(80.0, 1.0, 1.2, rng))


def _grass(rng: np.random.Generator) -> Image:
    total = np.zeros((SIDE, SIDE), np.float32)
    for _ in range(4):
        u, v = turned(*frequencies((SIDE, SIDE), 1.0), rng.uniform(0.0, np.pi))
        blades = np.exp(-((u * 2.2) ** 2) - (v * 22.0) ** 2) * (1 - np.exp(-((u * 14.0) ** 2)))
        where = smooth_step(_noise(70.0, 8.0, 2.0, rng), -0.5, 1.5)
        total += spectral_noise(blades, (SIDE, SIDE), rng) * where
    return total + 0.35 * _noise(90.0, 1.0, 1.3, rng)


def _ridges(rng: np.random.Generator) -> Image:
    coarse, fine = (1 - np.abs(_noise(size, 5.0, 2.2, rng)) for size in (60.0, 24.0))
    height = coarse + 0.5 * fine
    slope = 2 * height - np.roll(height, 2, axis=0) - np.roll(height, 2, axis=1)
    return np.asarray(np.tanh(3.0 * slope) + 0.3 * height + 0.15 * _noise(5.0, 1.0, 1.0, rng))


_MAKERS = {
    "clouds": _clouds,
    "ripples": _ripples,
    "stones": _stones,
    "cobbles": _cobbles,
    "grass": _grass,
    "ridges": _ridges,
}
