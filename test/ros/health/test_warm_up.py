from __future__ import annotations

import threading

import pytest

from cable_tracker.ros.health import warm_up
from cable_tracker.ros.health.warm_up import WarmUp


@pytest.fixture(autouse=True)
def cold(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warm_up, "_WARM", set())


def test_a_warm_up_runs_in_the_background_and_once_for_each_variant() -> None:
    go_on, runs = threading.Event(), []

    def wait(name: str) -> None:
        runs.append(name)
        assert go_on.wait(300.0)

    first = WarmUp("a", lambda: wait("a"))
    assert first.running
    go_on.set()
    first.finish()
    assert not first.running
    assert not WarmUp("a", lambda: wait("a")).running
    assert runs == ["a"]
    WarmUp("b", lambda: wait("b")).finish()
    assert runs == ["a", "b"]


def test_an_error_is_raised_where_the_end_is_waited_for() -> None:
    def fail() -> None:
        raise ZeroDivisionError("no code")

    failing = WarmUp("a", fail)
    with pytest.raises(ZeroDivisionError, match="no code"):
        failing.finish()


def test_warm_ups_run_one_at_a_time_and_a_waiting_one_can_be_abandoned() -> None:
    go_on, runs = threading.Event(), []

    def wait(name: str) -> None:
        runs.append((name, threading.get_ident()))
        assert go_on.wait(300.0)

    first = WarmUp("a", lambda: wait("a"))
    needless = WarmUp("b", lambda: wait("b"))
    last = WarmUp("c", lambda: wait("c"))
    needless.abandon()
    go_on.set()
    for each in (first, needless, last):
        each.finish()
    assert [name for name, _ in runs] == ["a", "c"]
    assert len({thread for _, thread in runs}) == 1
    WarmUp("b", lambda: wait("b")).finish()
    assert runs[-1][0] == "b"
