import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError
from cable_tracker.evaluation.runs import MethodRun, Start, run_together


class Recorder:
    """Says what it was told, and remembers what it was asked."""

    def __init__(self, outcome, seed):
        self.outcome, self.seed = outcome, seed
        self.told, self.seen = [], []

    def initialise(self, given):
        self.told.append(given.state)

    def process(self, image, stamp):
        self.seen.append(image)
        return self.outcome(len(self.seen)).estimate


@pytest.fixture
def made():
    return []


@pytest.fixture
def make(outcome, made):
    def make_one(seed):
        made.append(Recorder(outcome, seed))
        return made[-1]

    return make_one


def test_the_truth_is_told_once_and_without_rates(make, made, stripe):
    run_together([MethodRun("m", make, 3, Start.TRUTH)], stripe.frames(0), "stripe")
    (method,) = made
    first = next(stripe.frames(0)).truth
    assert method.told == [CableState(first.distance, first.angle, first.width, first.skew)]
    assert method.seed == 3


def test_nothing_is_told_at_a_random_start(make, made, stripe):
    run_together([MethodRun("m", make, 0, Start.RANDOM)], stripe.frames(0), "stripe")
    assert made[0].told == []


def test_a_restart_makes_another_method_with_another_seed(make, made, stripe):
    run = MethodRun("m", make, 7, Start.RANDOM, restart_every=5)
    run_together([run], stripe.frames(0), "stripe")
    assert [len(method.seen) for method in made] == [5, 5, 2]
    assert len({method.seed for method in made}) == 3


def test_all_methods_see_the_same_frames_once(make, made, stripe):
    runs = [MethodRun(name, make, 0, Start.TRUTH) for name in "ab"]
    results = run_together(runs, stripe.frames(0), "stripe")
    first, second = (method.seen for method in made)
    assert all(a is b for a, b in zip(first, second, strict=True))
    assert [(result.method, result.sequence, len(result.trace)) for result in results] == [
        ("a", "stripe", 12),
        ("b", "stripe", 12),
    ]


def test_the_progress_is_told_after_each_frame(make, stripe):
    calls = []
    run_together(
        [MethodRun("m", make, 0, Start.TRUTH)],
        stripe.frames(0),
        "stripe",
        calls.append,
    )
    assert len(calls) == 12


def test_a_frame_that_is_refused_is_one_without_a_claim(outcome, stripe):
    class Refusing(Recorder):
        def process(self, image, stamp):
            estimate = super().process(image, stamp)
            if len(self.seen) in {4, 7}:
                raise FrameError("it has the time of the frame before")
            return estimate

    run = MethodRun("m", lambda seed: Refusing(outcome, seed), 0, Start.RANDOM, with_sheet=True)
    (result,) = run_together([run], stripe.frames(0), "stripe")
    assert (result.refused, result.refusal) == (2, "frame 3: it has the time of the frame before")
    assert len(result.trace) == 12
    assert np.flatnonzero(~result.trace.claimed).tolist() == [3, 6]
    assert np.isnan(result.trace.estimates).all(axis=1).nonzero()[0].tolist() == [3, 6]
    assert np.isfinite(
        [result.metrics[f"rmse_{axis}"] for axis in ("d", "alpha", "w", "beta")]
    ).all()


def test_a_sheet_is_a_jpeg_picture_and_only_there_if_asked_for(make, stripe):
    runs = [MethodRun("m", make, 0, Start.TRUTH, with_sheet=flag) for flag in (True, False)]
    with_sheet, without = run_together(runs, stripe.frames(0), "stripe")
    picture = cv2.imdecode(np.frombuffer(with_sheet.sheet, np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape[1] > 200
    assert without.sheet == b""
