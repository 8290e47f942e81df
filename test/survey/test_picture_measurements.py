import math
from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.calibration import Calibration, CameraModel
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.frames import Attitude, Mounting
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.survey.picture_measurements import (
    border_profile,
    border_step_of,
    find_beside,
    write_metres,
    write_view,
)

CAMERA = CameraModel(Calibration((320, 240), "plumb_bob", (300.0, 300.0), (159.5, 119.5)))

WIDTH, HEIGHT = 320, 240


@pytest.mark.parametrize(("turn", "reach"), [(0.0, 159.5), (90.0, 119.5), (180.0, 159.5)])
def test_how_far_the_camera_sees_to_either_side_does_not_depend_on_how_it_is_turned(turn, reach):
    view = GroundView(CAMERA, Mounting(yaw=math.radians(turn)), Attitude(), 2.0, 0.02)
    row = {}
    write_view(row, view, SimpleNamespace(image_size=(320, 240)))
    assert row["half_view"] == pytest.approx(2.0 * reach / 300.0)


def test_a_camera_that_looks_ahead_sees_as_far_to_the_side_as_its_middle_row():
    view = GroundView(CAMERA, Mounting(pitch=math.radians(50.0)), Attitude(), 2.0, 0.02)
    row = {}
    write_view(row, view, SimpleNamespace(image_size=(320, 240)))
    ends = view.on_ground(np.array([[-159.5, 0.0], [159.5, 0.0]]))
    assert row["half_view"] == pytest.approx(0.5 * (ends[0, 1] - ends[1, 1]))


@pytest.mark.parametrize("look_ahead", [0.0, 1.0])
def test_the_place_looked_at_does_not_depend_on_the_look_ahead(look_ahead):
    heading, covariance = 0.3, np.diag([0.01, 0.02, 0.004, 0.001])
    ahead = 0.5 + look_ahead * math.tan(heading)
    row = {"look": 2.0}
    write_metres(row, CrossTrack(0.5, ahead, heading, 0.2, covariance, look_ahead, -3.0))
    slope = 2.0 / math.cos(heading) ** 2
    assert row["aside"] == pytest.approx(0.5 + 2.0 * math.tan(heading))
    assert row["aside_variance"] == pytest.approx(0.01 + slope**2 * 0.004)
    assert row["aside_heading"] == pytest.approx(slope * 0.004)
    assert row["heading_variance"] == pytest.approx(0.004)


def picture(rng, *, covered_above: int = 0) -> np.ndarray:
    """A bright upright cable 40 px wide on a dark noisy bottom, covered down to a row."""
    image = 60.0 + 8.0 * rng.standard_normal((HEIGHT, WIDTH))
    image[covered_above:, 140:180] += 60.0
    return np.clip(image, 0, 255).astype(np.uint8)


STATE = CableState(0.0, 0.0, 40.0, 0.0)


def test_a_cable_that_is_there_is_seen_all_along():
    along, scores = border_profile(picture(np.random.default_rng(0)), STATE)
    assert (scores > 2.0).all()
    assert along[0] > along[-1]


def test_where_the_sand_begins_it_is_seen_no_longer():
    along, scores = border_profile(picture(np.random.default_rng(0), covered_above=120), STATE)
    assert (scores[along > 20] < 1.6).all()
    assert (scores[along < -20] > 2.0).all()


def test_a_claim_beside_the_cable_is_not_seen():
    beside = CableState(90.0, 0.0, 40.0, 0.0)
    _, scores = border_profile(picture(np.random.default_rng(0)), beside)
    assert np.median(scores) < 1.6


@pytest.mark.parametrize(
    "state", [CableState(400.0, 0.0, 40.0, 0.0), CableState(0.0, 0.0, 0.5, 0.0)]
)
def test_what_lies_outside_or_has_no_width_is_not_judged(state):
    assert border_profile(picture(np.random.default_rng(0)), state) is None


@pytest.mark.parametrize("shift", [-37.0, 0.0, 22.0])
def test_a_cable_beside_its_place_is_found_there(shift):
    expected = CableState(-shift, 0.0, 40.0, 0.0)
    beside, clear = find_beside(picture(np.random.default_rng(1)), expected, 1.2)
    assert beside * 40.0 == pytest.approx(shift, abs=5.0)
    assert clear > 3.0


def test_where_there_is_none_nothing_is_clear():
    bottom = picture(np.random.default_rng(2), covered_above=HEIGHT)
    bottom = np.where(bottom > 90, 60, bottom).astype(np.uint8)
    assert find_beside(bottom, STATE, 1.2)[1] < 2.0


def test_the_step_of_the_borders_is_that_of_the_part_that_is_seen():
    half = np.array([[4.0] * 6 + [0.1] * 6])
    assert border_step_of(half) == pytest.approx([4.0])


def test_a_round_body_is_seen_about_as_clearly_as_a_flat_one_though_its_shading_has_slopes():
    across = np.linspace(-1.0, 1.0, 40)
    bottom = 60.0 + 8.0 * np.random.default_rng(3).standard_normal((HEIGHT, WIDTH))
    bottom[:, 140:180] = 60.0 + 60.0 * np.sqrt(1.0 - across**2)
    image = np.clip(bottom, 0, 255).astype(np.uint8)
    _, of_round = border_profile(image, CableState(0.0, 0.0, 35.0, 0.0))
    _, of_flat = border_profile(picture(np.random.default_rng(3)), STATE)
    assert np.median(of_round) > 0.5 * np.median(of_flat)
