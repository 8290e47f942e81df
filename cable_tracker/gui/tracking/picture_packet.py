"""A snapshot as a packet for browsers: picture, overlay, particles, numbers and history at once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.state import COMPONENTS, DEGREE, CableState
from cable_tracker.gui.session.snapshot import AnySnapshot, CableSnapshot, TargetSnapshot
from cable_tracker.gui.tracking.picture_layers import (
    Layer,
    heaviest,
    layers_of,
    particle_lines,
    target_layers,
    target_particles,
)
from cable_tracker.gui.web.packet import Section, float_section, jpeg_section, pack
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg
from cable_tracker.sequences.pictures.shown_levels import stand_in
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.visualisation.palette import PARTICLES, css, status_colour

LARGEST_WIDTH = 1280
"""Wider pictures are reduced to this for the browser [px]."""

LARGEST_HEIGHT = 4 * LARGEST_WIDTH
"""Taller pictures are reduced to this; a JPEG has at most 65500 rows [px]."""

TO_DISPLAY = np.array([each.factor for each in COMPONENTS])
"""Factors from px, rad to px, deg, columns of `StateColumn`."""

TARGET_TO_DISPLAY = np.array([1.0, 1.0, 1.0, DEGREE, 1.0, 1.0])
"""Factors from the units of `TargetSnapshot.state` to those of the page, shape (6,)."""


Fact: TypeAlias = tuple[str, float | None, int, str]
"""Words, value, decimal places, and name of a number of the panel."""


@dataclass(frozen=True, slots=True, eq=False)
class PictureView:
    """Page's view of a snapshot, for any subject.

    Attributes
    ----------
    picture : Image
        uint8, grey (H, W) or blue-green-red (H, W, 3).
    layers : list of Layer
        Layers drawn on it.
    lines : FloatArray
        Lines that stand for the particles; see browser/frame_view.js.
    cloud : FloatArray
        The particles in units of the page, weights last, shape (M, K).
    state, sigma, truth : list or None
        Components of the state in units of the page; None where they are not known.
    facts : list of Fact
        Further numbers.
    metres : dict or None
        Values in metres; None where there are no instruments.
    """

    picture: Image
    layers: list[Layer]
    lines: FloatArray
    cloud: FloatArray
    state: list[float | None] | None
    sigma: list[float | None] | None
    truth: list[float | None] | None
    facts: list[Fact]
    metres: dict[str, object] | None = None


def _view_of_cable(snapshot: CableSnapshot) -> PictureView:
    height, width = snapshot.image.shape
    cloud = heaviest(snapshot.cloud) if snapshot.cloud is not None else np.empty((0, 9))
    count = snapshot.hypothesis_count or len(snapshot.hypotheses)
    return PictureView(
        picture=snapshot.image,
        layers=layers_of(snapshot),
        lines=particle_lines(cloud, (width, height)),
        cloud=cloud * np.append(TO_DISPLAY, 1.0),
        state=_display(_array_of(snapshot.state), TO_DISPLAY),
        sigma=_display(snapshot.sigma, TO_DISPLAY),
        truth=_display(_array_of(snapshot.truth), TO_DISPLAY),
        facts=[
            ("evidence", finite(snapshot.evidence), 2, "evidence"),
            ("hypotheses", count, 0, "hypotheses"),
        ],
        metres=_in_metres(snapshot.metres),
    )


def _in_metres(known: CrossTrack | Withheld | None) -> dict[str, object] | None:
    """Return rows of name, value, standard deviation, unit, and why they are empty."""
    if known is None:
        return None
    offset: tuple[float | None, float | None] = (None, None)
    heading = offset
    why = words = ""
    if isinstance(known, CrossTrack):
        sigma = known.standard_deviations().tolist()
        offset = finite(known.offset), finite(sigma[0])
        heading = finite(known.heading * DEGREE), finite(sigma[2] * DEGREE)
    else:
        why, words = known.reason.value, known.detail
    rows = [("offset", *offset, "m"), ("heading", *heading, "deg")]
    return {"rows": rows, "why": why, "words": words}


def _view_of_target(snapshot: TargetSnapshot) -> PictureView:
    height, width = snapshot.image.shape[:2]
    cloud = heaviest(snapshot.cloud) if snapshot.cloud is not None else np.empty((0, 7))
    size = None if snapshot.area is None else math.sqrt(max(snapshot.area, 0.0))
    return PictureView(
        picture=snapshot.image,
        layers=target_layers(snapshot),
        lines=target_particles(cloud, (width, height)),
        cloud=cloud * np.append(TARGET_TO_DISPLAY, 1.0),
        state=_display(snapshot.state, TARGET_TO_DISPLAY),
        sigma=_display(snapshot.sigma, TARGET_TO_DISPLAY),
        truth=None,
        facts=[
            ("size px", finite(size), 1, "size"),
            ("score", finite(snapshot.score), 2, "score"),
        ],
    )


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
        view = _view_of_target(snapshot)
    else:
        view = _view_of_cable(snapshot)
    height, width = view.picture.shape[:2]
    description: dict[str, object] = {
        "number": snapshot.number,
        "size": [width, height],
        "frame": snapshot.frame,
        "time": snapshot.stamp / NANOSECONDS,
        "status": snapshot.status,
        "status_colour": css(status_colour(snapshot.status)),
        "particle_colour": css(PARTICLES),
        "reason": snapshot.reason,
        "layers": view.layers,
        "particle_count": 0 if snapshot.cloud is None else len(snapshot.cloud),
        "state": view.state,
        "sigma": view.sigma,
        "truth": view.truth,
        "presence": finite(snapshot.presence),
        "facts": view.facts,
        "metres": view.metres,
        "n_eff": finite(snapshot.n_eff),
        "ms": finite(snapshot.ms),
        "fps": finite(fps),
        "history_is_whole": is_whole,
    }
    sections: list[Section] = [
        jpeg_section(encode_jpeg(_reduced(view.picture)).data),
        float_section("particles", view.lines),
        float_section("cloud", view.cloud),
        float_section("history", history),
    ]
    return pack(description, sections)


def without_picture(snapshot: AnySnapshot, reason: str) -> AnySnapshot:
    """Return what is shown of a frame that cannot be packed: its status, and why."""
    facts = (snapshot.number, snapshot.frame, snapshot.stamp)
    return type(snapshot)(*facts, stand_in(), snapshot.status, reason)


def finite(value: float | None) -> float | None:
    """Return a number that JSON can say; None stands for any other."""
    return value if value is not None and math.isfinite(value) else None


def _array_of(state: CableState | None) -> FloatArray | None:
    return state.to_array() if state is not None else None


def _display(values: FloatArray | None, factors: FloatArray) -> list[float | None] | None:
    """Return components of a state in units of the page."""
    if values is None:
        return None
    return [finite(value) for value in (values * factors[: len(values)]).tolist()]


def _reduced(picture: Image) -> Image:
    height, width = picture.shape[:2]
    if width <= LARGEST_WIDTH and height <= LARGEST_HEIGHT:
        return picture
    scale = min(LARGEST_WIDTH / width, LARGEST_HEIGHT / height)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
