from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
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
