"""`cable-tracker dev estimate-noise`."""

from __future__ import annotations

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
from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.experiments.noise import (
    increment_variances,
    parted_at_gaps,
    usual_step,
)
from cable_tracker.sequences.source import ChosenRecording

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
    filter should allow for. Steps to and from frames without a label, over gaps, and between the
    recordings of a list do not count.
    """
    states: list[FloatArray] = []
    times: list[int] = []
    chosen = ChosenRecording(source, topic, rate, truth, skip_bad_frames, allow_outside)
    with ExitStack() as stack:
        recording = stack.enter_context(open_recording(chosen))
        progress = stack.enter_context(progress_bar("reading", recording.frame_count))
        for frame in recording.frames():
            states.append(UNLABELLED if frame.truth is None else frame.truth.to_array())
            times.append(frame.stamp)
            advance(progress)
    stamps = np.array(times, np.int64)
    parted = parted_at_gaps(np.array(states).reshape(-1, STATE_SIZE), stamps)
    labelled = [bool(np.isfinite(state).all()) for state in parted]
    steps = sum(map(operator.and_, labelled, labelled[1:]))
    if steps < SMALLEST_COUNT:
        raise RecordingError(
            f"{source}: {sum(labelled)} of {len(states)} frames are labelled, with {steps} steps"
            f" between neighbours; at least {SMALLEST_COUNT} are needed, give labels with"
            " --truth FILE"
        )
    variances = increment_variances(parted)
    console.print(
        f"{sum(labelled)} of {len(states)} frames labelled, {steps} steps of"
        f" {usual_step(stamps):.3g} s"
    )
    d, alpha, w, beta = (f"{variance:.4g}" for variance in variances)
    headings = ("w [px²]", "beta [deg²]", "d [px²]", "alpha [deg²]")
    title = "variance of the steps from frame to frame"
    print_table(title, headings, [(w, beta, d, alpha)])
