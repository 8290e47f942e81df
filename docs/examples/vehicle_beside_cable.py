"""Where the vehicle is beside the cable, for a filter such as robot_localization's ekf_node.

`cross_track` says where the cable is in base_link; a filter wants to know where base_link is in a
frame of the world. Here that frame is `cable`: x runs along the cable, y to its left.
"""

import math

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

Y, YAW = 7, 35
Y_YAW, YAW_Y = 11, 31
"""Places in a covariance of 6x6."""


def vehicle_beside_cable(cross_track, frame="cable"):
    """Return the pose of base_link in the cable's frame, with its covariance."""
    pose = cross_track.pose.pose
    offset, yaw = pose.position.y, 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
    given = cross_track.pose.covariance
    # y' = -offset cos(yaw), yaw' = -yaw; by offset and by yaw:
    a, b = -math.cos(yaw), offset * math.sin(yaw)
    message = PoseWithCovarianceStamped()
    message.header.stamp = cross_track.header.stamp
    message.header.frame_id = frame
    message.pose.pose.position.y = -offset * math.cos(yaw)
    message.pose.pose.orientation.z = math.sin(-yaw / 2.0)
    message.pose.pose.orientation.w = math.cos(yaw / 2.0)
    covariance = [0.0] * 36
    for row in (0, 2, 3, 4):
        covariance[7 * row] = 1e6
    covariance[Y] = a * a * given[Y] + 2.0 * a * b * given[Y_YAW] + b * b * given[YAW]
    covariance[Y_YAW] = covariance[YAW_Y] = -(a * given[Y_YAW] + b * given[YAW])
    covariance[YAW] = given[YAW]
    message.pose.covariance = covariance
    return message


class VehicleBesideCable(Node):
    def __init__(self, **node_arguments):
        super().__init__("vehicle_beside_cable", **node_arguments)
        self._out = self.create_publisher(PoseWithCovarianceStamped, "vehicle_beside_cable", 10)
        self.create_subscription(PoseWithCovarianceStamped, "cross_track", self.on_cable, 10)

    def on_cable(self, message):
        self._out.publish(vehicle_beside_cable(message))


if __name__ == "__main__":
    rclpy.init()
    try:
        rclpy.spin(VehicleBesideCable())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:
        # A signal came between two waits: rclpy began to wait with a context that was gone.
        if rclpy.ok():
            raise
