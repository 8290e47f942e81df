from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped, Twist, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image


def test_in_lockstep_every_command_brings_a_frame_until_the_time_is_over(world: Any) -> None:
    images = world.listen(Image, "image")
    infos = world.listen(CameraInfo, "camera_info")
    odometry = world.listen(Odometry, "odometry")
    truths = world.listen(PoseWithCovarianceStamped, "ground_truth/target")
    node = world.target_simulator(
        lockstep=True, duration=1.0, image_width=160, image_height=120, odometry_readers=1
    )
    for count in range(1, 14):
        world.spin(lambda count=count: len(images) == count)
        node.on_command(Twist())
    world.spin(lambda: node.finished)
    world.spin(lambda: min(len(infos), len(truths)) == len(images))
    assert odometry
    assert images[0].encoding == "bgr8"
    place = truths[0].pose.pose.position
    assert 2.5 < math.hypot(place.x, place.y, place.z) < 3.5
    assert truths[0].pose.covariance[0] == 0.0


def test_the_vehicle_obeys_cmd_vel(world: Any) -> None:
    commands = {
        "still": Twist(),
        "ahead": Twist(linear=Vector3(x=0.6)),
        "left": Twist(angular=Vector3(z=0.4)),
        "up": Twist(linear=Vector3(z=0.2)),
    }
    last = {name: _driven(world, command) for name, command in commands.items()}
    still = last["still"]
    assert last["ahead"].x < still.x - 0.2
    assert math.atan2(last["left"].y, last["left"].x) < math.atan2(still.y, still.x) - 0.1
    assert last["up"].z < still.z - 0.05


def _driven(world: Any, command: Twist) -> Any:
    """Return where the target is in base_link after two seconds of one command [m]."""
    publisher = world.me.create_publisher(Twist, "cmd_vel", 10)
    images = world.listen(Image, "image")
    truths = world.listen(PoseWithCovarianceStamped, "ground_truth/target")
    node = world.target_simulator(
        lockstep=True, duration=2.0, rate=10.0, image_width=160, image_height=120,
        odometry_readers=0, hidden_for=0.0, current=0.0, speed=0.0,
    )  # fmt: skip
    world.spin(lambda: publisher.get_subscription_count() == 1)
    while not node.finished:
        count = len(images)
        world.spin(lambda count=count: len(images) > count or node.finished)
        publisher.publish(command)
    # It has ended, and does no more.
    world.nodes.remove(node)
    world.spin(lambda: len(truths) == node.frames)
    world.me.destroy_publisher(publisher)
    world.executor.remove_node(node)
    node.destroy_node()
    return truths[-1].pose.pose.position
