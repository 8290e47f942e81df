"""The camera's topic: its subscription, and what the middleware tells beside the frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

from rclpy.node import Node

from cable_tracker.ros import qos
from cable_tracker.ros.health.diagnostics import FrameStatistics
from cable_tracker.ros.health.watched_endpoints import WatchedEndpoints
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.frame import CompressedImage as CompressedPicture
from cable_tracker.sequences.frame import RawImage
from cable_tracker.sequences.messages.serialised_images import (
    MessageHeader,
    read_serialised_compressed_image,
    read_serialised_image,
)
from cable_tracker.stamps import NANOSECONDS

AnyImage: TypeAlias = RawImage | CompressedPicture

ImageCallback: TypeAlias = Callable[[bytes, Mapping[str, Any]], None]
"""Gets a serialised message, and what the middleware tells beside it."""

LONGEST_WAIT: Final = 60.0
"""A message that seems to have waited longer has not: the clock was set meanwhile [s]."""

LEASE: Final = 25.0
"""For so long the graph may keep the publisher of a process that was killed [s]; Fast DDS lets a
lease end after 20 s."""

_TOPICS: Final = {"raw": node_topics.IMAGE, "compressed": node_topics.COMPRESSED_IMAGE}
"""What is heard with each `image_transport`."""

ADVICE_ON_LOSS: Final = (
    "large frames need config/fastdds_loopback.xml, image_reliability:=reliable or compressed"
    " images"
)


@dataclass(frozen=True, slots=True, eq=False)
class CameraFrame:
    """A frame as the camera sent it.

    Attributes
    ----------
    stamp : int
        That of the header, worked out once: time that the camera gave [ns]; 0 where it gave none.
    header : MessageHeader
        Stamp and frame_id as the camera gave them.
    image : RawImage or CompressedPicture
        Not decoded yet.
    arrival : float
        Time of reception, on the clock of `time.perf_counter` [s].
    """

    stamp: int
    header: MessageHeader
    image: AnyImage
    arrival: float


def seconds_waited(info: Mapping[str, Any], now: int) -> float:
    """Return how long a message has lain in the middleware's queue [s]; 0 where it is not known.

    Parameters
    ----------
    info : mapping
        Message info from rclpy: `received_timestamp` and sequence number.
    now : int
        The system's time [ns].
    """
    received = info.get("received_timestamp") or 0
    waited = (now - int(received)) / NANOSECONDS
    return waited if received and 0.0 <= waited <= LONGEST_WAIT else 0.0


class GapCounter:
    """Counts frames that a publisher sent and that never reached the node.

    The middleware numbers what a publisher sends. Which publisher sent a message is not told: with
    several on the topic the numbers say nothing.
    """

    def __init__(self) -> None:
        self._last: int | None = None

    def missing(self, info: Mapping[str, Any], count_publishers: Callable[[], int]) -> int:
        """Return how many messages lie between this one and the one before.

        Parameters
        ----------
        info : mapping
            Message info from rclpy: `received_timestamp` and sequence number.
        count_publishers : callable
            Returns how many there are on the topic; called only where a number is missing.
        """
        number = info.get("publication_sequence_number")
        last, self._last = self._last, number
        if number is None or last is None:
            return 0
        # Where the numbers go back, the publisher is a new one.
        gap = max(int(number) - int(last) - 1, 0)
        return gap if gap and count_publishers() == 1 else 0


class ImageInput:
    """Subscribes to `image` or `image/compressed`, and reads the messages.

    Parameters
    ----------
    node : Node
        The node that listens.
    transport : str
        ``raw`` or ``compressed``.
    reliability : str
        ``best_effort`` or ``reliable``.
    statistics : FrameStatistics
        Counts what never came.
    """

    def __init__(
        self, node: Node, transport: str, reliability: str, statistics: FrameStatistics
    ) -> None:
        self._node = node
        self._is_compressed = transport == "compressed"
        self._heard = _TOPICS[transport]
        self._profile = qos.image_input(reliability)
        self._statistics = statistics
        self._gaps = GapCounter()
        self._subscription: Any = None
        self._cameras: list[str] = []
        self._count_of_cameras, self._counted_at = 0, 0.0

    @property
    def is_open(self) -> bool:
        """Whether it has been subscribed."""
        return self._subscription is not None

    @property
    def topic(self) -> str:
        """Full name of the topic; empty before the subscription."""
        return str(self._subscription.topic_name) if self.is_open else ""

    def subscribe(self, endpoints: WatchedEndpoints, on_image: ImageCallback) -> None:
        """Begin to listen."""
        # As bytes: a message object would cost two more copies of the pixels.
        self._subscription = endpoints.subscription(
            self._heard, on_image, self._profile, raw=True, on_lost=self._on_frames_lost,
            reliability_parameter="image_reliability",
        )  # fmt: skip

    def read(self, message: bytes, info: Mapping[str, Any]) -> CameraFrame:
        """Read a serialised message, and count those that are missing before it.

        Parameters
        ----------
        message : bytes
            Serialised message.
        info : mapping
            Message info from rclpy: `received_timestamp` and sequence number.

        Raises
        ------
        FrameError
            The bytes are no such message.
        """
        arrival = time.perf_counter() - seconds_waited(info, time.time_ns())
        self._statistics.dropped += self._gaps.missing(info, self._count_cameras)
        read = read_serialised_compressed_image if self._is_compressed else read_serialised_image
        header, image = read(message)
        return CameraFrame(header.stamp, header, image, arrival)

    def _count_cameras(self) -> int:
        return int(self._node.count_publishers(self.topic))

    def _on_frames_lost(self, event: Any) -> None:  # noqa: ANN401
        self._statistics.lost += int(event.total_count_change)
        self._node.get_logger().warning(
            f"{self._statistics.lost} frames lost on the way; {ADVICE_ON_LOSS}",
            throttle_duration_sec=5.0,
        )

    def several_cameras(self) -> str:
        """Return the names of the cameras if there is more than one, and log them when they change.

        Their frames cannot be told apart in what comes, and no tracker follows two views at once.
        """
        kind = self._heard.type_name
        heard = [each for each in self._publishers() if str(each.topic_type) == kind]
        names = sorted(map(qos.endpoint_name, heard))
        cameras = names if len(names) > 1 and self._are_alive(names) else []
        if cameras and cameras != self._cameras:
            self._node.get_logger().error(
                f"{len(cameras)} nodes publish {self.topic}: {', '.join(cameras)}; their frames are"
                " mixed. Remap `image` to the topic of one camera, or stop the others"
            )
        self._cameras = cameras
        return ", ".join(cameras)

    def _are_alive(self, names: Sequence[str]) -> bool:
        """Tell whether publishers of these names are surely several.

        One that was killed and started anew stands twice on the graph until its lease has ended.
        """
        now = time.monotonic()
        if len(names) != self._count_of_cameras:
            self._count_of_cameras, self._counted_at = len(names), now
        return len(set(names)) > 1 or now - self._counted_at > LEASE

    def _publishers(self) -> list[Any]:
        return list(self._node.get_publishers_info_by_topic(self.topic)) if self.is_open else []

    def describe_silence(self, seconds: float) -> str:
        """Return a warning that nothing usable has come for some time [s], and what may be why."""
        publishers = self._publishers()
        types = sorted({str(publisher.topic_type) for publisher in publishers})
        kinds = f" of type {', '.join(types)}" if types else ""
        statistics = self._statistics
        refused = statistics.last_bad_frame if statistics.refused_in_a_row else ""
        reason = f"; the last was refused: {refused}" if refused else ""
        return (
            f"no usable image on {self.topic} for {seconds:g} s;"
            f" {len(publishers)} publishers there{kinds}{self._advice_on_types(types)}{reason}"
        )

    def _advice_on_types(self, types: Sequence[str]) -> str:
        """Tell how to hear images of the other type, where none of those published is read."""
        transport = "raw" if self._is_compressed else "compressed"
        other, own = _TOPICS[transport], self._heard.type_name
        if own in types or other.type_name not in types:
            return ""
        return (
            f", and it is read as {own}; set image_transport to {transport} and remap"
            f" `{other.name}` to it"
        )
