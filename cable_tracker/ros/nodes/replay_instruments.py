"""The part of the replay node that sends the messages of the vehicle's instruments.

Everything is sent as it was recorded, in step with the frames: before a frame, what was received up
to it and shortly after it, as `InstrumentFeed` hands it out. So the tracker node gives the
same metres as `cable-tracker track`.
"""

from __future__ import annotations

from pathlib import Path

from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import CameraInfo, JointState

from cable_tracker.metric.cable_instrument_fusion import CABLE_INSTRUMENTS
from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.recorded_instruments import InstrumentFeed, recorded_vehicle
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher
from cable_tracker.ros.messages.rclpy_messages import message_class
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage
from cable_tracker.sequences.bags.instruments import TOPICS, Instrument, InstrumentChoice
from cable_tracker.sequences.bags.rosbags_messages import typestore
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.factory import MessageFactory
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.static_transforms import TF_STATIC, TF_TYPE
from cable_tracker.sequences.source_base import Source

BEGINNING = 5_000_000_000
"""Time before the first frame from which messages are sent, but for the calibration [ns]."""

NO_STATIC_WORDS = (
    f"{TF_STATIC} is not sent, for tf2_msgs is not installed; only viewers such as rviz miss it: a"
    " tracker does not listen to TF, its mounting goes by the parameters camera_*"
)


class InstrumentReplay:
    """Sends the instruments of a recording.

    Parameters
    ----------
    node : Node
        The replay node.
    factory : MessageFactory
        Makes its messages.
    recording : Source
        The open recording.
    choice : InstrumentChoice
        Topics that the user has chosen.
    vehicle_file : Path or None
        The user's `vehicle.yaml`.
    in_lockstep : bool
        Whether the tracker may wait for the instruments of every frame.

    Raises
    ------
    RecordingError
        A topic that was chosen is not there.
    ParameterError
        The vehicle file is not acceptable.
    """

    def __init__(
        self,
        node: Node,
        factory: MessageFactory,
        recording: Source,
        choice: InstrumentChoice,
        vehicle_file: Path | None,
        *,
        in_lockstep: bool,
    ) -> None:
        self._factory = factory
        vehicle = recorded_vehicle(recording, choice, vehicle_file)
        self._source = vehicle.source
        self._calibration = vehicle.vehicle.calibration
        found = {} if self._source is None else self._source.found.topics
        sent = {*found, *([Instrument.CAMERA_INFO] if self._calibration is not None else [])}
        self._publishers: dict[Instrument, Publisher] = {
            each: publisher(node, TOPICS[each], qos.INSTRUMENTS)
            for each in Instrument
            if each in sent
        }
        self._counts = None
        # Where there is nothing to send, a tracker that may wait has to hear that.
        if sent or in_lockstep:
            self._counts = publisher(node, node_topics.INSTRUMENTS_SENT, qos.INSTRUMENTS)
        self._sent = dict.fromkeys(CABLE_INSTRUMENTS, 0)
        self._feed = InstrumentFeed(None)
        self._is_first = True
        # Trackers have the mounting as parameters, and warn of it themselves.
        for note in vehicle.notes_on_recording:
            node.get_logger().warning(note)
        self._send_static(node)
        if sent:
            node.get_logger().info(f"instruments: {', '.join(each.value for each in sent)}")

    def _send_static(self, node: Node) -> None:
        """Publish `/tf_static` for viewers; trackers have the mounting as parameters."""
        messages = [] if self._source is None else list(self._source.static_messages())
        if not messages:
            return
        try:
            kind = message_class(TF_TYPE)
        except ImportError:
            node.get_logger().info(NO_STATIC_WORDS)
            return
        transforms = node.create_publisher(kind, TF_STATIC, qos.LATCHED)
        for _, message in messages:
            transforms.publish(bytes(typestore().serialize_cdr(message, TF_TYPE)))

    def unheard(self) -> list[Instrument]:
        """Return the instruments without a subscriber; fixes need none."""
        return [
            each
            for each, publisher in self._publishers.items()
            if each in CABLE_INSTRUMENTS and not publisher.get_subscription_count()
        ]

    def begin(self) -> None:
        """Go back to the beginning of the recording."""
        self.close()
        self._feed = InstrumentFeed(self._source)
        self._is_first = True

    def send_until(self, frame: Frame) -> None:
        """Send what belongs to a frame, before the frame itself."""
        first, self._is_first = self._is_first, False
        if self._calibration is not None:
            # As a camera driver does, with every frame: a tracker may be started again meanwhile.
            self._send_calibration(self._calibration, frame)
        for message in self._feed.up_to(frame):
            assert frame.received is not None
            is_calibration = message.instrument is Instrument.CAMERA_INFO
            if is_calibration and self._calibration is not None:
                continue
            is_old = message.received < frame.received - BEGINNING
            if is_calibration or not (first and is_old):
                self._send(message)
        if self._counts is not None:
            header = make_header(self._factory, frame.stamp, "")
            counts = self._factory.doubles([float(self._sent[each]) for each in CABLE_INSTRUMENTS])
            names = [each.value for each in CABLE_INSTRUMENTS]
            self._counts.publish(JointState(header=header, name=names, position=counts))

    def _send(self, given: InstrumentMessage) -> None:
        publisher = self._publishers[given.instrument]
        type_name = TOPICS[given.instrument].type_name
        publisher.publish(bytes(typestore().serialize_cdr(given.as_ros2(), type_name)))
        if given.instrument in self._sent:
            self._sent[given.instrument] += 1

    def _send_calibration(self, calibration: Calibration, frame: Frame) -> None:
        (fx, fy), (cx, cy) = calibration.focal, calibration.centre
        width, height = calibration.image_size
        info = CameraInfo(
            header=make_header(self._factory, frame.stamp, frame.frame_id),
            width=width,
            height=height,
            distortion_model=calibration.model,
            d=self._factory.doubles(calibration.coefficients),
            k=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            p=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        )
        self._publishers[Instrument.CAMERA_INFO].publish(info)
        self._sent[Instrument.CAMERA_INFO] += 1

    def remarks(self) -> tuple[str, ...]:
        """Return remarks about messages that could not be read and were not sent."""
        return () if self._source is None else self._source.remarks()

    def close(self) -> None:
        """Read no more."""
        self._feed.close()
