"""What of a cable's lines lies inside an image, to be shown."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import points_on_lines, project_borders, segment_inside
from cable_tracker.cable.model.state import CableState

Segment = tuple[tuple[float, float], tuple[float, float]]
"""x, y of both ends in the image frame [px]."""


def border_segments(state: CableState, image_size: tuple[int, int]) -> list[Segment]:
    """Return the borders inside an image, left before right, without one that misses it."""
    borders = project_borders(state.to_array()[None, :])
    clipped = (
        segment_inside(float(angle), float(offset), image_size)
        for angle, offset in zip(borders.angles[0], borders.offsets[0], strict=True)
    )
    return [segment for segment in clipped if segment is not None]


def centreline_segments(state: CableState, image_size: tuple[int, int]) -> list[Segment]:
    """Return the centreline inside an image, as a list of one; empty if it misses it."""
    segment = segment_inside(state.angle, state.distance, image_size)
    return [] if segment is None else [segment]


def band_about(
    state: CableState, sigma: tuple[float, float], image_size: tuple[int, int], points: int
) -> FloatArray:
    """Return where the centreline lies within two standard deviations, as a polygon.

    Parameters
    ----------
    state : CableState
        The cable.
    sigma : (float, float)
        Standard deviations of distance [px] and angle [rad].
    image_size : (int, int)
        Width and height [px].
    points : int
        K, how many there are along either side.

    Returns
    -------
    FloatArray
        Corners in the image frame [px], shape (2K, 2); they may lie outside the image.
    """
    reach = float(np.hypot(*image_size)) / 2
    along = np.linspace(-reach, reach, points)
    half = np.minimum(2 * np.hypot(sigma[0], along * sigma[1]), 2 * reach)
    normal = np.array([np.cos(state.angle), np.sin(state.angle)])
    centre = points_on_lines(np.array(state.angle), np.array(state.distance), along)
    aside = half[:, None] * normal
    return np.concatenate((centre - aside, (centre + aside)[::-1]))
