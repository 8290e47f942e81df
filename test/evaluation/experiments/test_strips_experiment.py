"""Crisp strips: what they look like, and how they are counted."""

import math

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.experiments.strips_experiment import is_found, is_measured
from cable_tracker.evaluation.run_metrics import run_metrics
from cable_tracker.evaluation.runs import RunResult, Start
from cable_tracker.evaluation.trace import trace_of
from cable_tracker.simulation.worlds.strip import STRIP_SKEW, random_strip, simulate_strip

SIZE = (640, 480)


def strips(count: int) -> np.ndarray:
    """Return many random strips."""
    return np.array([random_strip(SIZE, np.random.default_rng(seed)) for seed in range(count)])


def test_strips_have_all_widths_angles_and_skews():
    states = strips(300)
    widths = states[:, 2] / 2
    assert widths.min() >= 4.0
    assert widths.max() <= 200.0
    assert (np.histogram(widths, (4, 8, 16, 32, 64, 120, 200))[0] > 10).all()
    assert (np.histogram(states[:, 1], 6, (-np.pi / 2, np.pi / 2))[0] > 20).all()
    assert np.abs(states[:, 3]).max() <= STRIP_SKEW
    assert (np.abs(np.rad2deg(states[:, 3])) > 15).any()


def test_a_strip_is_as_wide_as_its_truth_says():
    for seed in range(5):
        item = next(simulate_strip(seed))
        truth = item.frame.truth
        image = np.frombuffer(item.frame.image.data, np.uint8).reshape(480, 640).astype(float)
        across = np.arange(-truth.width, truth.width, 0.5)
        x = (truth.distance + across) * math.cos(truth.angle)
        y = (truth.distance + across) * math.sin(truth.angle)
        columns, rows = np.rint(x + 319.5).astype(int), np.rint(239.5 - y).astype(int)
        inside = (columns >= 0) & (columns < 640) & (rows >= 0) & (rows < 480)
        greys, places = image[rows[inside], columns[inside]], np.abs(across[inside])
        strip = greys[places < truth.width / 2 - 2]
        ground = greys[places > truth.width / 2 + 2]
        assert len(strip)
        if len(ground):
            assert abs(strip.mean() - ground.mean()) > 30


@pytest.fixture
def run(outcome):
    """Make a run of one strip from errors of d and w in its last frame, claimed or not."""

    def make(distance: float, width: float, claimed: bool) -> RunResult:
        truth = CableState(0.0, 0.0, 40.0)
        frames = [outcome(0, truth, claimed=False)]
        frames.append(outcome(1, truth, (distance, 0.0, width, 0.0), claimed=claimed))
        trace = trace_of(frames)
        metrics = run_metrics(trace, started_at_random=True)
        return RunResult("default", "strip", 0, Start.RANDOM, trace, metrics, b"")

    return make


@pytest.mark.parametrize(
    ("distance", "width", "claimed", "found", "measured"),
    [
        (0.0, 3.9, True, True, True),
        (0.0, 4.1, True, True, False),
        (30.0, 0.0, True, False, False),
        (0.0, 0.0, False, False, False),
    ],
)
def test_a_strip_counts_as_measured_only_with_its_width(
    run, distance, width, claimed, found, measured
):
    result = run(distance, width, claimed)
    assert (is_found(result), is_measured(result)) == (found, measured)
