"""The part of the tracker node that knows the vehicle: instruments in, `cross_track` out.

And odometry in, the vehicle's motion for the filter out.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from typing import cast

from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry as OdometryMessage
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import CameraInfo, Imu, Range

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.metric.aiding import MotionAiding
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.instruments import Instruments, InstrumentSettings
from cable_tracker.metric.messages import (
    make_cross_track,
    read_attitude,
    read_camera_info,
    read_range,
    read_twist,
)
from cable_tracker.metric.motion import Odometry
from cable_tracker.metric.settings import instrument_settings
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import METRIC_PARAMETERS
from cable_tracker.ros import qos
from cable_tracker.ros.inputs.callbacks import followed_by
from cable_tracker.ros.inputs.instruments_sent import InstrumentsSent
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.node_topics import NodeTopic

INSTRUMENTS = (node_topics.ALTITUDE, node_topics.IMU, node_topics.ODOMETRY)
"""Instruments whose measurements have a time."""


WARNING_PAUSE = 10.0
"""Odometry that is doubted again sooner is not warned of again [s]."""


class MetricInputs:
    """Listens to the instruments, and publishes `cross_track`.

    Parameters
    ----------
    node : Node
        The tracker node.
    factory : MessageFactory
        Makes its messages.
    """

    def __init__(self, node: Node, factory: MessageFactory) -> None:
        self._node = node
        self._factory = factory
        self._values: dict[str, object] = {spec.name: spec.default for spec in METRIC_PARAMETERS}
        self._info: Message | None = None
        self._result: CrossTrack | Withheld = Withheld(Reason.NOT_TRACKING, "no frame has come")
        self._instruments = Instruments(self._settings())
        self._odometry = Odometry()
        self._aiding = MotionAiding(self._instruments, self._odometry)
        self._why_unaided = ""
        self._foot = node.create_publisher(
            PoseWithCovarianceStamped, node_topics.CROSS_TRACK.name, qos.RESULTS
        )
        self._ahead = node.create_publisher(
            PoseWithCovarianceStamped, node_topics.CROSS_TRACK_AHEAD.name, qos.RESULTS
        )
        self._newest: dict[NodeTopic, int] = {}
        self._heard: Counter[str] = Counter()
        self._sent = InstrumentsSent((node_topics.CAMERA_INFO, *INSTRUMENTS))

    def subscribe(self, reliability: str, on_news: Callable[[], None]) -> None:
        """Listen, `best_effort` or `reliable`; `on_news` is called after each message."""
        profile = qos.instrument_input(reliability)
        for kind, topic, take in (
            (CameraInfo, node_topics.CAMERA_INFO, self.on_camera_info),
            (Range, node_topics.ALTITUDE, self.on_altitude),
            (Imu, node_topics.IMU, self.on_imu),
            (OdometryMessage, node_topics.ODOMETRY, self.on_odometry),
        ):
            self._node.create_subscription(kind, topic.name, followed_by(take, on_news), profile)
        self._sent.subscribe(self._node, reliability, on_news)

    @property
    def publishers(self) -> tuple[Publisher, ...]:
        """Those of `cross_track` and `cross_track_ahead`."""
        return self._foot, self._ahead

    @property
    def wait(self) -> float:
        """How long a frame may be held back for the instruments [s]."""
        return self._number("instrument_wait")

    def has_all_of(self, stamp: int) -> bool:
        """Tell whether every instrument has said something of a time [ns] or later.

        Where a replay says how much it has sent before the frame of that time, all of it must have
        come.
        """
        if self._sent.tells_of(stamp):
            return self._sent.has_come(self._heard)
        return self._info is not None and all(
            self._newest.get(topic, -1) >= stamp for topic in INSTRUMENTS
        )

    @property
    def result(self) -> CrossTrack | Withheld:
        """Metres of the last frame."""
        return self._result

    def _number(self, name: str) -> float:
        return float(cast(float, self._values[name]))

    def _settings(self) -> InstrumentSettings:
        return instrument_settings(self._values)

    def apply(self, values: Mapping[str, object]) -> None:
        """Take what is given of `METRIC_PARAMETERS`, by name."""
        own = {name: values[name] for name in values.keys() & self._values.keys()}
        if not own:
            return
        self._values.update(own)
        self._instruments.configure(self._settings())
        if self._info is not None:
            self._use_calibration(self._info)

    def on_camera_info(self, message: Message) -> None:
        """Take a calibration."""
        self._heard[node_topics.CAMERA_INFO.name] += 1
        self._use_calibration(message)

    def _use_calibration(self, message: Message) -> None:
        is_rectified = bool(self._values["image_is_rectified"])
        self._instruments.take_calibration(read_camera_info(message, is_rectified=is_rectified))
        self._info = message

    def on_altitude(self, message: Message) -> None:
        """Take an altitude."""
        metres, limits = read_range(message)
        stamp = self._note(node_topics.ALTITUDE, message)
        self._instruments.take_altitude(stamp, metres, limits)

    def on_imu(self, message: Message) -> None:
        """Take roll and pitch."""
        least = math.radians(self._number("imu_sigma"))
        self._instruments.take_attitude(
            self._note(node_topics.IMU, message), read_attitude(message, least)
        )

    def on_odometry(self, message: Message) -> None:
        """Take a twist of base_link."""
        least = (
            self._number("velocity_sigma"),
            math.radians(self._number("turn_sigma")),
        )
        self._odometry.add(self._note(node_topics.ODOMETRY, message), *read_twist(message, least))

    def motion(self, stamp: int, image: Image) -> MotionAid | None:
        """Return how the cable has moved since the frame before; `image` (H, W), `stamp` [ns].

        None without odometry, or while it disagrees with what the camera sees.
        """
        if not self._values["motion_aid"]:
            self._why_unaided = "the parameter motion_aid is false"
            return None
        motion = self._aiding.motion(stamp, image)
        why, before = self._aiding.why_not, self._why_unaided
        self._why_unaided = why
        if "disagrees" in why and why != before:
            self._node.get_logger().warning(
                f"the filter goes on without odometry: {why}", throttle_duration_sec=WARNING_PAUSE
            )
        return motion

    def _note(self, topic: NodeTopic, message: Message) -> int:
        """Return the stamp of an instrument's message [ns], and remember it."""
        stamp = self._stamp_of(message)
        self._newest[topic] = stamp
        self._heard[topic.name] += 1
        return stamp

    def _stamp_of(self, message: Message) -> int:
        return stamp_of(message.header) or int(self._node.get_clock().now().nanoseconds)

    def publish(self, header: Message, estimate: CableEstimate) -> None:
        """Publish the cable of an estimate in metres, if it can be told, and learn from it."""
        self._aiding.observe(estimate)
        before, result = self._result, self._instruments.cross_track(estimate)
        self._result = result
        if isinstance(result, Withheld):
            self._tell(before, result)
            return
        frame = str(self._values["base_frame"])
        own_header = make_header(self._factory, stamp_of(header), frame)
        for publisher, ahead, (offset, covariance) in (
            (self._foot, 0.0, result.at_foot()),
            (self._ahead, result.look_ahead, result.ahead()),
        ):
            place = (ahead, offset, result.depth)
            publisher.publish(
                make_cross_track(self._factory, own_header, place, result.heading, covariance)
            )

    def _tell(self, before: CrossTrack | Withheld, result: Withheld) -> None:
        """Say once why there are no metres. That no cable is claimed is said elsewhere."""
        is_new = not isinstance(before, Withheld) or before.reason is not result.reason
        if is_new and result.reason is not Reason.NOT_TRACKING:
            self._node.get_logger().info(f"no cross_track: {result}")

    def diagnostics(self) -> dict[str, str]:
        """Return what diagnostics say about metres, with units in the keys."""
        result = self._result
        is_known = isinstance(result, CrossTrack)
        return {
            "cross track [m]": f"{result.offset:.3f}" if isinstance(result, CrossTrack) else "",
            "cable diameter [m]": (
                f"{result.diameter:.3f}" if isinstance(result, CrossTrack) else ""
            ),
            "no metres": "" if is_known else str(result),
            "no motion aid": self._why_unaided,
            "odometry error [px]": self._odometry_error(),
        }

    def _odometry_error(self) -> str:
        """Return how far from the prediction the sea bed moved; empty if that is not known."""
        seen = self._aiding.seen
        return f"{seen.error:.1f} of {seen.length:.1f}" if seen is not None else ""
