"""Pictures without a claim are read again where the dive has told where the cable is."""

import math
from dataclasses import replace

import numpy as np
import pytest
from survey_dives import DISK, LOOK, Plan, make_dive, poses_of, true_aside

from cable_tracker.metric.calibration import Calibration, CameraModel
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.survey.frame_table import HIDDEN, NOT_AGAIN, SEEN, TRACKING
from cable_tracker.survey.keyframes import make_keyframes
from cable_tracker.survey.redetection import place_in_image, redetect_cable
from cable_tracker.survey.routes.route import Course
from cable_tracker.survey.smoother import smooth

WIDTH, HEIGHT, FOCAL, ALTITUDE, DIAMETER = 320, 240, 300.0, 2.0, 0.16
CAMERA = CameraModel(
    Calibration((WIDTH, HEIGHT), "plumb_bob", (FOCAL, FOCAL), ((WIDTH - 1) / 2, (HEIGHT - 1) / 2))
)
VIEW = GroundView(CAMERA, Mounting(x=LOOK), Attitude(0.0, 0.0, 0.0), ALTITUDE, 0.02)
PLAN = Plan(hidden=((15.0, 22.0),))
DUG_OUT = 20.0
"""The tracker claims the cable from 22 m on, but it can be seen from here."""


def picture(rng, aside: float, heading: float, seen_from: float) -> np.ndarray:
    """Draw a bright cable beside a look line as a level camera sees it, ahead of some place."""
    columns, rows = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    left = -(columns - (WIDTH - 1) / 2) * ALTITUDE / FOCAL
    ahead = -(rows - (HEIGHT - 1) / 2) * ALTITUDE / FOCAL
    off = (left - aside - ahead * math.tan(heading)) * math.cos(heading)
    image = 60.0 + 8.0 * rng.standard_normal((HEIGHT, WIDTH))
    image[(np.abs(off) < DIAMETER / 2) & (ahead > seen_from)] += 70.0
    return np.clip(image, 0, 255).astype(np.uint8)


@pytest.fixture
def dive():
    """A dive whose pictures show the cable before the tracker has found it again."""
    made = make_dive(PLAN)
    made.view = VIEW
    rows = made.table.rows
    rows["altitude"], rows["roll"], rows["pitch"] = ALTITUDE, 0.0, 0.0
    poses = poses_of(made).at(rows["stamp"])
    rng = np.random.default_rng(0)

    class Pictures:
        @staticmethod
        def chosen_frames(wanted):
            for k, row in enumerate(rows):
                if wanted(int(row["stamp"])):
                    aside, heading = true_aside(poses[k], PLAN.bend)
                    way = 0.05 * k + LOOK
                    seen_from = -9.0 if way < 15.0 else DUG_OUT - way
                    image = raw_from_array(picture(rng, aside, heading, seen_from), "mono8")
                    yield Frame(int(row["frame"]), int(row["stamp"]), image)

    made.recording = Pictures()
    return made


def course_of(dive) -> Course:
    poses = poses_of(dive)
    keyframes = make_keyframes(dive.table.rows, poses.at(dive.table.rows["stamp"]), DISK)
    return Course(poses, keyframes, smooth(keyframes, DISK))


def test_a_cable_that_the_tracker_missed_is_found_and_claimed(dive):
    rows = dive.table.rows
    way = 0.05 * np.arange(len(rows)) + LOOK
    found = redetect_cable(dive, course_of(dive))
    dug_out = (way > DUG_OUT + 0.5) & (way < 22.0)
    assert (rows["again"] == SEEN).sum() == found
    assert (rows["again"][dug_out] == SEEN).mean() > 0.9
    truth = [true_aside(pose, PLAN.bend)[0] for pose in poses_of(dive).at(rows["stamp"])]
    off = np.abs(rows["aside"] - truth)[dug_out & (rows["again"] == SEEN)]
    assert np.median(off) < DIAMETER / 4


def test_where_it_is_buried_nothing_is_claimed(dive):
    rows = dive.table.rows
    way = 0.05 * np.arange(len(rows)) + LOOK
    redetect_cable(dive, course_of(dive))
    buried = (way > 16.0) & (way < DUG_OUT - 1.0)
    assert (rows["again"][buried] == HIDDEN).all()
    assert np.isnan(rows["aside"][buried]).all()
    assert (rows["profile_score"][buried].astype(float).mean(axis=1) < 1.6).all()


def test_claims_that_count_stay_as_they_are(dive):
    rows = dive.table.rows
    claimed = rows["status"] == TRACKING
    before = rows[claimed].copy()
    course = course_of(dive)
    redetect_cable(dive, course)
    assert (rows["again"][claimed] == NOT_AGAIN).mean() > 0.95
    same = rows["again"][claimed] == NOT_AGAIN
    assert (rows["aside"][claimed][same] == before["aside"][same]).all()


def test_pictures_that_had_another_size_are_searched_at_their_own(dive):
    course = course_of(dive)
    smaller = CameraModel(
        Calibration(
            (WIDTH // 2, HEIGHT // 2),
            "plumb_bob",
            (FOCAL / 2, FOCAL / 2),
            ((WIDTH / 2 - 1) / 2, (HEIGHT / 2 - 1) / 2),
        )
    )
    dive.view = replace(VIEW, camera=smaller)
    way = 0.05 * np.arange(len(dive.table.rows)) + LOOK
    redetect_cable(dive, course)
    dug_out = (way > DUG_OUT + 0.5) & (way < 22.0)
    assert (dive.table.rows["again"][dug_out] == SEEN).mean() > 0.9


def test_a_dive_without_metres_is_not_read_again(dive):
    course = course_of(dive)
    dive.view = None
    assert redetect_cable(dive, course) == 0


@pytest.mark.parametrize("attitude", [(0.0, 0.0), (0.05, -0.1), (-0.2, 0.1)])
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.3, 0.2), (-0.4, -0.5)])
def test_a_place_on_the_ground_is_where_the_camera_sees_it(attitude, place):
    view = GroundView(CAMERA, Mounting(x=LOOK, pitch=1.4), Attitude(*attitude, 0.0), ALTITUDE, 0.02)
    state = place_in_image(view, LOOK, place, DIAMETER)
    foot = state.distance * np.array([math.cos(state.angle), math.sin(state.angle)])
    along = np.array([-math.sin(state.angle), math.cos(state.angle)])
    points = view.on_ground(np.array([foot - 30.0 * along, foot + 30.0 * along]))
    aside, heading = place
    off = (points[:, 1] - aside) * math.cos(heading) - (points[:, 0] - LOOK) * math.sin(heading)
    assert off == pytest.approx(0.0, abs=0.01)


def test_a_cable_far_ahead_converges_upwards_and_not_the_other_way_round():
    # The ground below the vehicle's middle lies behind this camera.
    view = GroundView(CAMERA, Mounting(x=1.0, pitch=math.radians(25.0)), Attitude(), 1.5, 0.02)
    look = float(view.on_ground(np.zeros((1, 2)))[0, 0])
    state = place_in_image(view, look, (0.2, 0.1), DIAMETER)
    assert 0.0 < state.skew < 0.1
    assert state.width > 0.0
