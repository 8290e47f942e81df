"""Names and types of what the tracker publishes, as they stand in a recorded bag."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class OutputTopic:
    """One output of the tracker.

    Attributes
    ----------
    name : str
        Relative to the tracker's namespace; the private ones under the node's name.
    type_name : str
        Message type.
    """

    name: str
    type_name: str


STATE = OutputTopic("state", "sensor_msgs/msg/JointState")
CENTRELINE = OutputTopic("centreline", "geometry_msgs/msg/PoseWithCovarianceStamped")
PARTICLES = OutputTopic("particles", "sensor_msgs/msg/PointCloud2")
MARKERS = OutputTopic("markers", "visualization_msgs/msg/MarkerArray")
OVERLAY = OutputTopic("tracker/overlay/compressed", "sensor_msgs/msg/CompressedImage")
FRAME_REPORT = OutputTopic("tracker/frame_report", "diagnostic_msgs/msg/DiagnosticArray")
DIAGNOSTICS = OutputTopic("diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
GROUND_TRUTH = OutputTopic("ground_truth", "sensor_msgs/msg/JointState")
IMAGE = OutputTopic("image", "sensor_msgs/msg/Image")
COMPRESSED_IMAGE = OutputTopic("image/compressed", "sensor_msgs/msg/CompressedImage")

INSTRUMENTS_SENT = "instruments_sent"
"""Topic on which a replay says how many messages of each instrument it has sent before a frame."""

EVERY_FRAME = (STATE, FRAME_REPORT)
"""Topics that are published for every frame, whatever becomes of it."""

USABLE_FRAME = (PARTICLES, MARKERS, OVERLAY)
"""Published (while there is a subscriber) for every frame that was not refused."""

TARGET = OutputTopic("target", "geometry_msgs/msg/PoseWithCovarianceStamped")
CONTOUR = OutputTopic("contour", "geometry_msgs/msg/PolygonStamped")
BOX = OutputTopic("box", "geometry_msgs/msg/PolygonStamped")
TRUE_BOX = OutputTopic("ground_truth/box", "geometry_msgs/msg/PolygonStamped")
"""Around what can be seen of a simulated target; without corners where it is out of view."""

BEARING = OutputTopic("bearing", "geometry_msgs/msg/Vector3Stamped")
RELATIVE_POSE = OutputTopic("relative_pose", "geometry_msgs/msg/PoseWithCovarianceStamped")
TARGET_OVERLAY = OutputTopic("target_tracker/overlay/compressed", "sensor_msgs/msg/CompressedImage")
TARGET_REPORT = OutputTopic("target_tracker/frame_report", "diagnostic_msgs/msg/DiagnosticArray")
