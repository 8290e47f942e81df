import time

from cable_tracker.ros.rigs.closed_loop.silence import (
    QUIET_TURNS,
    SILENCE_TIMEOUT,
    QuietWatch,
    SilenceWatch,
)


def test_it_complains_when_nothing_has_come_for_too_long(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    silence = SilenceWatch()
    now[0] += SILENCE_TIMEOUT
    assert not silence.complaint()
    now[0] += 1.0
    assert f"nothing came for {SILENCE_TIMEOUT:g} s" in silence.complaint()
    silence.hear()
    assert not silence.complaint()


def test_it_is_quiet_when_many_turns_in_a_row_have_brought_nothing():
    quiet = QuietWatch()
    for _ in range(QUIET_TURNS - 1):
        quiet.turn(0)
    assert not quiet.is_quiet
    quiet.turn(1)
    for _ in range(QUIET_TURNS - 1):
        quiet.turn(1)
    assert not quiet.is_quiet
    quiet.turn(1)
    assert quiet.is_quiet
