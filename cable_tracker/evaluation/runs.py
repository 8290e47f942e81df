"""Methods on a sequence: every one of them sees each frame once, and is timed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import STATE_SIZE, CableState
from cable_tracker.errors import FrameError
from cable_tracker.evaluation.evaluation_sequences import EvaluationFrame
from cable_tracker.evaluation.methods import Method
from cable_tracker.evaluation.metrics.run_metrics import run_metrics
from cable_tracker.evaluation.trace import FrameOutcome, Trace, trace_of
from cable_tracker.sequences.pictures.encoded_pictures import jpeg_bytes
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.visualisation.contact_sheet import ContactSheet
from cable_tracker.visualisation.overlay import draw_overlay, with_presence
from cable_tracker.visualisation.palette import status_colour

SHEET_STRIDE = 5
SHEET_PICTURES = 12
SHEET_PICTURE_WIDTH = 216
SHEET_QUALITY = 62


class Start(str, Enum):
    """Start that a method is told at the beginning of a sequence."""

    TRUTH = "truth"
    """True place of the cable in the first frame, if it is labelled; the rates are not told."""

    RANDOM = "random"
    """Nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class RunResult:
    """One method on one sequence with one seed.

    Attributes
    ----------
    method, sequence : str
        Their names.
    seed : int
        Seed of the simulation and of the method.
    start : Start
        Start that the method was told.
    trace : Trace
        All frames.
    metrics : dict of str to float
        Its metrics, by the names of `METRIC_TABLE`.
    sheet : bytes
        A contact sheet of overlays, JPEG; empty if none was asked for.
    refused : int
        Number of frames that the method could not use; they count as frames without a claim.
    refusal : str
        Number of the first of them, and why; empty if there is none.
    """

    method: str
    sequence: str
    seed: int
    start: Start
    trace: Trace
    metrics: dict[str, float]
    sheet: bytes
    refused: int = 0
    refusal: str = ""


class MethodRun:
    """One method while it goes through a sequence.

    Parameters
    ----------
    make : callable
        Makes the method from a seed.
    start : Start
        Start that the method is told.
    restart_every : int or None
        Number of frames after which the method begins anew, with another seed; None: never.
    with_sheet : bool
        Draw a contact sheet.
    """

    def __init__(
        self,
        name: str,
        make: Callable[[int], Method],
        seed: int,
        start: Start,
        *,
        restart_every: int | None = None,
        with_sheet: bool = False,
    ) -> None:
        self._name = name
        self._make = make
        self._seed = seed
        self._start = start
        self._restart_every = restart_every
        self._method = make(seed)
        self._outcomes: list[FrameOutcome] = []
        self._refused = 0
        self._refusal = ""
        self._sheet = (
            ContactSheet(SHEET_STRIDE, SHEET_PICTURES, SHEET_PICTURE_WIDTH) if with_sheet else None
        )

    def process(self, frame: EvaluationFrame) -> None:
        """Show the method one more frame; one that it refuses is one without a claim."""
        self._begin_if_due(frame)
        begin = time.thread_time()
        try:
            estimate = self._method.process(frame.image, frame.stamp)
        except FrameError as error:
            estimate = _nothing_claimed(frame)
            self._refused += 1
            self._refusal = self._refusal or f"frame {frame.index}: {error}"
        ms = (time.thread_time() - begin) * 1e3
        outcome = FrameOutcome(frame.index, frame.truth, frame.visibility, estimate, ms)
        self._outcomes.append(outcome)
        if self._sheet is not None:
            self._add_picture(self._sheet, frame, estimate)

    def _begin_if_due(self, frame: EvaluationFrame) -> None:
        count = len(self._outcomes)
        restart = self._restart_every is not None and count % self._restart_every == 0
        if count and not restart:
            return
        if count:
            self._method = self._make(self._seed + count)
        if self._start is Start.TRUTH and frame.truth is not None:
            # A label file has no rates, so the simulator's are not told either.
            self._method.initialise(GivenState.around(frame.truth.at_rest()))

    def _add_picture(
        self, sheet: ContactSheet, frame: EvaluationFrame, estimate: CableEstimate
    ) -> None:
        status = estimate.status.value
        draw = partial(
            draw_overlay,
            frame.image,
            state=estimate.claimed_state,
            status=status,
            truth=frame.truth if frame.visibility > 0.0 else None,
            hypotheses=estimate.hypotheses,
            legend=False,
        )
        words = with_presence(status, estimate.presence)
        sheet.add(draw, frame.index, words, status_colour(status))

    def result(self, sequence: str) -> RunResult:
        """Return the result of the run, once at least one frame has been processed."""
        trace = trace_of(self._outcomes)
        metrics = run_metrics(trace, started_at_random=self._start is Start.RANDOM)
        return RunResult(
            self._name,
            sequence,
            self._seed,
            self._start,
            trace,
            metrics,
            self._encoded_sheet(),
            self._refused,
            self._refusal,
        )

    def _encoded_sheet(self) -> bytes:
        if self._sheet is None:
            return b""
        return jpeg_bytes(self._sheet.draw(), SHEET_QUALITY)


def _nothing_claimed(frame: EvaluationFrame) -> CableEstimate:
    """Return the estimate that stands for a refused frame: no claim, and no state."""
    height, width = frame.image.shape
    nan = float("nan")
    return CableEstimate(
        stamp=frame.stamp,
        status=TrackingStatus.LOST,
        state=CableState.from_array(np.full(STATE_SIZE, nan)),
        covariance=np.full((STATE_SIZE, STATE_SIZE), nan),
        effective_sample_size=nan,
        evidence=nan,
        image_size=(width, height),
    )


def run_together(
    runs: Sequence[MethodRun],
    frames: Iterable[EvaluationFrame],
    sequence: str,
    advance: Callable[[int], None] = lambda count: None,
) -> list[RunResult]:
    """Show every frame to all methods in turn, so that it is made only once and none is kept.

    Parameters
    ----------
    runs : sequence of MethodRun
        Methods at their beginning.
    frames : iterable of EvaluationFrame
        At least one frame.
    advance : callable
        Called with the number of frames done since its last call.
    """
    for frame in frames:
        for run in runs:
            run.process(frame)
        advance(1)
    return [run.result(sequence) for run in runs]


def sequences_of(results: Iterable[RunResult]) -> list[str]:
    """Return the names of the sequences, in the order in which they come."""
    return list(dict.fromkeys(result.sequence for result in results))


def methods_of(results: Iterable[RunResult]) -> list[str]:
    """Return the names of the methods, in the order in which they come."""
    return list(dict.fromkeys(result.method for result in results))


def chosen(
    results: Iterable[RunResult], *, sequence: str | None = None, method: str | None = None
) -> list[RunResult]:
    """Return the runs of a sequence, or of a method, or of both."""
    return [
        result
        for result in results
        if sequence in (None, result.sequence) and method in (None, result.method)
    ]
