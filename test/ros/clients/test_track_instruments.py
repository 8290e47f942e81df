"""`track --ros` and `track` on a bag with instruments."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from estimate_reader import read_estimates
from rosbags.highlevel import AnyReader

from cable_tracker import cli
from cable_tracker.offline.results import BAG
from cable_tracker.simulation.instruments.survey_bag import write_survey_bag
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings

pytestmark = pytest.mark.slow


def test_the_estimates_and_the_metres_are_the_same_with_ros_and_without(tmp_path, monkeypatch):
    bag = tmp_path / "dive"
    write_survey_bag(bag, SurveyDiveSettings(length=2.0, rate=8.0, image_size=(160, 120), seed=3))

    def tracked(name: str, *words: str) -> Path:
        output = tmp_path / name
        arguments = ["track", str(bag), "--output", str(output), "--no-video", "--no-pictures"]
        monkeypatch.setattr(sys, "argv", ["cable-tracker", *arguments, "--no-timing", *words])
        cli.main()
        return output / "estimates.csv"

    def main(name: str, *words: str) -> Path:
        try:
            return tracked(name, *words)
        except SystemExit as end:
            assert not end.code
            return tmp_path / name / "estimates.csv"

    plain, over_ros = main("plain"), main("over_ros", "--ros")
    rows = [row for row in read_estimates(plain) if row.metres is not None]
    assert rows
    assert plain.read_text() == over_ros.read_text()
    offline, live = (metres_in_bag(each.with_name(BAG)) for each in (plain, over_ros))
    assert [len(stamps) for stamps in offline.values()] == [len(rows), len(rows)]
    assert offline == live


def metres_in_bag(bag: Path) -> dict[str, list[bytes]]:
    """Return the serialised messages in metres, by the last part of their topics."""
    found: dict[str, list[bytes]] = {"cross_track": [], "cross_track_ahead": []}
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            name = connection.topic.rpartition("/")[2]
            if name in found:
                found[name].append(bytes(data))
    return found
