"""Layers drawn on a picture, as lines and areas in its pixels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.segments import (
    Segment,
    band_about,
    border_segments,
    centreline_segments,
)
from cable_tracker.cable.model.state import ANGLE, DISTANCE, CableState
from cable_tracker.gui.session.snapshot import CableSnapshot, TargetSnapshot
from cable_tracker.sequences.messages.line_markers import sides_of_polygon
from cable_tracker.target.model.estimate import box_corners
from cable_tracker.tracking.image_frame import to_page
from cable_tracker.visualisation.drawable import (
    drawn_spread,
    heaviest_rows,
    likely_states,
    within_reach,
)
from cable_tracker.visualisation.palette import AMBER, HYPOTHESES, TRUTH, css, status_colour

Layer: TypeAlias = dict[str, object]
"""See browser/frame_view.js."""

LARGEST_CLOUD = 2000
"""Largest number of particles that are sent: those of highest weight."""

MOST_OPAQUE = 0.6
"""Opacity of the heaviest particle."""

BAND_POINTS = 21

ELLIPSE_POINTS = 33

CROSS_SHARE = 0.004
"""Length of an arm of the cross that stands for a particle, as a share of the picture's width."""


def layers_of(snapshot: CableSnapshot) -> list[Layer]:
    """Return band, hypotheses, estimate and truth; each has a name, so that it can be hidden."""
    size = (snapshot.image.shape[1], snapshot.image.shape[0])
    layers: list[Layer] = []
    colour = css(status_colour(snapshot.row.status))
    state, sigma = snapshot.row.state, snapshot.row.sigma
    is_drawn = state is not None and state.is_finite()
    spread = drawn_spread(sigma) if sigma is not None else None
    if state is not None and is_drawn and spread is not None:
        layers.append(_band(state, spread, colour, size))
    others = snapshot.hypotheses[1:] if is_drawn else snapshot.hypotheses
    layers.append(_lines("hypotheses", _hypotheses(others, size), css(HYPOTHESES), 1.5, size))
    if state is not None and is_drawn:
        layers.append(_lines("estimate", border_segments(state, size), colour, 2.5, size))
        layers.append(_lines("centreline", centreline_segments(state, size), colour, 1.5, size))
    if snapshot.truth is not None and snapshot.truth.is_finite():
        dashed = _lines("truth", border_segments(snapshot.truth, size), css(TRUTH), 2.0, size)
        layers.append(dashed | {"dash": [8, 6]})
    return layers


def heaviest(cloud: FloatArray) -> FloatArray:
    """Return the particles that are sent, lightest first; weights, last, over the largest."""
    usable = np.asarray(np.isfinite(cloud).all(axis=1))
    chosen = cloud[heaviest_rows(cloud[:, -1], usable, LARGEST_CLOUD)]
    if len(chosen):
        chosen = np.column_stack((chosen[:, :-1], chosen[:, -1] / chosen[-1, -1]))
    return chosen


def particle_lines(cloud: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Return the centrelines of particles in pixels: x1, y1, x2, y2, opacity; shape (M, 5).

    Parameters
    ----------
    cloud : FloatArray
        Particles as `heaviest` returns them.
    size : (int, int)
        Width and height of the frame [px].
    """
    width, height = size
    reach = float(np.hypot(width, height)) / 2
    cloud = cloud[np.abs(cloud[:, DISTANCE]) < reach]
    distances, angles = cloud[:, DISTANCE], cloud[:, ANGLE]
    cos, sin = np.cos(angles), np.sin(angles)
    x, y = to_page(distances * cos, distances * sin, size)
    # The browser draws all lines of about one opacity as one stroke, which does not add up.
    opacity = MOST_OPAQUE * np.sqrt(cloud[:, -1])
    return np.column_stack(
        (x - reach * sin, y - reach * cos, x + reach * sin, y + reach * cos, opacity)
    )


def _lines(
    name: str,
    segments: Iterable[Segment],
    colour: str,
    width: float,
    size: tuple[int, int],
) -> Layer:
    ends = np.array(list(segments)).reshape(-1, 2)
    places = np.column_stack(to_page(ends[:, 0], ends[:, 1], size))
    return _lines_on_page(name, places, colour, width, size)


def _lines_on_page(
    name: str, ends: FloatArray, colour: str, width: float, size: tuple[int, int]
) -> Layer:
    """Return lines, both ends of one after the other, from the upper left corner, (2K, 2)."""
    points = _rounded(ends, size)
    return {"kind": "lines", "name": name, "colour": colour, "width": width, "points": points}


def _area(rim: FloatArray, colour: str, opacity: float, size: tuple[int, int]) -> Layer:
    """Return the area in a rim (N, 2) of the image frame: where a centre or centreline may be."""
    points = _rounded(np.column_stack(to_page(rim[:, 0], rim[:, 1], size)), size)
    return {"kind": "area", "name": "band", "colour": colour, "opacity": opacity, "points": points}


def _rounded(places: FloatArray, size: tuple[int, int]) -> list[float]:
    """Turn places on the page (N, 2) into x, y, x, y ..."""
    return [round(number, 2) for number in within_reach(places, size).ravel().tolist()]


def _hypotheses(hypotheses: Sequence[Hypothesis], size: tuple[int, int]) -> Iterable[Segment]:
    for state in likely_states(hypotheses):
        yield from centreline_segments(state, size)


def _band(
    state: CableState, spread: tuple[float, float], colour: str, size: tuple[int, int]
) -> Layer:
    """Return where the centreline lies within two standard deviations of distance and angle."""
    return _area(band_about(state, spread, size, BAND_POINTS), colour, 0.22, size)


def target_layers(snapshot: TargetSnapshot) -> list[Layer]:
    """Return the spread of a target's centre, its contour, box and true box; each has a name."""
    size = (snapshot.image.shape[1], snapshot.image.shape[0])
    layers: list[Layer] = []
    colour = css(status_colour(snapshot.row.status))
    claim = snapshot.row.claim
    spread = drawn_spread(claim.sigma) if claim is not None else None
    if claim is not None and spread is not None and np.isfinite(claim.state[:2]).all():
        layers.append(_ellipse(np.array(claim.state[:2]), spread, colour, size))
    if len(snapshot.outline):
        layers.append(_closed("contour", snapshot.outline, css(AMBER), 1.5, size))
    if claim is not None:
        layers.append(_closed("box", box_corners(claim.box), colour, 2.5, size))
    if snapshot.truth is not None:
        corners = box_corners(snapshot.truth)
        layers.append(_closed("truth", corners, css(TRUTH), 2.0, size) | {"dash": [8, 6]})
    return layers


def target_particles(cloud: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Return particles of a target as small crosses: x1, y1, x2, y2, opacity; shape (2 M, 5).

    Parameters
    ----------
    cloud : FloatArray
        Particles as `heaviest` returns them, x and y first.
    size : (int, int)
        Width and height of the frame [px].
    """
    width, height = size
    arm = CROSS_SHARE * width
    x, y = to_page(cloud[:, 0], cloud[:, 1], size)
    inside = (x > -arm) & (x < width + arm) & (y > -arm) & (y < height + arm)
    x, y, opacity = x[inside], y[inside], MOST_OPAQUE * np.sqrt(cloud[inside, -1])
    across = np.column_stack((x - arm, y, x + arm, y, opacity))
    upright = np.column_stack((x, y - arm, x, y + arm, opacity))
    return np.concatenate((across, upright))


def _closed(
    name: str, corners: FloatArray, colour: str, width: float, size: tuple[int, int]
) -> Layer:
    """Return the sides of a polygon (K, 2) that counts from the top left corner."""
    usable = corners[np.isfinite(corners).all(axis=1)]
    return _lines_on_page(name, sides_of_polygon(usable), colour, width, size)


def _ellipse(
    centre: FloatArray, spread: tuple[float, float], colour: str, size: tuple[int, int]
) -> Layer:
    """Return where a centre lies within two standard deviations."""
    turns = np.linspace(0.0, 2.0 * np.pi, ELLIPSE_POINTS)
    rim = centre + np.column_stack((np.cos(turns), np.sin(turns))) * (2.0 * np.array(spread))
    return _area(rim, colour, 0.3, size)
