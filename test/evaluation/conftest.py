from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pytest

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.evaluation_sequences import EvaluationFrame, EvaluationSequence
from cable_tracker.evaluation.runs import Campaign, RunResult, Start, evaluate_methods
from cable_tracker.evaluation.trace import FrameOutcome, Trace, trace_of
from cable_tracker.sequences.labels.sequence_file import APART
from cable_tracker.tracking.status import TrackingStatus

FRAME_NS = 40_000_000


CABLE = CableState(10.0, 0.1, 40.0, 0.02)


def _outcome(
    index: int,
    truth: CableState | None = CABLE,
    error: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
    *,
    visibility: float | None = None,
    claimed: bool = True,
    sigma: tuple[float, float, float, float] = (2.0, 0.02, 3.0, 0.01),
    ms: float = 5.0,
    width: int = 320,
) -> FrameOutcome:
    base = truth if truth is not None else CableState(0.0, 0.0, 30.0, 0.0)
    values = base.to_array()
    values[:4] += error
    estimate = CableEstimate(
        stamp=1_000_000_000 + index * FRAME_NS,
        status=TrackingStatus.TRACKING if claimed else TrackingStatus.LOST,
        state=CableState.from_array(values),
        covariance=np.diag(np.square((*sigma, 1.0, 1.0, 1.0, 1.0))),
        effective_sample_size=100.0,
        evidence=2.0,
        image_size=(width, width * 3 // 4),
    )
    if visibility is None:
        visibility = 0.0 if truth is None else 1.0
    return FrameOutcome(index, truth, visibility, estimate, ms)


@pytest.fixture
def outcome() -> Callable[..., FrameOutcome]:
    """Make what came of one frame; the estimate is the truth plus an error."""
    return _outcome


@pytest.fixture
def trace() -> Callable[[str], Trace]:
    """Make a run from letters, one for each frame.

    h held, l lost, s silent but held, x lost and silent; of a visible cable. f claimed and n silent
    where there is no cable. u: unknown.
    """
    kinds = {
        "h": {},
        "l": {"error": (50.0, 0.0, 0.0, 0.0)},
        "s": {"claimed": False},
        "x": {"error": (50.0, 0.0, 0.0, 0.0), "claimed": False},
        "f": {"truth": None},
        "n": {"truth": None, "claimed": False},
        "u": {"truth": None, "visibility": float("nan")},
    }
    return lambda letters: trace_of([_outcome(i, **kinds[k]) for i, k in enumerate(letters)])


@pytest.fixture
def apart() -> Callable[[Trace, Trace], Trace]:
    """Put the runs of two recordings of one list together."""

    def put_together(first: Trace, second: Trace) -> Trace:
        second = replace(second, stamps=second.stamps + APART)
        pairs = {
            field.name: (getattr(first, field.name), getattr(second, field.name))
            for field in fields(Trace)
        }
        statuses = {"statuses": first.statuses + second.statuses}
        return Trace(**{name: np.concatenate(pair) for name, pair in pairs.items()} | statuses)

    return put_together


@dataclass(frozen=True)
class _StripeSequence:
    """A bright stripe that moves a little; labelled in every frame."""

    name: str = "stripe"
    description: str = "a stripe"
    length: int = 12
    visibility: float = 1.0

    def frame_count(self) -> int | None:
        return self.length

    def files(self) -> list[Path]:
        return []

    def frames(self, seed: int) -> Iterator[EvaluationFrame]:
        rng = np.random.default_rng(seed)
        for index in range(self.length):
            image = rng.integers(60, 80, (240, 320)).astype(np.uint8)
            left = 140 + index
            image[:, left : left + 40] += 90
            truth = CableState(left + 19.5 - 159.5, 0.0, 40.0, 0.0)
            stamp = 1_000_000_000 + index * FRAME_NS
            yield EvaluationFrame(index, stamp, image, truth, self.visibility)


@pytest.fixture(scope="session")
def stripe() -> EvaluationSequence:
    """An easy sequence of 12 frames."""
    return _StripeSequence()


@pytest.fixture(scope="session")
def results(stripe: EvaluationSequence) -> list[RunResult]:
    """What came of two methods on two sequences with two seeds."""
    sequences = (stripe, _StripeSequence("<other> & more"))
    campaign = Campaign(("default", "thesis"), sequences, (0, 1), Start.RANDOM, with_sheets=True)
    return evaluate_methods(campaign)


@pytest.fixture
def run_apart() -> Callable[[Campaign], list[RunResult]]:
    """Run a campaign alone in a fresh process, with the compiled loops that lie on disk.

    A process that compiles a loop keeps its own, and two that compile the same loop may differ in
    the last bit. Workers load what the first one has left on disk. So what is compared with them
    must load it too: one process compiles what there is not yet, another one tells.
    """

    def run(campaign: Campaign) -> list[RunResult]:
        for _ in ("compiles", "tells"):
            with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
                told = pool.submit(evaluate_methods, campaign).result()
        return told

    return run
