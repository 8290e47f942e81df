"""A sea bed made of the user's own photographs."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.errors import RecordingError, read_failure
from cable_tracker.sequences.pictures.image_folder import find_pictures
from cable_tracker.simulation.rendering.seabed import BED_SIZE
from cable_tracker.simulation.rendering.texture import TiledTexture, smooth_step

PHOTOGRAPH_WIDTH = 22.0
"""Width of the bottom that one photograph shows [units]."""

LARGEST_COUNT = 12
"""Largest number of photographs that are read."""

CONTRAST = 0.3
"""Standard deviation of the bottom's reflected light, relative to its mean."""


def make_photographed_bed(
    folder: Path, resolution: int, tone: float, rng: np.random.Generator
) -> TiledTexture:
    """Make a bottom of pieces of photographs that overlap softly.

    Parameters
    ----------
    folder : Path
        Holds the pictures; other files are passed over.
    resolution : int
        Texels per unit.
    tone : float
        Mean reflected light, 0 to 1.

    Raises
    ------
    RecordingError
        The folder holds no picture that can be read.
    """
    pictures = _load_pictures(folder, resolution, rng)
    side = BED_SIZE * resolution
    total = np.zeros((side, side), dtype=np.float32)
    weights = np.zeros((side, side), dtype=np.float32)
    squares = np.zeros((side, side), dtype=np.float32)
    step = max(int(0.45 * min(pictures[0].shape)), 1)
    for row in range(0, side, step):
        for column in range(0, side, step):
            picture = pictures[int(rng.integers(len(pictures)))]
            picture = np.rot90(picture, int(rng.integers(4)))
            weight = _soft_edges(picture.shape)
            rows = (row + np.arange(picture.shape[0]) + int(rng.integers(step))) % side
            columns = (column + np.arange(picture.shape[1]) + int(rng.integers(step))) % side
            patch = np.ix_(rows, columns)
            total[patch] += weight * picture
            weights[patch] += weight
            squares[patch] += weight * weight
    # Dividing by the root of the squares keeps the contrast where pieces overlap.
    mixed = total / np.sqrt(np.maximum(squares, 1e-6))
    mixed *= np.minimum(weights * 4, 1)
    tile = np.clip(tone * (1 + CONTRAST * mixed), 0.03, 0.95).astype(np.float32)
    return TiledTexture.from_tile(tile, resolution)


def find_photographs(folder: Path) -> list[Path]:
    """Return the photographs of a folder, sorted by their paths.

    Raises
    ------
    RecordingError
        The folder cannot be read.
    """
    try:
        return sorted(find_pictures(folder))
    except OSError as error:
        raise read_failure(folder, error) from error


def read_photograph(path: Path, flags: int) -> Image | None:
    """Return a photograph read with OpenCV's `IMREAD_*`; None if it cannot be read or decoded."""
    try:
        data = np.frombuffer(path.read_bytes(), np.uint8)
        picture = cv2.imdecode(data, flags) if data.size else None
    except (OSError, cv2.error):
        return None
    return None if picture is None else np.asarray(picture)


def _load_pictures(folder: Path, resolution: int, rng: np.random.Generator) -> list[Image]:
    if not folder.is_dir():
        raise RecordingError(f"{folder} is not a folder: give one that holds photographs")
    paths = find_photographs(folder)
    chosen = [paths[place] for place in rng.permutation(len(paths))[:LARGEST_COUNT]]
    pictures = []
    for path in chosen:
        picture = read_photograph(path, cv2.IMREAD_GRAYSCALE)
        if picture is not None and min(picture.shape) >= 32:
            pictures.append(_flatten(picture, resolution))
    if not pictures:
        raise RecordingError(f"{folder} holds no readable photographs: give PNG or JPEG pictures")
    return pictures


def _flatten(picture: Image, resolution: int) -> Image:
    """Take the lighting out of a photograph: mean 0, standard deviation 1 everywhere."""
    width = round(PHOTOGRAPH_WIDTH * resolution)
    height = round(width * picture.shape[0] / picture.shape[1])
    values = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA).astype(np.float32)
    values -= cv2.GaussianBlur(values, (0, 0), width / 6)
    spread = np.sqrt(cv2.GaussianBlur(values * values, (0, 0), width / 4))
    return np.clip(values / np.maximum(spread, 2.0), -3.0, 3.0)


def _soft_edges(shape: tuple[int, ...]) -> Image:
    rows, columns = (
        smooth_step(np.minimum(np.arange(n) + 1, n - np.arange(n)) / n, 0.0, 0.3) for n in shape[:2]
    )
    return (rows[:, None] * columns[None, :]).astype(np.float32)
