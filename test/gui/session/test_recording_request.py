from __future__ import annotations

from pathlib import Path

import pytest

from cable_tracker.gui.session.recording_request import RecordingRequest
from cable_tracker.sequences.bags.instruments import Instrument, InstrumentChoice

NAMED = InstrumentChoice({Instrument.ALTITUDE: "/dvl/altitude", Instrument.ODOMETRY: "none"})


VEHICLE = Path("vehicle.yaml")


@pytest.mark.parametrize(
    ("path", "choice", "vehicle"),
    [
        (Path(), NAMED, VEHICLE),
        (Path("dive"), NAMED, VEHICLE),
        (Path("other"), InstrumentChoice(), None),
    ],
)
def test_topics_and_vehicle_are_those_of_the_recording_named_with_them_or_of_the_first(
    path, choice, vehicle
):
    request = RecordingRequest(path, choice=NAMED, vehicle=VEHICLE, init="truth", rate=5.0)
    expected = RecordingRequest(
        Path("dive"), choice=choice, vehicle=vehicle, init="truth", rate=5.0
    )
    assert request.for_other(Path("dive")) == expected
