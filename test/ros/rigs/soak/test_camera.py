from __future__ import annotations

import math
from array import array
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Point32, Polygon, PolygonStamped, PoseWithCovarianceStamped
from sensor_msgs.msg import Image, JointState
from visualization_msgs.msg import Marker, MarkerArray

from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.ros.rigs.soak.camera import SoakCamera, is_finite
from cable_tracker.ros.rigs.soak.record import SoakRecord
from cable_tracker.ros.rigs.soak.soaked_node import CABLE_NODE
from cable_tracker.sequences.messages.cable import make_particles
from cable_tracker.sequences.messages.headers import make_header


def cloud(value: float) -> Any:
    rows = np.zeros((3, 9))
    rows[1, 2] = value
    return make_particles(RclpyMessages(), make_header(RclpyMessages(), 1, "eye"), rows)


def covariance(value: float) -> Any:
    message = PoseWithCovarianceStamped()
    message.pose.covariance[7] = value
    return message


def orientation(value: float) -> Any:
    message = PoseWithCovarianceStamped()
    message.pose.pose.orientation.w = value
    return message


def diagnostic(value: float) -> Any:
    pair = KeyValue(key="n_eff", value=f"{value!r} of 500")
    return DiagnosticArray(status=[DiagnosticStatus(level=b"\0", values=[pair])])


MAKERS = [
    lambda value: JointState(effort=array("d", [0.0, value])),
    lambda value: MarkerArray(markers=[Marker(points=[Point(x=value)])]),
    lambda value: PolygonStamped(polygon=Polygon(points=[Point32(), Point32(y=value)])),
    cloud,
    covariance,
    orientation,
    diagnostic,
]


@pytest.mark.parametrize("make", MAKERS)
def test_a_published_nan_is_detected(make):
    assert is_finite(make(1.5))
    assert not is_finite(make(math.nan))
    assert not is_finite(make(math.inf))


def test_pixels_and_words_without_numbers_are_finite():
    assert is_finite(Image(data=array("B", [255])))
    assert is_finite(DiagnosticArray(status=[DiagnosticStatus(message="INFINITE nano")]))


@pytest.fixture
def camera(context: Any, namespace: str) -> Any:
    camera = SoakCamera(context, namespace, SoakRecord(), CABLE_NODE)
    yield camera
    camera.close()


def test_an_empty_picture_breaks_a_promise(camera):
    camera._check("overlay", Image(data=array("B", [1])))
    assert camera._record.breaches == []
    camera._check("overlay", Image())
    assert len(camera._record.breaches) == 1


def test_a_tracker_that_publishes_nan_breaks_a_promise(camera):
    teller = camera.create_publisher(JointState, "state", 10)
    teller.publish(
        JointState(header=make_header(RclpyMessages(), 1, "eye"), position=array("d", [math.nan]))
    )
    assert camera.spin_until(lambda: camera.answers == 1, 300.0)
    assert camera._record.breaches == ["a number on state is not finite, or a picture is empty"]
    assert camera.last_stamp == 1
    assert camera.last_claims


def test_waiting_ends_after_its_time_limit(camera):
    assert not camera.spin_until(lambda: False, 0.05)
