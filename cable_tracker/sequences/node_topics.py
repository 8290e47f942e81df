"""Names and types of the topics of our nodes, as they stand in a recorded bag.

The one source of these names: nodes publish and subscribe by them, recorders and pages listen by
them, and bags are written and read by them.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class NodeTopic:
    """A topic that a node publishes or listens to.

    Attributes
    ----------
    name : str
        Relative to the namespace of the node; the private ones under the node's name.
    type_name : str
        Message type.
    """

    name: str
    type_name: str

    @property
    def global_name(self) -> str:
        """Name outside any namespace, as in a bag."""
        return f"/{self.name}"

    def of_node(self, node: str) -> str:
        """Return the name that this private topic has at a node; `~` is the node itself."""
        return f"{node}/{self.name.partition('/')[2]}"


STATE = NodeTopic("state", "sensor_msgs/msg/JointState")
CENTRELINE = NodeTopic("centreline", "geometry_msgs/msg/PoseWithCovarianceStamped")
CROSS_TRACK = NodeTopic("cross_track", "geometry_msgs/msg/PoseWithCovarianceStamped")
CROSS_TRACK_AHEAD = NodeTopic("cross_track_ahead", "geometry_msgs/msg/PoseWithCovarianceStamped")
PARTICLES = NodeTopic("particles", "sensor_msgs/msg/PointCloud2")
MARKERS = NodeTopic("markers", "visualization_msgs/msg/MarkerArray")
RAW_OVERLAY = NodeTopic("tracker/overlay", "sensor_msgs/msg/Image")
OVERLAY = NodeTopic("tracker/overlay/compressed", "sensor_msgs/msg/CompressedImage")
FRAME_REPORT = NodeTopic("tracker/frame_report", "diagnostic_msgs/msg/DiagnosticArray")
DIAGNOSTICS = NodeTopic("diagnostics", "diagnostic_msgs/msg/DiagnosticArray")

TARGET = NodeTopic("target", "geometry_msgs/msg/PoseWithCovarianceStamped")
CONTOUR = NodeTopic("contour", "geometry_msgs/msg/PolygonStamped")
BOX = NodeTopic("box", "geometry_msgs/msg/PolygonStamped")
BEARING = NodeTopic("bearing", "geometry_msgs/msg/Vector3Stamped")
RELATIVE_POSE = NodeTopic("relative_pose", "geometry_msgs/msg/PoseWithCovarianceStamped")
TARGET_OVERLAY = NodeTopic("target_tracker/overlay/compressed", "sensor_msgs/msg/CompressedImage")
TARGET_REPORT = NodeTopic("target_tracker/frame_report", "diagnostic_msgs/msg/DiagnosticArray")

IMAGE = NodeTopic("image", "sensor_msgs/msg/Image")
COMPRESSED_IMAGE = NodeTopic("image/compressed", "sensor_msgs/msg/CompressedImage")

CAMERA_INFO = NodeTopic("camera_info", "sensor_msgs/msg/CameraInfo")
ALTITUDE = NodeTopic("altitude", "sensor_msgs/msg/Range")
IMU = NodeTopic("imu", "sensor_msgs/msg/Imu")
ODOMETRY = NodeTopic("odometry", "nav_msgs/msg/Odometry")
FIX = NodeTopic("fix", "sensor_msgs/msg/NavSatFix")

INSTRUMENTS_SENT = NodeTopic("instruments_sent", "sensor_msgs/msg/JointState")
"""On it a replay says how many messages of each instrument it has sent before a frame."""

INITIAL_STATE = NodeTopic("initial_state", "geometry_msgs/msg/PoseWithCovarianceStamped")
"""Says where the cable is."""

INITIAL_TARGET = NodeTopic("initial_target", "geometry_msgs/msg/PolygonStamped")
"""Says where a target is."""

COMMAND = NodeTopic("cmd_vel", "geometry_msgs/msg/Twist")
"""Velocity through the water that a controller or a follower wants."""

CLOCK = NodeTopic("clock", "rosgraph_msgs/msg/Clock")
"""Time of a replay or of a simulation."""

GROUND_TRUTH = NodeTopic("ground_truth", "sensor_msgs/msg/JointState")
TRUE_ODOMETRY = NodeTopic("ground_truth/odometry", "nav_msgs/msg/Odometry")
TRUE_CROSS_TRACK = NodeTopic(
    "ground_truth/cross_track", "geometry_msgs/msg/PoseWithCovarianceStamped"
)
TRUE_TARGET = NodeTopic("ground_truth/target", "geometry_msgs/msg/PoseWithCovarianceStamped")
TRUE_BOX = NodeTopic("ground_truth/box", "geometry_msgs/msg/PolygonStamped")
"""Around what can be seen of a simulated target; without corners where it is out of view."""


@dataclass(frozen=True, slots=True)
class TrackerTopics:
    """Topics of the tracker of cables or of that of targets, beside those that both have.

    Attributes
    ----------
    start : NodeTopic
        Takes where the cable or the target is.
    report : NodeTopic
        Comes for every frame, and tells its status.
    results, metres : tuple of NodeTopic
        Hold what is claimed, in pixels and in metres, in the order of publishing.
    pose : NodeTopic
        The one of those in metres that a controller follows.
    overlay : NodeTopic
        Holds the JPEG for people.
    """

    start: NodeTopic
    report: NodeTopic
    results: tuple[NodeTopic, ...]
    metres: tuple[NodeTopic, ...]
    pose: NodeTopic
    overlay: NodeTopic

    @property
    def node(self) -> str:
        """Name of the node."""
        return self.report.name.partition("/")[0]

    @property
    def of_frame(self) -> tuple[NodeTopic, ...]:
        """All topics that may speak of a frame, but the raw overlay."""
        always = (STATE, self.report)
        return (*always, *self.results, *self.metres, PARTICLES, MARKERS, self.overlay)


CABLE_TOPICS = TrackerTopics(
    start=INITIAL_STATE,
    report=FRAME_REPORT,
    results=(CENTRELINE,),
    metres=(CROSS_TRACK, CROSS_TRACK_AHEAD),
    pose=CROSS_TRACK,
    overlay=OVERLAY,
)
TARGET_TOPICS = TrackerTopics(
    start=INITIAL_TARGET,
    report=TARGET_REPORT,
    results=(TARGET, BOX, CONTOUR),
    metres=(BEARING, RELATIVE_POSE),
    pose=RELATIVE_POSE,
    overlay=TARGET_OVERLAY,
)
"""Of several targets the topics of the first."""
