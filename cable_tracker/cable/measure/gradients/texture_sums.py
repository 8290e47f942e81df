"""Sums of gradients over grey levels along the scan lines: the texture of a picture.

A gradient counts with its direction, as the structure tensor does: g g' / |g|, whose trace is |g|.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.gradients.scan_lines import ACROSS, ALONG
from cable_tracker.compilation import compiled_fast_loop, compiled_part

TEXTURE_LEVEL_OFFSET = 6.0
"""Added to grey levels before gradients are divided by them [grey levels]: below, all is noise."""

MOST_TEXTURE = 1.5
"""Upper bound of the gradient over the grey level in sums of texture, in units of the robust scale
over the mean grey level: edges are no texture, and a flat picture has none."""

ALONG_LINES, MIXED, ACROSS_LINES = range(3)
"""Columns of sums: products of the component of the gradient along u with itself, of both, and of
that along v with itself."""

TENSOR_SIZE = 3
"""Number of these columns."""

SMALLEST_GRADIENT = 1e-9
"""Below, a gradient has no direction."""

TEXTURE_STEP = 2
"""Texture is known of every second scan line: they say the same as all."""


@compiled_part
def summed_texture(gradients: Image, smooth: Image, dark: float, most: float) -> Image:
    """Return the sums of gradients over grey levels along scan lines, see `ScanLines`.

    Parameters
    ----------
    gradients, smooth : Image
        See `ScanLines`.
    dark : float
        Added to the grey levels [scales of the contrast].
    most : float
        A gradient over the grey level counts no more.
    """
    lines, length = smooth.shape
    sums = np.empty(((lines - 1) // TEXTURE_STEP + 1, length + 1, TENSOR_SIZE), np.float32)
    for number in range(len(sums)):
        line = TEXTURE_STEP * number
        _fill_texture(
            gradients[line], smooth[line], np.float32(dark), np.float32(most), sums[number]
        )
    return sums


@compiled_fast_loop
def _fill_texture(
    gradients: Image, smooth: Image, dark: np.float32, most: np.float32, sums: Image
) -> None:
    """Fill in the sums (n + 1, 3) along one line."""
    sums[0] = np.float32(0.0)
    for x in range(len(smooth)):
        along, across = gradients[x, ALONG], gradients[x, ACROSS]
        level = max(smooth[x], np.float32(0.0)) + dark
        size = max(np.sqrt(along * along + across * across), np.float32(SMALLEST_GRADIENT))
        weight = min(np.float32(1.0) / level, most / size) / size
        sums[x + 1, ALONG_LINES] = along * along * weight
        sums[x + 1, MIXED] = along * across * weight
        sums[x + 1, ACROSS_LINES] = across * across * weight
    for x in range(len(smooth)):
        for column in range(TENSOR_SIZE):
            sums[x + 1, column] += sums[x, column]
