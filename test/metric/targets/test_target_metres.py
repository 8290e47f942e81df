import math

import numpy as np
import pytest

from cable_tracker.metric.calibration import Calibration, camera_for
from cable_tracker.metric.frames import Mounting
from cable_tracker.metric.odometry.motion import PoseChange, Unaided, rotations_by
from cable_tracker.metric.targets.relative_state import RelativeState
from cable_tracker.metric.targets.target_metres import (
    TargetRange,
    solid_angle_of_pixel,
    turn_of_picture,
)
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import TargetVehicleParameters
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import TrackingStatus

SIZE = (320, 240)
FOCAL = 250.0
CALIBRATION = Calibration(SIZE, "plumb_bob", (FOCAL, FOCAL), (159.5, 119.5))
AHEAD = Mounting(pitch=0.0)
STEP = 40_000_000
STILL = Unaided("nothing is known")


def camera():
    made = camera_for(CALIBRATION, SIZE)
    assert not isinstance(made, Withheld)
    return made


def estimate_of(
    place, number=0, size=0.4, status=TrackingStatus.TRACKING, is_whole=True, noise=0.0,
    has_outline=True,
):  # fmt: skip
    """What is seen of a target ahead, left, up [m]."""
    ahead, left, up = place
    state = np.zeros(6)
    state[0], state[1] = -FOCAL * left / ahead, FOCAL * up / ahead
    distance = math.hypot(*place)
    slant = ahead / distance
    area = (size / distance * FOCAL * math.exp(noise)) ** 2 / slant**3
    return TargetEstimate(
        1_000_000_000 + number * STEP, status, SIZE, state, np.eye(6), area=area, is_whole=is_whole,
        box=(0.0, 0.0, 1.0, 1.0) if has_outline else None,
    )  # fmt: skip


def way(x, y, z, turn=0.0):
    rotation = rotations_by(np.array([[0.0, 0.0, turn]]))[0]
    return PoseChange(rotation, np.array([x, y, z]), np.zeros((6, 6)), 0.04)


class TestTurnOfPicture:
    @pytest.mark.parametrize("turn", [(0.0, 0.0, 0.02), (0.0, 0.03, 0.0), (0.05, 0.0, 0.0)])
    def test_what_stands_still_moves_in_the_picture_as_the_camera_sees_it(self, turn):
        rotation = rotations_by(np.array([turn]))[0]
        motion = turn_of_picture(camera(), AHEAD, rotation)
        for place in ([4.0, 0.5, -0.3], [9.0, -2.0, 1.0]):
            before = estimate_of(place).state[None]
            after = estimate_of(np.array(place) @ rotation).state[:2]
            assert motion.moved(before, 1.0)[0, :2] == pytest.approx(after, abs=1e-6)

    def test_a_turn_to_the_left_moves_the_picture_to_the_right(self):
        rotation = rotations_by(np.array([[0.0, 0.0, 0.1]]))[0]
        moved = turn_of_picture(camera(), AHEAD, rotation).moved(np.zeros((1, 6)), 1.0)
        assert moved[0, 0] == pytest.approx(FOCAL * math.tan(0.1))

    def test_a_roll_turns_the_target(self):
        rotation = rotations_by(np.array([[0.1, 0.0, 0.0]]))[0]
        moved = turn_of_picture(camera(), AHEAD, rotation).moved(np.zeros((1, 6)), 1.0)
        assert abs(moved[0, 3]) == pytest.approx(0.1, abs=1e-6)

    @pytest.mark.parametrize("degrees", [70.0, 90.0, 120.0, 180.0])
    def test_a_turn_away_from_what_was_seen_says_nothing(self, degrees):
        rotation = rotations_by(np.array([[0.0, 0.0, math.radians(degrees)]]))[0]
        assert turn_of_picture(camera(), AHEAD, rotation) is None


class TestKnownSize:
    def test_bearing_and_range_are_those_of_the_target(self):
        meter = TargetRange(TargetVehicleParameters(target_size=0.4))
        place = [4.0, 0.6, -0.4]
        for number in range(5):
            said = meter.take(estimate_of(place, number), camera(), STILL)
        assert isinstance(said.relative, RelativeState)
        assert said.relative.position() == pytest.approx(place, rel=0.01)
        assert not isinstance(said.ray, Withheld)
        # Optical: right, down, ahead.
        expected = np.array([-0.6, 0.4, 4.0]) / math.hypot(*place)
        assert said.ray == pytest.approx(expected, abs=1e-9)

    def test_a_tilted_camera_gives_the_same_place_on_the_vehicle(self):
        tilted = Mounting(pitch=0.3)
        place = np.array([5.0, 0.3, -1.2])
        in_body = place @ (tilted.rotation @ AHEAD.rotation.T)
        meter = TargetRange(
            TargetVehicleParameters(camera_pitch=math.degrees(0.3), target_size=0.4)
        )
        said = meter.take(estimate_of(in_body), camera(), STILL)
        assert isinstance(said.relative, RelativeState)
        assert said.relative.position() == pytest.approx(place, rel=1e-3)

    def test_turns_of_the_vehicle_are_no_movement_of_the_target(self):
        meter = TargetRange(TargetVehicleParameters(target_size=0.4))
        place, turn = np.array([5.0, 0.0, 0.0]), 0.02
        for number in range(30):
            moved = way(0.0, 0.0, 0.0, turn)
            said = meter.take(estimate_of(place, number), camera(), moved if number else STILL)
            place = place @ moved.rotation
        assert isinstance(said.relative, RelativeState)
        assert abs(said.relative.mean[3]) < 0.02


class TestUnknownSize:
    def test_the_range_is_withheld_at_first(self):
        meter = TargetRange(TargetVehicleParameters())
        said = meter.take(estimate_of([5.0, 0.0, 0.0]), camera(), STILL)
        assert isinstance(said.relative, Withheld)
        assert said.relative.reason is Reason.RANGE_UNKNOWN
        assert "target_size" in str(said.relative)

    @pytest.mark.parametrize("distance", [2.0, 6.0, 12.0])
    @pytest.mark.parametrize("step", [(0.0, 0.02, 0.0), (0.015, 0.015, 0.0)])
    def test_parallax_makes_it_known(self, distance, step):
        meter = TargetRange(TargetVehicleParameters())
        rng = np.random.default_rng(3)
        place = np.array([distance, 0.2, 0.0])
        moved = way(*step)
        steps = round(0.25 * distance / 0.02)
        for number in range(steps + 1):
            seen = estimate_of(place, number, noise=0.03 * rng.standard_normal())
            seen.state[:2] += rng.normal(0.0, 1.0, 2)
            said = meter.take(seen, camera(), moved if number else STILL)
            place = place - np.array(step)
        assert isinstance(said.relative, RelativeState)
        off = abs(said.relative.range - math.hypot(*place))
        assert off < max(0.15 * math.hypot(*place), 2.5 * said.relative.range_sigma)

    def test_without_a_way_it_stays_unknown(self):
        meter = TargetRange(TargetVehicleParameters())
        for number in range(100):
            said = meter.take(estimate_of([5.0, 0.0, 0.0], number), camera(), STILL)
        assert isinstance(said.relative, Withheld)


class TestWithheld:
    @pytest.mark.parametrize("change", [{"status": TrackingStatus.LOST}, {"has_outline": False}])
    def test_nothing_is_told_without_a_claim_or_a_calibration(self, change):
        meter = TargetRange(TargetVehicleParameters(target_size=0.4))
        lost = meter.take(estimate_of([5.0, 0.0, 0.0], **change), camera(), STILL)
        assert isinstance(lost.ray, Withheld) and lost.ray.reason is Reason.NO_TARGET
        none = camera_for(None, SIZE)
        blind = meter.take(estimate_of([5.0, 0.0, 0.0], 1), none, STILL)
        assert isinstance(blind.ray, Withheld) and blind.ray.reason is Reason.NO_CALIBRATION


ZEROS = (0.0, 0.0, 0.0, 0.0)


class TestTheSolidAngleOfAPixel:
    def test_a_pinhole_sees_less_in_a_pixel_the_farther_from_its_axis(self):
        camera = camera_for(
            Calibration((640, 480), "plumb_bob", (200.0, 200.0), (319.5, 239.5)), (640, 480)
        )
        for x in (0.0, 100.0, 200.0):
            cosine = math.cos(math.atan(x / 200.0))
            seen = solid_angle_of_pixel(camera, np.array([x, 0.0]))
            assert seen == pytest.approx(cosine**3 / 200.0**2, rel=1e-4)

    def test_a_fisheye_sees_more_than_a_pinhole(self):
        fisheye = Calibration((640, 480), "equidistant", (200.0, 200.0), (319.5, 239.5), ZEROS)
        camera = camera_for(fisheye, (640, 480))
        for x in (50.0, 100.0, 157.0):
            angle = x / 200.0
            seen = solid_angle_of_pixel(camera, np.array([0.0, x]))
            assert seen == pytest.approx(math.sin(angle) / angle / 200.0**2, rel=1e-4)

    def test_beyond_the_reach_of_the_lens_there_is_none(self):
        folding = Calibration(
            (640, 480), "plumb_bob", (200.0, 200.0), (319.5, 239.5), (-1.2, 0.0, 0.0, 0.0)
        )
        camera = camera_for(folding, (640, 480))
        assert solid_angle_of_pixel(camera, np.array([310.0, 0.0])) == 0.0
        told = TargetRange(TargetVehicleParameters()).take(
            estimate_of((1.0, 1.2, 0.0)), camera, STILL
        )
        assert str(told.ray) == str(told.relative)
        assert str(told.ray).startswith("target beyond the lens: ")


@pytest.mark.parametrize("pitch", [0.0, 90.0])
@pytest.mark.parametrize("seed", range(4))
def test_a_camera_that_looks_down_ranges_by_parallax_as_well_as_one_that_looks_ahead(pitch, seed):
    mounting = Mounting(pitch=math.radians(pitch))
    meter = TargetRange(TargetVehicleParameters(camera_pitch=pitch))
    rng = np.random.default_rng(seed)
    errors = []
    for number in range(150):
        # The camera passes 5 cm beside a target 3 m away, across its line of sight.
        place = np.array([3.0, 0.05, 2.0 - 0.03 * number])
        noise = np.append(0.0, rng.normal(0.0, math.radians(0.3), 2))
        seen = estimate_of(place + 3.0 * noise, number, noise=0.03 * rng.standard_normal())
        step = mounting.body_rotation @ np.array([0.0, 0.0, 0.03])
        result = meter.take(seen, camera(), way(*step))
        if isinstance(result.relative, RelativeState):
            true = mounting.body_rotation @ place
            errors.append(np.linalg.norm(result.relative.position() - true))
    assert len(errors) > 100
    assert np.median(errors) < 0.1
    assert max(errors) < 0.5
