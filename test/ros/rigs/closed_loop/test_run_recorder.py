from __future__ import annotations

from typing import Any

import pytest

from cable_tracker.errors import RosError
from cable_tracker.ros.process.node_group import NodeGroup
from cable_tracker.ros.rigs.closed_loop import run_recorder
from cable_tracker.ros.rigs.closed_loop.run_recorder import QUIET_TURNS, listen_to_the_end


class Run:
    """Recorder, executor and simulator of a run in one: what happens in which turn.

    The simulator ends in turn `end`; a message comes in each turn of `messages`.
    """

    def __init__(self, end: int, messages: tuple[int, ...] = ()) -> None:
        self.turns = self.heard = 0
        self._end = end
        self._messages = messages

    def spin_once(self, timeout_sec: float) -> None:
        del timeout_sec
        self.turns += 1
        self.heard += self.turns in self._messages

    @property
    def running(self) -> bool:
        return self.turns < self._end

    def take(self) -> list[Any]:
        return []


def listen(run: Any, group: Any = None) -> None:
    listen_to_the_end(
        run,
        run,
        group or NodeGroup("/run"),
        run,
        show=[].append,
        has_settled=lambda _: True,
    )


@pytest.mark.parametrize("last", [5, 5 + QUIET_TURNS])
def test_it_ends_when_many_turns_in_a_row_have_brought_nothing(last):
    run = Run(5, (2, last))
    listen(run)
    assert run.turns == last + QUIET_TURNS


def test_a_simulator_that_has_sent_nothing_for_a_while_has_not_ended():
    run = Run(3 * QUIET_TURNS)
    listen(run)
    assert run.turns == 4 * QUIET_TURNS


def test_it_complains_when_nothing_has_come_for_too_long(monkeypatch):
    now = [100.0]

    class Slow(Run):
        def spin_once(self, timeout_sec: float) -> None:
            super().spin_once(timeout_sec)
            now[0] += 0.5 * run_recorder.SILENCE_TIMEOUT

    monkeypatch.setattr(run_recorder.time, "monotonic", lambda: now[0])
    run = Slow(9)
    with pytest.raises(RosError, match=r"nothing came for 300 s; is the machine too busy\?"):
        listen(run)
    assert run.turns == 3


def test_a_node_that_has_died_ends_it():
    class Died:
        def what_has_died(self) -> str:
            return "the tracker node has died: nonsense"

    with pytest.raises(RosError, match="tracker node has died: nonsense"):
        listen(Run(9), Died())
