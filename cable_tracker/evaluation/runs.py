"""Methods on sequences: every one of them sees each frame once, and is timed; campaigns of runs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial

import numpy as np

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import STATE_SIZE, CableState
from cable_tracker.campaigns.folder_tasks import fingerprint_of_files
from cable_tracker.campaigns.runner import run_all
from cable_tracker.campaigns.settings import HERE, CampaignSettings
from cable_tracker.errors import FrameError, ParameterError
from cable_tracker.evaluation.evaluation_sequences import (
    EvaluationFrame,
    EvaluationSequence,
    frames_in_all,
)
from cable_tracker.evaluation.methods import METHODS, ConfiguredFilter, Method
from cable_tracker.evaluation.run_metrics import run_metrics
from cable_tracker.evaluation.sample_statistics import Spread, spread_of
from cable_tracker.evaluation.trace import FrameOutcome, Trace, trace_of
from cable_tracker.sequences.pictures.encoded_pictures import jpeg_bytes
from cable_tracker.tracking.parameter_table import check_name
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


def metric_spread(name: str, results: Iterable[RunResult]) -> Spread:
    """Summarise one number over several runs; `name` is a key of `METRICS_BY_NAME`."""
    return spread_of(result.metrics[name] for result in results)


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


@dataclass(frozen=True, slots=True)
class Campaign:
    """Runs of a campaign.

    Attributes
    ----------
    methods : tuple of str
        Keys of `METHODS`.
    sequences : tuple of EvaluationSequence
        Sequences of the runs.
    seeds : tuple of int
        Seeds; each makes one run of every method on every sequence.
    start : Start
        Start that the methods are told.
    restart_every : int or None
        See `MethodRun`.
    with_sheets : bool
        Draw contact sheets of the first seed.
    filters : tuple of ConfiguredFilter
        Particle filters that are run after the methods; their names must differ.
    """

    methods: tuple[str, ...]
    sequences: tuple[EvaluationSequence, ...]
    seeds: tuple[int, ...]
    start: Start = Start.TRUTH
    restart_every: int | None = None
    with_sheets: bool = False
    filters: tuple[ConfiguredFilter, ...] = ()

    def __post_init__(self) -> None:
        for name in self.methods:
            check_name("method", name, METHODS)
        if not ((self.methods or self.filters) and self.sequences and self.seeds):
            raise ParameterError("give at least one method, one sequence and one seed")

    def makers(self) -> list[tuple[str, Callable[[int], Method]]]:
        """Return names of all methods and filters, and what makes them from a seed."""
        methods = [(name, METHODS[name].make) for name in self.methods]
        return methods + [(each.name, each.make) for each in self.filters]

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through; None if a recording does not say.

        Raises
        ------
        RecordingError
            A recording cannot be judged by.
        """
        counts = (sequence.frame_count() for sequence in self.sequences)
        return frames_in_all(counts, len(self.seeds))

    def parts(self) -> list[Campaign]:
        """Return the runs on each sequence with each seed: what one process does at a time."""
        return [
            replace(
                self,
                sequences=(sequence,),
                seeds=(seed,),
                with_sheets=self.with_sheets and seed == self.seeds[0],
            )
            for sequence in self.sequences
            for seed in self.seeds
        ]

    def fingerprint(self) -> str:
        """Return a text that changes with what is run, and with the recordings."""
        recorded = [file for each in self.sequences for file in each.files()]
        tables = [file for each in self.filters for file in each.parameters.files]
        return f"{self!r} {fingerprint_of_files(*recorded, *tables)}"

    def run(self, advance: Callable[[int], None]) -> list[RunResult]:
        """Run one of `parts`."""
        (sequence,), (seed,) = self.sequences, self.seeds
        runs = [
            MethodRun(
                name,
                make,
                seed,
                self.start,
                restart_every=self.restart_every,
                with_sheet=self.with_sheets,
            )
            for name, make in self.makers()
        ]
        return run_together(runs, sequence.frames(seed), sequence.name, advance)


def evaluate_methods(
    campaign: Campaign,
    settings: CampaignSettings = HERE,
    *,
    advance: Callable[[int], None] = lambda frames: None,
) -> list[RunResult]:
    """Run each method on each sequence with each seed.

    The results do not depend on the number of workers, except for the times.

    Parameters
    ----------
    campaign : Campaign
        Methods, sequences and seeds to run.
    settings : CampaignSettings
        Machines that run it, and the folder of results.
    advance : callable
        Called with the number of frames done since its last call.

    Returns
    -------
    list of RunResult
        By sequence, then seed, then method, in the campaign's order.

    Raises
    ------
    ParameterError
        The cluster cannot be used.
    CableTrackerError
        What stopped the first run that failed.
    """
    runs = run_all(campaign.parts(), settings, advance=advance)
    return [result for results in runs for result in results]
