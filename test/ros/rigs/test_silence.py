import time

from cable_tracker.ros.rigs.silence import SILENCE_TIMEOUT, SilenceWatch


def test_it_complains_when_nothing_has_come_for_too_long(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    silence = SilenceWatch()
    now[0] += SILENCE_TIMEOUT
    assert not silence.complaint()
    now[0] += 1.0
    assert "nothing came for 90 s" in silence.complaint()
    silence.hear()
    assert not silence.complaint()
