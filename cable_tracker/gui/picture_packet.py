"""A snapshot as a packet for browsers: picture, overlay, particles, numbers and history at once."""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.state import STATE_SIZE, CableState
from cable_tracker.gui.packet import Section, float_section, jpeg_section, pack
from cable_tracker.gui.picture_layers import css, heaviest, layers_of, particle_lines
from cable_tracker.gui.session import Snapshot
from cable_tracker.sequences.jpeg import encode_jpeg
from cable_tracker.sequences.stamps import NANOSECONDS
from cable_tracker.visualisation.palette import PARTICLES, status_colour

LARGEST_WIDTH = 1280
"""Wider pictures are reduced to this for the browser [px]."""


DEGREE = math.degrees(1.0)
TO_DISPLAY = np.array([1.0, DEGREE] * (STATE_SIZE // 2))
"""Factors from px, rad to px, deg, columns of `StateColumn`."""


def make_packet(
    snapshot: Snapshot, history: FloatArray, *, is_whole: bool, fps: float | None
) -> bytes:
    """Pack what the window shows of a frame.

    Parameters
    ----------
    snapshot : Snapshot
        What the filter made of it.
    history : FloatArray
        See `TrackingHistory.table`.
    is_whole : bool
        Whether that is all of it.
    fps : float or None
        Frames per second that are tracked; None while none are.
    """
    height, width = snapshot.grey.shape
    cloud = heaviest(snapshot.cloud) if snapshot.cloud is not None else np.empty((0, 9))
    description: dict[str, object] = {
        "number": snapshot.number,
        "size": [width, height],
        "frame": snapshot.frame,
        "time": snapshot.stamp / NANOSECONDS,
        "status": snapshot.status,
        "status_colour": css(status_colour(snapshot.status)),
        "particle_colour": css(PARTICLES),
        "reason": snapshot.reason,
        "layers": layers_of(snapshot),
        "particle_count": 0 if snapshot.cloud is None else len(snapshot.cloud),
        "state": _display(_array_of(snapshot.state)),
        "sigma": _display(snapshot.sigma),
        "truth": _display(_array_of(snapshot.truth)),
        "presence": finite(snapshot.presence),
        "evidence": finite(snapshot.evidence),
        "n_eff": finite(snapshot.n_eff),
        "ms": finite(snapshot.ms),
        "fps": finite(fps),
        "hypotheses": snapshot.hypothesis_count or len(snapshot.hypotheses),
        "history_is_whole": is_whole,
    }
    shown = cloud * np.append(TO_DISPLAY, 1.0)
    sections: list[Section] = [
        jpeg_section(encode_jpeg(_reduced(snapshot.grey)).data),
        float_section("particles", particle_lines(cloud, (width, height))),
        float_section("cloud", shown),
        float_section("history", history),
    ]
    return pack(description, sections)


def finite(value: float | None) -> float | None:
    """Return a number that JSON can say; None stands for any other."""
    return value if value is not None and math.isfinite(value) else None


def _array_of(state: CableState | None) -> FloatArray | None:
    return state.to_array() if state is not None else None


def _display(values: FloatArray | None) -> list[float | None] | None:
    """Return columns of `StateColumn` in px and deg."""
    if values is None:
        return None
    return [finite(value) for value in (values * TO_DISPLAY[: len(values)]).tolist()]


def _reduced(grey: Image) -> Image:
    height, width = grey.shape
    if width <= LARGEST_WIDTH:
        return grey
    size = (LARGEST_WIDTH, max(1, round(height * LARGEST_WIDTH / width)))
    return cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
