"""A snapshot as a packet for browsers: picture, overlay, particles, numbers and history at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TypeAlias

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.segments import (
    Segment,
    band_about,
    border_segments,
    centreline_segments,
)
from cable_tracker.cable.model.state import ANGLE, COMPONENTS, DEGREE, DISTANCE, CableState
from cable_tracker.gui.session.session import AnySnapshot, CableSnapshot, TargetSnapshot
from cable_tracker.gui.web.frame_channel import Section, float_section, jpeg_section, pack
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
from cable_tracker.offline.target_table import TargetRow
from cable_tracker.sequences.messages.line_markers import sides_of_polygon
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg
from cable_tracker.sequences.pictures.shown_levels import stand_in
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.target.model.estimate import box_corners
from cable_tracker.tracking.image_frame import to_page
from cable_tracker.visualisation.drawable import (
    drawn_spread,
    heaviest_rows,
    likely_states,
    within_reach,
)
from cable_tracker.visualisation.palette import (
    AMBER,
    HYPOTHESES,
    PARTICLES,
    TRUTH,
    css,
    status_colour,
)

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

LARGEST_WIDTH = 1280
"""Wider pictures are reduced to this for the browser [px]."""

LARGEST_HEIGHT = 4 * LARGEST_WIDTH
"""Taller pictures are reduced to this; a JPEG has at most 65500 rows [px]."""

TO_DISPLAY = np.array([each.factor for each in COMPONENTS])
"""Factors from px, rad to px, deg, columns of `CableState`."""

TARGET_TO_DISPLAY = np.array([1.0, 1.0, 1.0, DEGREE, 1.0, 1.0])
"""Factors from the units of `TargetClaim.state` to those of the page, shape (6,)."""


Parts: TypeAlias = tuple[dict[str, object], FloatArray, FloatArray]
"""What the page shows of a cable or of a target: a part of the description, lines for the particles
(see browser/frame_view.js), and the particles in units of the page, weights last, shape (M, K).

Of the further numbers, `facts`, each has a title, a value, decimal places and a name.
"""


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


def _parts_of_cable(snapshot: CableSnapshot) -> Parts:
    height, width = snapshot.image.shape
    cloud = heaviest(snapshot.cloud) if snapshot.cloud is not None else np.empty((0, 9))
    row = snapshot.row
    sigma = None if row.sigma is None else (*row.sigma, *snapshot.rate_sigma)
    description: dict[str, object] = {
        "layers": layers_of(snapshot),
        "state": _display(row.state, TO_DISPLAY),
        "sigma": _display(sigma, TO_DISPLAY),
        "truth": _display(snapshot.truth, TO_DISPLAY),
        "facts": [
            ("evidence", finite(row.evidence), 2, "evidence"),
            ("hypotheses", row.hypotheses, 0, "hypotheses"),
        ],
        "metres": _in_metres(snapshot.metres),
    }
    return description, particle_lines(cloud, (width, height)), cloud * np.append(TO_DISPLAY, 1.0)


def _in_metres(known: CrossTrack | Withheld | None) -> dict[str, object] | None:
    """Return rows of name, value, standard deviation, unit, and why they are empty."""
    if known is None:
        return None
    offset: tuple[float | None, float | None] = (None, None)
    heading = offset
    why = detail = ""
    if isinstance(known, CrossTrack):
        sigma = known.standard_deviations().tolist()
        offset = finite(known.offset), finite(sigma[0])
        heading = finite(known.heading * DEGREE), finite(sigma[2] * DEGREE)
    else:
        why, detail = known.reason.value, known.detail
    rows = [("offset", *offset, "m"), ("heading", *heading, "deg")]
    return {"rows": rows, "why": why, "detail": detail}


def _parts_of_target(snapshot: TargetSnapshot) -> Parts:
    height, width = snapshot.image.shape[:2]
    cloud = heaviest(snapshot.cloud) if snapshot.cloud is not None else np.empty((0, 7))
    claim = snapshot.row.claim
    state, sigma = (None, None) if claim is None else (claim.state, claim.sigma)
    size = None if claim is None else math.sqrt(max(claim.area, 0.0))
    description: dict[str, object] = {
        "layers": target_layers(snapshot),
        "state": _display(state, TARGET_TO_DISPLAY),
        "sigma": _display(sigma, TARGET_TO_DISPLAY),
        "truth": None,
        "facts": [
            ("size px", finite(size), 1, "size"),
            ("score", finite(snapshot.score), 2, "score"),
        ],
        "metres": None,
    }
    lines = target_particles(cloud, (width, height))
    return description, lines, cloud * np.append(TARGET_TO_DISPLAY, 1.0)


def make_packet(
    snapshot: AnySnapshot, history: FloatArray, *, is_whole: bool, fps: float | None
) -> bytes:
    """Pack what the window shows of a frame.

    Parameters
    ----------
    snapshot : CableSnapshot or TargetSnapshot
        Filter output for the picture.
    history : FloatArray
        See `TrackingHistory.table`.
    is_whole : bool
        Whether that is all of it.
    fps : float or None
        Frames per second that are tracked; None while none are.

    Raises
    ------
    FrameError
        The picture cannot be encoded.
    ValueError
        A number of a layer is not finite.
    """
    if isinstance(snapshot, TargetSnapshot):
        parts, lines, cloud = _parts_of_target(snapshot)
    else:
        parts, lines, cloud = _parts_of_cable(snapshot)
    height, width = snapshot.image.shape[:2]
    row = snapshot.row
    description = parts | {
        "number": snapshot.number,
        "size": [width, height],
        "frame": snapshot.frame,
        "time": row.stamp / NANOSECONDS,
        "status": row.status,
        "status_colour": css(status_colour(row.status)),
        "particle_colour": css(PARTICLES),
        "reason": row.event,
        "particle_count": 0 if snapshot.cloud is None else len(snapshot.cloud),
        "presence": finite(row.presence),
        "n_eff": finite(row.n_eff),
        "ms": finite(row.ms),
        "fps": finite(fps),
        "history_is_whole": is_whole,
    }
    sections: list[Section] = [
        jpeg_section(encode_jpeg(_reduced(snapshot.image)).data),
        float_section("particles", lines),
        float_section("cloud", cloud),
        float_section("history", history),
    ]
    return pack(description, sections)


def without_picture(snapshot: AnySnapshot, reason: str) -> AnySnapshot:
    """Return the snapshot to show of a frame that cannot be packed: its status, and why."""
    place, row = (snapshot.number, snapshot.frame, stand_in()), snapshot.row
    facts = (row.frame, row.stamp, row.status)
    if isinstance(snapshot, TargetSnapshot):
        return TargetSnapshot(*place, TargetRow(*facts, event=reason))
    return CableSnapshot(*place, EstimateRow(*facts, event=reason))


def finite(value: float | None) -> float | None:
    """Return a number that JSON can say; None stands for any other."""
    return value if value is not None and math.isfinite(value) else None


def _display(
    values: CableState | Sequence[float] | None, factors: FloatArray
) -> list[float | None] | None:
    """Return components of a state in units of the page."""
    if values is None:
        return None
    array = values.to_array() if isinstance(values, CableState) else np.array(values)
    return [finite(value) for value in (array * factors[: len(array)]).tolist()]


def _reduced(picture: Image) -> Image:
    height, width = picture.shape[:2]
    if width <= LARGEST_WIDTH and height <= LARGEST_HEIGHT:
        return picture
    scale = min(LARGEST_WIDTH / width, LARGEST_HEIGHT / height)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
