from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from sensor_msgs.msg import CameraInfo, JointState, PointCloud2, Range
from std_srvs.srv import Trigger

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.methods import BASELINES, METHODS
from cable_tracker.sequences.messages.cable import read_state

FRAMES = 6


@pytest.mark.parametrize("method", BASELINES)
def test_a_baseline_publishes_the_estimate_of_its_method(
    world: Any,
    image_message: Callable[..., Any],
    strip: Callable[..., np.ndarray],
    stamp_of_index: Callable[[int], int],
    method: str,
) -> None:
    node = world.baseline(method=method)
    states = world.listen(JointState, "state")
    reports = world.listen(DiagnosticArray, "tracker/frame_report")
    alone = METHODS[method].make(0)
    for index in range(FRAMES):
        world.show(node, image_message(index=index))
        estimate = alone.process(strip(), stamp_of_index(index))
    world.spin(lambda: len(states) == len(reports) == FRAMES)
    assert reports[-1].status[0].message == estimate.status.value == "TRACKING"
    published = read_state(states[-1])
    assert published is not None
    # OpenCV and NumPy may add up in another order where the pixels lie otherwise in memory.
    assert published.to_array() == pytest.approx(estimate.state.to_array(), abs=1e-6)


def test_a_baseline_publishes_the_cross_track_in_metres(
    world: Any, image_message: Callable[..., Any], truth: CableState
) -> None:
    node = world.baseline(method="hough", fixed_altitude=2.0)
    cross_tracks = world.listen(PoseWithCovarianceStamped, "cross_track")
    info = CameraInfo(width=320, height=240, distortion_model="plumb_bob")
    info.k = [300.0, 0.0, 159.5, 0.0, 300.0, 119.5, 0.0, 0.0, 1.0]
    camera = world.me.create_publisher(CameraInfo, "camera_info", 10)
    altimeter = world.me.create_publisher(Range, "altitude", 10)
    world.spin(lambda: camera.get_subscription_count() and altimeter.get_subscription_count())
    camera.publish(info)
    world.pass_time(0.3)
    for index in range(FRAMES):
        world.show(node, image_message(index=index))
    world.spin(lambda: cross_tracks)
    # The camera looks straight down; what is to the right of the image is to the right of it.
    expected = -truth.distance / 300.0 * 2.0
    assert cross_tracks[-1].pose.pose.position.y == pytest.approx(expected, abs=0.03)


def test_a_baseline_publishes_no_particles(world: Any, image_message: Callable[..., Any]) -> None:
    clouds = world.listen(PointCloud2, "particles")
    states = world.listen(JointState, "state")
    node = world.baseline(method="lsd")
    world.show(node, image_message())
    world.spin(lambda: states)
    assert clouds == []


def test_a_baseline_can_be_reset(world: Any, image_message: Callable[..., Any]) -> None:
    node = world.baseline(method="hough")
    states = world.listen(JointState, "state")
    for index in range(FRAMES):
        world.show(node, image_message(index=index))
    node.on_reset(Trigger.Request(), Trigger.Response())
    world.show(node, image_message(index=FRAMES))
    world.spin(lambda: len(states) == FRAMES + 1)
    assert read_state(states[FRAMES - 1]) is not None
    assert read_state(states[FRAMES]) is None


def test_our_own_filters_are_no_baselines(world: Any) -> None:
    with pytest.raises(ParameterError, match="method"):
        world.baseline(method="default")
