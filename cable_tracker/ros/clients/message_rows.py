"""Rows of the tables of estimates, made from the messages of a tracker node about a frame."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from cable_tracker.metric.messages import NO_METRES_KEY, read_row_metres
from cable_tracker.offline.target_table import TargetClaim, TargetRow
from cable_tracker.sequences.messages.cable import read_sigma, read_state
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import fact_number
from cable_tracker.sequences.messages.target import TARGET_STATE_NAMES
from cable_tracker.sequences.tables.estimates import EstimateRow


def cable_row(
    frame: int, stamp: int, status: str, state: Message, facts: Mapping[str, str]
) -> EstimateRow:
    """Return the row of a cable that a `state` and the facts of a report make.

    Raises
    ------
    FrameError
        Names and numbers of the state do not belong together.
    """
    number = partial(fact_number, facts)
    claimed = read_state(state)
    return EstimateRow(
        frame=frame,
        stamp=stamp,
        status=status,
        state=claimed,
        sigma=read_sigma(state) if claimed is not None else None,
        n_eff=number("n_eff"),
        presence=number("presence"),
        evidence=number("evidence"),
        hypotheses=len(facts["hypotheses"].split()) if "hypotheses" in facts else None,
        ms=number("ms"),
        metres=read_row_metres(facts),
        no_metres=facts.get(NO_METRES_KEY, ""),
        event=facts.get("event", ""),
    )


def target_row(
    frame: int, stamp: int, status: str, state: Message, facts: Mapping[str, str]
) -> TargetRow:
    """Return the row of a target that a `state` and the facts of a report make."""
    number = partial(fact_number, facts)
    claim = None
    scale, area = number("scale"), number("area")
    is_claimed = len(state.position) == len(TARGET_STATE_NAMES)
    if is_claimed and scale is not None and area is not None:
        x, y, _, angle = (float(value) for value in state.position)
        v_x, v_y = (float(value) for value in state.velocity[:2])
        sigma_x, sigma_y = (float(value) for value in state.effort[:2])
        left, top, right, bottom = (float(side) for side in facts["box"].split())
        claim = TargetClaim(
            state=(x, y, scale, angle, v_x, v_y),
            sigma=(sigma_x, sigma_y),
            box=(left, top, right, bottom),
            area=area,
        )
    return TargetRow(
        frame, stamp, status, claim, number("presence"), number("n_eff"), number("ms"),
        facts.get("event", ""),
    )  # fmt: skip
