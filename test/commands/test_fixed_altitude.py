"""What `track` and `survey` say of an altimeter that fell silent."""

import shutil
from contextlib import closing
from pathlib import Path

import pytest

from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings, write_survey_bag

SECOND = 1_000_000_000


@pytest.fixture
def silent(command):
    """A dive whose altimeter speaks for a second only, with a fixed altitude beside it."""
    write_survey_bag(Path("dive"), SurveyDiveSettings(length=1.5, image_size=(64, 48), rate=5.0))
    with closing(open_bag(Path("dive"))) as recorded, BagWriter(Path("silent")) as bag:
        topics = list(recorded.topics)
        messages = list(recorded.messages(topics))
        for each in messages:
            if each.topic != "/altitude" or each.time < messages[0].time + SECOND:
                bag.write_serialised(each.topic, each.msgtype, each.data, each.time)
    shutil.copy("dive/vehicle.yaml", "silent")
    with Path("silent/vehicle.yaml").open("a") as file:
        file.write("fixed_altitude: 2.0\n")
    return "silent"


@pytest.mark.parametrize(
    ("name", "options"),
    [
        pytest.param("track", ("--no-video", "--no-bag", "--no-pictures"), id="track"),
        # Two surveys, each with workers of its own.
        pytest.param("survey", (), id="survey", marks=pytest.mark.slow),
    ],
)
def test_the_use_of_a_fixed_altitude_is_noted_once(command, silent, name, options):
    code, said, notes = command(name, silent, "--output", "out", *options)
    assert code == 0
    words = " ".join((said + notes).split())
    assert words.count("fixed_altitude stands in: the last on altitude is more than") == 1
    # Of the dive itself nothing is to be said.
    assert "stands in" not in "".join(command(name, "dive", "--output", "other", *options)[1:])
