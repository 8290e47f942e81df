"""Where the thesis looks at a picture: points along both borders of cables."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.geometry import Borders, points_on_lines


def sample_points(
    borders: Borders, spacing: float, image_size: tuple[int, int]
) -> tuple[FloatArray, BoolArray]:
    """Place points along each border, at equal distances from the border's own foot point.

    Parameters
    ----------
    borders : Borders
        N pairs of borders.
    spacing : float
        Distance between neighbours [px].
    image_size : (int, int)
        Width and height of the image [px].

    Returns
    -------
    points : FloatArray
        x, y in the image frame [px], shape (N, 2, M, 2); M is odd and the same for all borders.
    inside : BoolArray
        Whether the point lies inside the image, shape (N, 2, M).
    """
    width, height = image_size
    reach = int(np.hypot(width, height) / 2 / spacing)
    along = np.arange(-reach, reach + 1, dtype=np.float64) * spacing
    points = points_on_lines(borders.angles, borders.offsets, along)
    inside = (np.abs(points[..., 0]) <= (width - 1) / 2) & (
        np.abs(points[..., 1]) <= (height - 1) / 2
    )
    return points, inside
