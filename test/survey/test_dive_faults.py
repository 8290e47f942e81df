import numpy as np
import pytest
from survey_dives import DISK

from cable_tracker.survey.dive_faults import count_rows, find_faults
from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import REFUSED, STATUSES
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.recording import SurveySettings, analyse
from cable_tracker.survey.trajectory import Trajectory

CLAIMS = 20
NO_PLACES = np.full((CLAIMS, 3), np.nan)
MAXIMUM_GAP = 5.0


@pytest.fixture
def faults():
    """Tell of a dive of claims, each fifth of which was put into metres with such an outcome."""

    def tell(*outcomes):
        dive = ForwardDive("dive", DISK)
        for index in range(CLAIMS):
            row = dive.table.append()
            row["status"] = STATUSES.index("TRACKING")
            row["stamp"] = index * 40_000_000
            if index % 5 == 0:
                reason = outcomes[index // 5]
                row["reason"] = dive.table.reason_number(reason)
                row["aside"] = np.nan if reason else 0.1
        none = np.zeros(0, np.int64)
        trajectory = Trajectory(none, np.zeros((0, 3)))
        return find_faults(dive, trajectory, count_rows(dive, NO_PLACES, MAXIMUM_GAP), MAXIMUM_GAP)[
            1:
        ]

    return tell


def test_without_any_metres_it_is_said_that_there_are_none(faults):
    assert faults(*4 * ["no altitude"]) == ["no metres at all: no altitude"]


def test_the_share_is_that_of_the_claims_that_were_put_into_metres(faults):
    assert faults("", "no altitude", "", "") == ["no metres in 25% of the claims: no altitude"]


def test_of_several_reasons_each_has_its_share(faults):
    assert faults("no altitude", "no altitude", "no altitude", "stale altitude") == [
        "no metres in 75% of the claims: no altitude",
        "no metres in 25% of the claims: stale altitude",
    ]


def test_where_all_are_in_metres_nothing_is_said(faults):
    assert faults("", "", "", "") == []


SECOND = 1_000_000_000


@pytest.mark.parametrize(
    ("stamps", "words"),
    [
        ([0, 1, 2, 3], None),
        ([0, 1, 8, 9], "no pictures for up to 7 s"),
        ([0, 1, 5, 6], None),
        ([10, 11, 4, 5], "the clock of the camera jumps back"),
        ([0, 1, 0.9, 2], None),
    ],
)
def test_a_note_says_where_the_tracker_starts_anew(stamps, words):
    dive = ForwardDive("dive", DISK)
    for stamp in stamps:
        row = dive.table.append()
        row["status"], row["stamp"] = STATUSES.index("LOST"), round(stamp * SECOND)
    trajectory = Trajectory(np.zeros(0, np.int64), np.zeros((0, 3)))
    notes = find_faults(
        dive, trajectory, count_rows(dive, NO_PLACES[:4], MAXIMUM_GAP), MAXIMUM_GAP
    )[1:]
    assert notes == [] if words is None else (len(notes) == 1 and words in notes[0])


def test_pictures_that_could_not_be_used_are_counted():
    dive = ForwardDive("dive", DISK)
    for index in range(4):
        row = dive.table.append()
        row["status"] = REFUSED if index else STATUSES.index("LOST")
        row["stamp"] = index * SECOND
    trajectory = Trajectory(np.zeros(0, np.int64), np.zeros((0, 3)))
    notes = find_faults(dive, trajectory, count_rows(dive, NO_PLACES[:4], MAXIMUM_GAP), MAXIMUM_GAP)
    assert any(note.startswith("3 of 4 pictures could not be used") for note in notes)


@pytest.mark.parametrize(
    ("readings", "words"),
    [
        (np.arange(0, 40, 2), "odometry is too slow: 2.0 s from one reading to the next"),
        (np.arange(3600, 3640), "their clocks are 3600 s apart"),
        (np.array([-20, -19.5, 40, 40.5, 41.0]), "odometry was silent"),
        (np.array([3]), "a single reading of odometry"),
    ],
)
def test_why_no_picture_has_a_place_is_told_from_when_odometry_speaks(readings, words):
    dive = ForwardDive("dive", DISK)
    for index in range(4 * CLAIMS):
        dive.table.append()["stamp"] = index * SECOND // 4
    stamps = (readings * SECOND).astype(np.int64)
    trajectory = Trajectory(stamps, np.zeros((len(stamps), 3)))
    poses = trajectory.at(dive.table.rows["stamp"])
    (note,) = find_faults(dive, trajectory, count_rows(dive, poses, MAXIMUM_GAP), MAXIMUM_GAP)
    assert words in note


def test_odometry_that_does_not_count_for_want_of_an_orientation_is_told():
    dive = ForwardDive("dive", DISK, unusable_poses=7)
    dive.table.append()["status"] = STATUSES.index("LOST")
    trajectory = Trajectory(np.zeros(0, np.int64), np.zeros((0, 3)))
    said = find_faults(dive, trajectory, count_rows(dive, NO_PLACES[:1], MAXIMUM_GAP), MAXIMUM_GAP)
    assert any(note.startswith("7 readings of odometry have no orientation") for note in said)


@pytest.mark.parametrize(
    ("stamps", "seconds"),
    [
        ([0, 1, 2, 3], 3.0),
        ([0, 1, -100, -99], 2.0),
        ([0, 1, 3600, 3601], 2.0),
        ([5, 4], 0.0),
    ],
)
def test_a_clock_that_jumps_makes_a_recording_neither_longer_nor_shorter(stamps, seconds):
    dive = ForwardDive("dive", Disk(block=2))
    for stamp in stamps:
        dive.table.append()["stamp"] = stamp * SECOND
    surveyed, _ = analyse(dive, SurveySettings())
    assert surveyed.seconds == pytest.approx(seconds)
