"""Listen to a tracker and set one of its parameters, where there is no `ros2` command.

centreline     comes while a cable is claimed: foot point [px] and direction [rad]
state          comes for every frame; its lists are empty while no cable is claimed
parameters     are set by name; an answer says whether each was taken, or why not
services       `reset` forgets everything, as `ros2 service call /tracker/reset` does
"""

import math

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger


class WatchTracker(Node):
    def __init__(self, **arguments):
        super().__init__("watch_tracker", **arguments)
        self.create_subscription(PoseWithCovarianceStamped, "centreline", self.on_cable, 10)
        self.create_subscription(JointState, "state", self.on_state, 10)
        self.parameters = AsyncParameterClient(self, "tracker")
        self.reset = self.create_client(Trigger, "tracker/reset")

    def on_cable(self, message):
        foot, turn = message.pose.pose.position, message.pose.pose.orientation
        alpha = 2 * math.atan2(turn.z, turn.w)
        print(
            f"centreline: x {foot.x:.1f} px, y {foot.y:.1f} px, alpha {alpha:.3f} rad", flush=True
        )

    def on_state(self, message):
        values = zip(message.name, message.position, strict=False)
        numbers = ", ".join(f"{name} {value:.3g}" for name, value in values)
        print(f"state: {numbers or 'no cable is claimed'}", flush=True)

    def set(self, name, value):
        self.parameters.set_parameters([Parameter(name, value=value)], self.on_answer)

    def on_answer(self, future):
        for result in future.result().results:
            print("taken" if result.successful else f"refused: {result.reason}", flush=True)


if __name__ == "__main__":
    rclpy.init()
    try:
        node = WatchTracker()
        print("waiting for the tracker", flush=True)
        node.parameters.wait_for_services()
        node.set("particle_count", 1000)
        # node.reset.call_async(Trigger.Request())
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:
        # A signal came between two waits: rclpy began to wait with a context that was gone.
        if rclpy.ok():
            raise
