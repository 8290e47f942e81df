from __future__ import annotations

from pathlib import Path

import pytest

from cable_tracker.gui.recording_request import RecordingRequest
from cable_tracker.sequences.bags.instruments import Instrument, InstrumentChoice

NAMED = InstrumentChoice({Instrument.ALTITUDE: "/dvl/altitude", Instrument.ODOMETRY: "none"})


@pytest.mark.parametrize(
    ("path", "choice"),
    [(Path(), NAMED), (Path("dive"), NAMED), (Path("other"), InstrumentChoice())],
)
def test_named_topics_are_those_of_the_recording_named_with_them_or_of_the_first(path, choice):
    assert RecordingRequest(path, choice=NAMED).choice_for(Path("dive")) == choice
