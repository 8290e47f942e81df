from __future__ import annotations

import numpy as np
import pytest
from hypothesis import strategies as st

from cable_tracker.metric.messages import (
    read_attitude,
    read_camera_info,
    read_range,
    read_twist,
)
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.simulation.instruments.instrument_messages import (
    make_camera_info,
    make_imu,
    make_odometry,
    make_range,
)
from cable_tracker.simulation.instruments.instruments import (
    ImuReading,
    InstrumentErrors,
    OdometryReading,
)
from cable_tracker.simulation.rendering.camera import Camera

FACTORY = RosbagsMessages()
HEADER = make_header(FACTORY, 1_000_000_000, "base_link")
ANGLES = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3.0, 3.0))


def test_the_tracker_reads_the_camera_as_it_is():
    camera = Camera((320, 240), 280.0, 0.3)
    calibration = read_camera_info(make_camera_info(FACTORY, HEADER, camera), is_rectified=False)
    assert calibration.image_size == (320, 240)
    assert calibration.focal == (280.0, 280.0)
    assert calibration.centre == (159.5, 119.5)


def test_the_tracker_reads_the_instruments_as_they_are():
    errors = InstrumentErrors()
    angles = np.array([0.02, -0.03, 1.0])
    imu = make_imu(FACTORY, HEADER, ImuReading(angles, np.zeros(3), np.zeros(3)), errors)
    attitude = read_attitude(imu, 0.0)
    assert (attitude.roll, attitude.pitch) == pytest.approx((0.02, -0.03))
    assert attitude.sigma == pytest.approx(errors.attitude)
    metres, (low, high) = read_range(make_range(FACTORY, HEADER, 2.0))
    assert metres == 2.0 and low < metres < high


def test_the_tracker_reads_the_twist_as_it_is():
    twist, covariance = np.arange(6.0), np.diag(np.arange(1.0, 7.0))
    reading = OdometryReading(np.zeros(3), np.zeros(3), np.eye(6), twist, covariance)
    read, doubt = read_twist(make_odometry(FACTORY, HEADER, reading), (0.0, 0.0))
    assert np.array_equal(read, twist)
    assert np.array_equal(doubt, covariance)
