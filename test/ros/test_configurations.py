"""What ships for rviz2, Foxglove, diagnostic_aggregator and robot_localization fits the nodes."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from sensor_msgs.msg import JointState

from cable_tracker.ros.messages.rclpy_messages import message_class

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "config"
TYPES = {
    "rviz_default_plugins/Image": "sensor_msgs/msg/Image",
    "rviz_default_plugins/MarkerArray": "visualization_msgs/msg/MarkerArray",
    "rviz_default_plugins/PointCloud2": "sensor_msgs/msg/PointCloud2",
    "rviz_default_plugins/PoseWithCovariance": "geometry_msgs/msg/PoseWithCovarianceStamped",
}
"""What the displays of rviz2 read."""
SHOWN = {
    "sensor_msgs/msg/PointCloud2",
    "visualization_msgs/msg/MarkerArray",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
}
"""What Foxglove's 3D panel draws, of what we have."""


@pytest.fixture
def published(world: Any) -> dict[str, str]:
    """Types of the tracker's topics by name, as of a tracker without a namespace."""
    node = world.tracker()
    pairs = node.get_publisher_names_and_types_by_node(node.get_name(), world.namespace)
    return {name.removeprefix(world.namespace): types[0] for name, types in pairs}


def load(name: str) -> Any:
    text = (CONFIG / name).read_text(encoding="utf-8")
    return json.loads(text) if name.endswith(".json") else yaml.safe_load(text)


def test_rviz_shows_what_the_tracker_publishes(published: dict[str, str]) -> None:
    displays = load("rviz.rviz")["Visualization Manager"]["Displays"]
    assert {display["Class"] for display in displays} == set(TYPES)
    for display in displays:
        assert published[display["Topic"]["Value"]] == TYPES[display["Class"]]


def panels(layout: Any) -> Iterator[str]:
    if isinstance(layout, str):
        yield layout
    else:
        yield from (*panels(layout["first"]), *panels(layout["second"]))


def field_type(type_name: str, path: str) -> str:
    """Return the type of a field of a message, by a path such as `pose.position.x` or `a[0]`."""
    for word in path.split("."):
        name = word.partition("[")[0]
        fields = message_class(type_name).get_fields_and_field_types()
        type_name = fields[name]
        if "[" in word:
            type_name = re.sub(r"^sequence<(.*)>$|\[\d*\]$", r"\1", type_name)
        type_name = re.sub(r"^(\w+)/(\w+)$", r"\1/msg/\2", type_name)
    return type_name


class TestFoxglove:
    def test_every_panel_of_the_layout_is_configured_and_the_other_way_round(self) -> None:
        layout = load("foxglove.json")
        assert sorted(panels(layout["layout"])) == sorted(layout["configById"])

    def test_the_foxglove_layout_has_overlay_scene_plots_and_diagnostics(self) -> None:
        kinds = {name.partition("!")[0] for name in load("foxglove.json")["configById"]}
        assert kinds == {"Image", "3D", "Plot", "DiagnosticSummary", "DiagnosticStatusPanel"}

    def test_every_topic_is_one_of_the_tracker_and_of_the_right_type(
        self, published: dict[str, str]
    ) -> None:
        for name, panel in load("foxglove.json")["configById"].items():
            kind = name.partition("!")[0]
            if kind == "Image":
                topic = panel["imageMode"]["imageTopic"]
                assert published[topic] in (
                    "sensor_msgs/msg/Image",
                    "sensor_msgs/msg/CompressedImage",
                )
            elif kind == "3D":
                assert {published[topic] for topic in panel["topics"]} <= SHOWN
            elif kind == "Plot":
                for path in panel["paths"]:
                    topic, _, field = path["value"].partition(".")
                    assert field_type(published[topic], field) == "double"
            else:
                assert published[panel["topicToRender"]] == "diagnostic_msgs/msg/DiagnosticArray"


def test_the_aggregator_finds_the_status_of_tracker_and_controller(world: Any, header: Any) -> None:
    heard = world.listen(DiagnosticArray, "/diagnostics")
    group = load("diagnostic_aggregator.yaml")["analyzers"]["ros__parameters"]["cable_tracker"]

    def is_found(name: str) -> bool:
        told = {status.name for array in heard for status in array.status}
        words = group["analyzers"][name]["contains"]
        return any(word in each for word in words for each in told)

    world.tracker(diagnostics_period=0.1)
    world.spin(lambda: is_found("tracker"))
    # It tells its mode once it has one: with the first answer.
    controller = world.controller(settle_time=0.01)
    controller.on_state(JointState(header=header(0)))
    world.spin(lambda: is_found("controller"))


@pytest.fixture
def example(load_example: Callable[[str], Any]) -> Any:
    return load_example("vehicle_beside_cable.py")


def cross_track(offset: float, yaw: float, covariance: np.ndarray) -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped()
    message.pose.pose.position.y = offset
    message.pose.pose.orientation.z = math.sin(yaw / 2)
    message.pose.pose.orientation.w = math.cos(yaw / 2)
    whole = np.eye(6) * 1e6
    whole[np.ix_([1, 5], [1, 5])] = covariance
    message.pose.covariance = whole.ravel()
    return message


class TestRobotLocalization:
    def test_its_inputs_are_the_examples_pose_and_the_vehicles_odometry(
        self, world: Any, example: Any
    ) -> None:
        values = load("robot_localization.yaml")["ekf_filter_node"]["ros__parameters"]
        node = world.add(
            example.VehicleBesideCable(context=world.context, namespace=world.namespace)
        )
        topics = dict(node.get_publisher_names_and_types_by_node(node.get_name(), world.namespace))
        assert f"{world.namespace}/{values['pose0']}" in topics
        assert values["odom0"] == "odometry"
        for name in ("pose0_config", "odom0_config"):
            assert len(values[name]) == 15
        used = [index for index, use in enumerate(values["pose0_config"]) if use]
        assert used == [1, 5]
        assert values["world_frame"] == values["odom_frame"] == "cable"

    def test_a_cable_to_the_left_puts_the_vehicle_to_its_right(self, example: Any) -> None:
        pose = example.vehicle_beside_cable(cross_track(0.5, 0.0, np.eye(2) * 0.01)).pose.pose
        assert pose.position.y == pytest.approx(-0.5)
        assert pose.orientation.w == pytest.approx(1.0)

    @pytest.mark.parametrize("yaw", [-1.0, 0.3])
    @pytest.mark.parametrize("offset", [-0.8, 0.4])
    def test_the_pose_is_that_of_the_vehicle_seen_from_the_cable(
        self, example: Any, offset: float, yaw: float
    ) -> None:
        message = example.vehicle_beside_cable(cross_track(offset, yaw, np.eye(2)))
        pose = message.pose.pose
        heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        turn = np.array([[math.cos(heading), -math.sin(heading)],
                         [math.sin(heading), math.cos(heading)]])  # fmt: skip
        # The cable's point beside the vehicle lies on the cable's own axis.
        point = np.array([0.0, pose.position.y]) + turn @ np.array([0.0, offset])
        assert point[1] == pytest.approx(0.0, abs=1e-12)
        assert message.header.frame_id == "cable"

    def test_its_covariance_is_that_of_samples(self, example: Any) -> None:
        mean, spread = np.array([0.6, 0.4]), np.array([[4e-4, 1e-4], [1e-4, 9e-4]])
        given = example.vehicle_beside_cable(cross_track(*mean, spread)).pose.covariance
        found = np.array(given).reshape(6, 6)[np.ix_([1, 5], [1, 5])]
        samples = np.random.default_rng(1).multivariate_normal(mean, spread, 200_000)
        turned = np.stack((-samples[:, 0] * np.cos(samples[:, 1]), -samples[:, 1]))
        assert found == pytest.approx(np.cov(turned), rel=0.05)
