"""Measures along the parallel scan lines of a picture."""

from __future__ import annotations

from typing import NamedTuple

from cable_tracker.arrays import FloatArray, Image

ALONG, ACROSS, SLOPE = range(3)
"""Channels: the last axis of `ScanLines.gradients`."""


class ScanLines(NamedTuple):
    """Measures along one family of parallel scan lines.

    Rows are scanned to the right, columns upwards: u is the coordinate along a line, v that of the
    line, in the image frame of the working picture.

    Attributes
    ----------
    gradients : Image
        float32, shape (L, n, 3), see `ALONG`: gradient along u and along v [robust scales], slope
        of its modulus along u [robust scales per px].
    smooth : Image
        Grey level without the fine texture [scales of the contrast], float32, shape (L, n).
    places : FloatArray
        v of each line [px], shape (L,).
    """

    gradients: Image
    smooth: Image
    places: FloatArray
