"""Follow a cable by `cross_track`: what a controller of one's own needs to know.

position.y     metres; the cable's lateral offset, positive: the cable is to the left
yaw            radians; the cable's direction, positive: the cable leads to the left
covariance     [7] and [35] are the variances of the two
header.stamp   time of the picture, not of the message: the difference is the latency
lost           no message comes, so a controller must have a timeout of its own
"""

import math

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

SPEED, LOOK_AHEAD, TURN_GAIN, TIMEOUT = 0.5, 1.2, 1.2, 0.5


class FollowCable(Node):
    def __init__(self, **arguments):
        super().__init__("follow_cable", **arguments)
        self.commands = self.create_publisher(Twist, "cmd_vel", 10)
        self.create_subscription(PoseWithCovarianceStamped, "cross_track", self.follow, 10)
        self.watchdog = self.create_timer(TIMEOUT, self.stop)

    def follow(self, message):
        self.watchdog.reset()
        pose, command = message.pose.pose, Twist()
        heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        course = heading + math.atan2(pose.position.y * math.cos(heading), LOOK_AHEAD)
        command.linear.x = SPEED * max(math.cos(course), 0.0)
        command.angular.z = TURN_GAIN * course
        self.commands.publish(command)

    def stop(self):
        self.commands.publish(Twist())


if __name__ == "__main__":
    rclpy.init()
    try:
        rclpy.spin(FollowCable())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:
        # A signal came between two waits: rclpy began to wait with a context that was gone.
        if rclpy.ok():
            raise
