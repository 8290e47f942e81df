import math

import numpy as np
import pytest
from instrument_messages import camera_info, imu, odometry

from cable_tracker.metric.targets.target_instrument_fusion import TargetInstrumentFusion
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import TargetVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import TrackingStatus

SECOND = 1_000_000_000
FRAME = SECOND // 25
SIZE = (320, 240)
TURN = 0.5


def seen(index):
    """A target in the middle of the image, of 20 px by 20 px."""
    return TargetEstimate(
        SECOND + index * FRAME, TrackingStatus.TRACKING, SIZE, np.zeros(6), np.eye(6), area=400.0,
        is_whole=True, box=(0.0, 0.0, 20.0, 20.0),
    )  # fmt: skip


def turn_of(fusion, instrument, make):
    """Show two frames while the vehicle turns; return what that does to the second."""
    for index in range(2):
        stamp = SECOND + index * FRAME
        fusion.take_message(instrument, stamp, make(turn=TURN + 1e-3 * index))
        motion = fusion.camera_motion(stamp, SIZE)
        fusion.take([seen(index)])
    return motion


def target_fusion(**others):
    """Return a fusion that knows the calibration of the camera."""
    fusion = TargetInstrumentFusion(TargetVehicleParameters(**others))
    fusion.take_message(Instrument.CAMERA_INFO, SECOND, camera_info())
    return fusion


@pytest.mark.parametrize(
    ("instrument", "make"), [(Instrument.IMU, imu), (Instrument.ODOMETRY, odometry)]
)
def test_turns_are_known_from_imu_and_odometry(instrument, make):
    fusion = target_fusion()
    motion = turn_of(fusion, instrument, make)
    assert fusion.unaided is None
    # What is ahead moves to the right when the vehicle turns to the left.
    assert motion.homography[0, 2] == pytest.approx(280.0 * math.tan(TURN * 0.04), rel=0.01)


def test_an_imu_that_measures_no_turns_says_nothing():
    fusion = target_fusion()
    assert turn_of(fusion, Instrument.IMU, lambda turn: imu(turn, measures_turns=False)) is None
    assert fusion.unaided.why == "no odometry has come"


def test_an_imu_whose_turns_may_be_anything_says_nothing():
    def unsure(turn):
        message = imu(turn)
        message.angular_velocity_covariance = np.diag([UNKNOWN_VARIANCE] * 3).ravel().tolist()
        return message

    assert turn_of(target_fusion(), Instrument.IMU, unsure) is None


def test_a_turn_away_from_what_was_seen_is_not_taken_out():
    fusion = target_fusion()
    fast = math.radians(80.0) / 0.04
    assert turn_of(fusion, Instrument.IMU, lambda turn: imu(turn=turn + fast)) is None
    assert "turned away" in fusion.unaided.why


def test_turns_can_be_left_in():
    fusion = target_fusion(motion_aid=False)
    assert turn_of(fusion, Instrument.ODOMETRY, odometry) is None
    assert fusion.unaided.why == "the parameter motion_aid is false"


def test_a_target_of_known_size_has_a_range():
    (metres,) = target_fusion(target_size=0.5).take([seen(0)])
    assert metres.relative.range == pytest.approx(0.5 * 280.0 / 20.0, rel=0.01)


def test_other_values_read_the_calibration_anew():
    fusion = target_fusion(target_size=0.5)
    fusion.configure(TargetVehicleParameters(target_size=0.5, image_is_rectified=True))
    (metres,) = fusion.take([seen(0)])
    assert metres.relative.range == pytest.approx(0.5 * 250.0 / 20.0, rel=0.01)


def test_a_calibration_that_is_given_wins_over_messages(calibrations):
    fusion = TargetInstrumentFusion(TargetVehicleParameters(), calibrations["pinhole"])
    (before,) = fusion.take([seen(0)])
    fusion.take_message(Instrument.CAMERA_INFO, SECOND, camera_info(640))
    (after,) = fusion.take([seen(1)])
    assert after.ray.tolist() == before.ray.tolist()


def test_without_a_calibration_there_is_no_bearing():
    (metres,) = TargetInstrumentFusion(TargetVehicleParameters()).take([seen(0)])
    assert isinstance(metres.ray, Withheld)
    assert metres.ray.reason is Reason.NO_CALIBRATION
