"""Endless textures: tiles that repeat without a seam, sampled without aliasing at any scale."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray

LEVELS = 4
"""Number of resolutions of a tile, each half as fine as the one before."""

MARGIN = 2
"""Texels repeated around each tile, so that interpolation never reaches across its edge."""


def spectral_noise(response: Image, shape: tuple[int, int], rng: np.random.Generator) -> Image:
    """Filter white noise into a tile that repeats in both directions.

    Parameters
    ----------
    response : Image
        Gain for each frequency, shape (rows, columns // 2 + 1), as `frequencies` lays them out.
    shape : (int, int)
        Rows and columns of the tile.

    Returns
    -------
    Image
        Float32, shape (rows, columns), mean 0 and standard deviation 1.
    """
    white = rng.standard_normal(shape, dtype=np.float32)
    spectrum = np.fft.rfft2(white) * response
    spectrum[0, 0] = 0.0
    noise: Image = np.fft.irfft2(spectrum, s=shape)
    return np.asarray(noise / noise.std(), dtype=np.float32)


def frequencies(shape: tuple[int, int], resolution: float) -> tuple[FloatArray, FloatArray]:
    """Return the frequencies along columns and rows of a real spectrum [cycles per unit length].

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the tile.
    resolution : float
        Texels per unit length.

    Returns
    -------
    (FloatArray, FloatArray)
        Across, shape (1, columns // 2 + 1), and along, shape (rows, 1).
    """
    across: FloatArray = np.fft.rfftfreq(shape[1], 1 / resolution)[None, :].astype(np.float64)
    along: FloatArray = np.fft.fftfreq(shape[0], 1 / resolution)[:, None].astype(np.float64)
    return across, along


def cloud_response(
    shape: tuple[int, int],
    resolution: float,
    largest: tuple[float, float],
    smallest: float,
    slope: float = 1.6,
) -> FloatArray:
    """Return the response of noise in many octaves, for `spectral_noise`.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the tile.
    resolution : float
        Texels per unit length.
    largest : (float, float)
        Size of the largest structures across and along.
    smallest : float
        Size of the smallest structures.
    slope : float
        Decay of the amplitude with frequency; larger is smoother.
    """
    across, along = frequencies(shape, resolution)
    radius = np.hypot(across * largest[0], along * largest[1])
    fine = np.hypot(across, along) * smallest
    response: FloatArray = (1 + radius**2) ** (-slope / 2) * np.exp(-(fine**2))
    return response


def ripple_response(
    u: FloatArray, v: FloatArray, wavelength: float, spread: tuple[float, float]
) -> FloatArray:
    """Return the response of noise in waves to frequencies across and along their crests.

    `spread` is that of u, over the frequency of the waves, and how many times as far v spreads.
    """
    width = spread[0] / wavelength
    deviation = (np.abs(u) - 1 / wavelength) ** 2 + (v / spread[1]) ** 2
    response: FloatArray = np.exp(-deviation / (2 * width**2))
    return response


def turned(x: Image, y: Image, angle: float) -> tuple[Image, Image]:
    """Return coordinates in axes that are turned by an angle [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    return x * cos + y * sin, y * cos - x * sin


def in_rows(indices: IndexArray, length: int) -> IndexArray:
    """Return indices (K,) in rows of one length, the last index repeated to fill up; K at least 1.

    OpenCV takes no arrays of more than 32 766 columns, and arrays of one shape give the same
    numbers.
    """
    missing = -indices.size % length
    return np.append(indices, np.full(missing, indices[-1])).reshape(-1, length)


def nearest_places(places: Image, side: int, margin: int, tones: Image) -> tuple[Image, Image]:
    """Return the distance of the nearest of some places, and its tone, in a tile that repeats.

    Parameters
    ----------
    places : Image
        Rows and columns of the places, shape (K, 2) [texels].
    side : int
        Rows and columns of the tile.
    margin : int
        Places farther away than this need not be found beyond an edge [texels].
    tones : Image
        Tone of a place at each texel, shape (side, side).

    Returns
    -------
    (Image, Image)
        Distances [texels] and tones, shape (side, side).
    """
    seeds = np.full((side, side), 255, np.uint8)
    seeds[places[:, 0], places[:, 1]] = 0
    wrapped = cv2.copyMakeBorder(seeds, margin, margin, margin, margin, cv2.BORDER_WRAP)
    distance, labels = cv2.distanceTransformWithLabels(
        wrapped, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    # A place at the tile's edge has another label on the far side: its tone goes by its place.
    rows, columns = np.nonzero(wrapped == 0)
    by_label = np.ones(int(labels.max()) + 1, tones.dtype)
    by_label[labels[rows, columns]] = tones[(rows - margin) % side, (columns - margin) % side]
    middle = slice(margin, margin + side)
    return distance[middle, middle], by_label[labels[middle, middle]]


def smooth_step(values: Image, low: float, high: float) -> Image:
    """Rise smoothly from 0 below `low` to 1 above `high`, element by element."""
    share = np.clip((values - low) / (high - low), 0.0, 1.0)
    return share * share * (3 - 2 * share)


@dataclass(frozen=True, slots=True, eq=False)
class TiledTexture:
    """A tile that repeats for ever, kept at several scales.

    Attributes
    ----------
    levels : tuple of Image
        The tile with `MARGIN` repeated texels around it, float32, each level half as fine as the
        one before it.
    size : (float, float)
        Extent of the tile across and along [units of the world].
    """

    levels: tuple[Image, ...]
    size: tuple[float, float]

    @classmethod
    def from_tile(cls, tile: Image, resolution: float) -> TiledTexture:
        """Make a texture of a float32 tile, (rows, columns) or (rows, columns, channels).

        Rows run along and columns across the cable; both must be divisible by
        ``2 ** (LEVELS - 1)``. `resolution` is in texels per unit of the world.
        """
        rows, columns = tile.shape[:2]
        levels = []
        for _ in range(LEVELS):
            levels.append(cv2.copyMakeBorder(tile, MARGIN, MARGIN, MARGIN, MARGIN, cv2.BORDER_WRAP))
            half = (tile.shape[1] // 2, tile.shape[0] // 2)
            tile = cv2.resize(tile, half, interpolation=cv2.INTER_AREA)
        return cls(tuple(levels), (columns / resolution, rows / resolution))

    def sample(self, across: Image, along: Image, shift: float, footprint: Image) -> Image:
        """Sample the texture.

        Parameters
        ----------
        across, along : Image
            Where, float32, shape (H, W) [units of the world].
        shift : float
            Added to `along`, however large.
        footprint : Image
            Extent of one pixel, float32, shape (H, W) [units of the world].

        Returns
        -------
        Image
            Float32, (H, W) or (H, W, channels).
        """
        columns = self.levels[0].shape[1] - 2 * MARGIN
        scale = columns / self.size[0]
        u = np.mod(across / self.size[0], np.float32(1.0))
        v = np.mod((along + np.float32(shift % self.size[1])) / self.size[1], np.float32(1.0))
        detail = np.clip(np.log2(footprint * np.float32(scale)), 0.0, len(self.levels) - 1.0)
        result: Image | None = None
        for level in range(int(detail.min()), int(np.ceil(detail.max())) + 1):
            share = np.clip(1 - np.abs(detail - np.float32(level)), 0.0, 1.0)
            texels = self._interpolated(level, u, v)
            term = texels * (share[..., None] if texels.ndim == 3 else share)
            result = term if result is None else result + term
        assert result is not None
        return result

    def _interpolated(self, level: int, u: Image, v: Image) -> Image:
        tile = self.levels[level]
        rows, columns = (extent - 2 * MARGIN for extent in tile.shape[:2])
        x = u * np.float32(columns) + np.float32(MARGIN - 0.5)
        y = v * np.float32(rows) + np.float32(MARGIN - 0.5)
        return cv2.remap(tile, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
