"""`cable-tracker dev estimate-noise`."""

from __future__ import annotations

import math
import operator
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import STATE_SIZE
from cable_tracker.commands.console.terminal import advance, console, print_table, progress_bar
from cable_tracker.commands.options.common import (
    OutsideOption,
    RateOption,
    SkipOption,
    TopicOption,
    TruthOption,
    open_recording,
)
from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.evaluation.experiments.noise import (
    at_reference_width,
    increment_variances,
    parted_at_gaps,
    per_reference_frame,
    usual_step,
)
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.source_base import ChosenRecording
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, REFERENCE_WIDTH

SMALLEST_COUNT = 2
"""Steps from which a variance can be told."""

UNLABELLED: FloatArray = np.full(STATE_SIZE, np.nan)


def estimate_noise(  # noqa: PLR0917
    source: Annotated[Path, typer.Argument(help="Labelled recording of any kind.")],
    truth: TruthOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
) -> None:
    """Print how much the cable moves from frame to frame.

    The variances are those of Tables 4.2 and 4.3 of Wirth's thesis, and what the diffusion of a
    filter should allow for. They are given in px of the recording, from one of its frames to the
    next, as the thesis does; and in the units of the filter's parameters: px of a picture of 320 px
    width, per frame of 0.04 s. Steps to and from frames without a label, over gaps, and between the
    recordings of a list do not count.
    """
    states: list[FloatArray] = []
    times: list[int] = []
    widths: list[float] = []
    chosen = ChosenRecording(source, topic, rate, truth, skip_bad_frames, allow_outside)
    with ExitStack() as stack:
        recording = stack.enter_context(open_recording(chosen))
        progress = stack.enter_context(progress_bar("reading", recording.frame_count))
        for frame in recording.frames():
            states.append(UNLABELLED if frame.truth is None else frame.truth.to_array())
            times.append(frame.stamp)
            widths.append(_width_of(frame, widths[-1] if widths else math.nan))
            advance(progress)
    stamps = np.array(times, np.int64)
    seen = np.array(states).reshape(-1, STATE_SIZE)
    parted = parted_at_gaps(seen, stamps)
    labelled = [bool(np.isfinite(state).all()) for state in parted]
    steps = sum(map(operator.and_, labelled, labelled[1:]))
    if steps < SMALLEST_COUNT:
        raise RecordingError(
            f"{source}: {sum(labelled)} of {len(states)} frames are labelled, with {steps} steps"
            f" between neighbours; at least {SMALLEST_COUNT} are needed, give labels with"
            " --truth FILE"
        )
    step = usual_step(stamps)
    console.print(
        f"{sum(labelled)} of {len(states)} frames labelled, {steps} steps of {step:.3g} s"
    )
    narrow = parted_at_gaps(at_reference_width(seen, np.array(widths)), stamps)
    of_parameters = per_reference_frame(increment_variances(narrow), step)
    _print_variances({"recording": increment_variances(parted), "parameters": of_parameters})


def _width_of(frame: Frame, before: float) -> float:
    """Return the width of a labelled frame [px]; that of the one before where it has none."""
    if frame.truth is None:
        return before
    try:
        return float(decode_grey(frame.image).shape[1])
    except FrameError:
        return before


def _print_variances(variances: dict[str, FloatArray]) -> None:
    """Print rows of variances of d, alpha, w, beta by whose units they are in."""
    headings = ("in units of", "w [px²]", "beta [deg²]", "d [px²]", "alpha [deg²]")
    rows = []
    for name, row in variances.items():
        d, alpha, w, beta = (f"{variance:.4g}" for variance in row)
        rows.append((name, w, beta, d, alpha))
    print_table("variance of the steps from frame to frame", headings, rows, left=(0,))
    console.print(
        "recording: its own px, from one of its frames to the next; parameters: px of a picture of"
        f" {REFERENCE_WIDTH:.0f} px width, per frame of {1.0 / REFERENCE_RATE:g} s, as"
        " width_variance, skew_variance, distance_variance and angle_variance are given",
        soft_wrap=True,
    )
