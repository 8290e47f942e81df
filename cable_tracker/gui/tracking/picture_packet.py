"""A snapshot as a packet for browsers: picture, overlay, particles, numbers and history at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.state import COMPONENTS, DEGREE, CableState
from cable_tracker.gui.session.snapshot import AnySnapshot, CableSnapshot, TargetSnapshot
from cable_tracker.gui.tracking.picture_layers import (
    heaviest,
    layers_of,
    particle_lines,
    target_layers,
    target_particles,
)
from cable_tracker.gui.web.packet import Section, float_section, jpeg_section, pack
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
from cable_tracker.offline.target_table import TargetRow
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg
from cable_tracker.sequences.pictures.shown_levels import stand_in
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.visualisation.palette import PARTICLES, css, status_colour

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
