from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from cable_tracker.errors import RecordingError, RosError
from cable_tracker.ros.clients.lockstep import _finish, replay_parameters
from cable_tracker.sequences.bags.instruments import InstrumentChoice
from cable_tracker.sequences.source_base import ChosenRecording


def ended(code: int | None) -> SimpleNamespace:
    """Return a replay that has ended with a code, or goes on."""
    return SimpleNamespace(wait=lambda timeout: code, last_line=lambda: "its last words")


def test_a_replay_ends_as_the_recording_does():
    _finish(ended(0), None)
    _finish(ended(2), RecordingError("damaged after 3 frames"))


@pytest.mark.parametrize(
    ("code", "damage"), [(2, None), (0, RecordingError("damaged")), (-9, None)]
)
def test_a_replay_that_ends_otherwise_is_an_error_with_its_last_words(code, damage):
    with pytest.raises(RosError, match=f"exit code {code} after all frames: its last words"):
        _finish(ended(code), damage)


def test_a_replay_that_does_not_end_is_an_error():
    with pytest.raises(RosError, match="has not ended for 120 s after all frames"):
        _finish(ended(None), None)


def test_a_path_that_is_no_utf8_is_refused_before_a_node_is_started():
    recording = ChosenRecording(Path(os.fsdecode(b"caf\xe9/dive")))
    with pytest.raises(RosError, match="a path that is not UTF-8 cannot be told to a node"):
        replay_parameters(recording, InstrumentChoice(), None, has_instruments=False)
