from __future__ import annotations

import threading
from typing import Any

import pytest

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.ros import warm_up
from cable_tracker.ros.warm_up import ENOUGH, WarmUp, few_particles, variant_of


@pytest.fixture(autouse=True)
def cold(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warm_up, "_WARM", set())


def test_words_choose_the_code_and_numbers_do_not() -> None:
    default = TrackerParameters()
    assert variant_of(TrackerParameters(particle_count=70, seed=3)) == variant_of(default)
    assert variant_of(TrackerParameters(filter="bootstrap")) != variant_of(default)
    assert variant_of(TrackerParameters(detector="none")) != variant_of(default)


def test_it_runs_beside_the_caller_and_once_for_each_variant(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    go_on, runs = threading.Event(), []

    def wait(parameters: TrackerParameters) -> None:
        runs.append(parameters)
        assert go_on.wait(10.0)

    monkeypatch.setattr(warm_up, "warm_up", wait)
    first = WarmUp(TrackerParameters(particle_count=9000))
    assert first.running
    go_on.set()
    first.finish()
    assert not first.running
    assert not WarmUp(TrackerParameters(seed=5)).running
    assert [run.particle_count for run in runs] == [ENOUGH]
    WarmUp(TrackerParameters(filter="bootstrap")).finish()
    assert len(runs) == 2


def test_few_particles_stay_few() -> None:
    assert few_particles(TrackerParameters(particle_count=50)).particle_count == 50


def test_an_error_is_raised_where_somebody_waits_for_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(parameters: Any) -> None:
        raise ZeroDivisionError("no code")

    monkeypatch.setattr(warm_up, "warm_up", fail)
    failing = WarmUp(TrackerParameters())
    with pytest.raises(ZeroDivisionError, match="no code"):
        failing.finish()
