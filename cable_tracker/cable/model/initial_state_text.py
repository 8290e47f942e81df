"""The words in which a user says where to start: `random`, or `d,alpha,w,beta`."""

from __future__ import annotations

import math

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError

RANDOM = "random"


def parse_initial_state(text: str) -> CableState | None:
    """Read an initial state; None for `random`.

    Raises
    ------
    ParameterError
        The text is neither `random` nor four finite numbers d, alpha, w, beta [px, rad].
    """
    if text.strip() == RANDOM:
        return None
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    state = CableState(*values) if len(values) == 4 else None
    if state is None or not state.is_finite() or state.width <= 0:
        raise ParameterError(
            f"initial state: {text!r} is neither 'random' nor four numbers 'd,alpha,w,beta'"
            " [px, rad, px, rad] with a positive width"
        )
    if abs(state.angle) > math.pi or abs(state.skew) > math.pi / 2:
        raise ParameterError(f"initial state: {text!r}: alpha and beta are in radians, not degrees")
    return state


def format_initial_state(state: CableState) -> str:
    """Write d, alpha, w, beta so that they are read back exactly."""
    return ",".join(repr(v) for v in (state.distance, state.angle, state.width, state.skew))
