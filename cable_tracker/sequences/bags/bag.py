"""Frames of ROS 2 and ROS 1 bags, with the ground truth that was recorded beside them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, field
from pathlib import Path

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError, RecordingError, one_line
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_storage import (
    COMPRESSED_IMAGE,
    IMAGE_TYPES,
    VIDEO_TYPES,
    BagStorage,
    StoredMessage,
    Topic,
    image_topics,
    named_topics,
    unreadable_note,
)
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import beginning, deserialise
from cable_tracker.sequences.bags.storage_files import is_ros1
from cable_tracker.sequences.bags.video_stream import (
    DecodedPicture,
    Packet,
    StreamDecoder,
    read_packet,
)
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import DEFAULT_FRAME_ID, Frame, missing_image
from cable_tracker.sequences.messages.cable import read_state
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import is_given, stamp_or_received
from cable_tracker.sequences.messages.images import read_compressed_image, read_image
from cable_tracker.sequences.messages.serialised_images import MessageHeader, read_header
from cable_tracker.sequences.source_base import ChosenRecording, Source, damage

_JOINT_STATE = node_topics.GROUND_TRUTH.type_name
_TRUTH = node_topics.GROUND_TRUTH.name
_HEADER_ROOM = 4096
"""Beginning of a message in which its header must end [bytes]."""


def _listing(topics: dict[str, Topic]) -> str:
    return ", ".join(
        f"{name} ({topic.msgtype}, {topic.count})" for name, topic in sorted(topics.items())
    )


def _reason(error: Exception) -> str:
    """Say why a message gives no picture; its parser does not know what has met it."""
    return str(error) if isinstance(error, FrameError) else f"damaged message: {one_line(error)}"


def _choose_topic(path: Path, topics: dict[str, Topic], wanted: str | None) -> str:
    """Return the image topic to read, or say what the user can choose from."""
    if not topics:
        raise RecordingError(f"{path}: the bag holds no topics at all; record it again")
    images = image_topics(topics)
    if wanted is not None:
        matching = named_topics(images, wanted)
        if matching:
            return matching[0]
        raise RecordingError(
            f"{path}: there is no image topic {wanted}; the bag holds {_listing(topics)}"
        )
    if not images:
        raise RecordingError(
            f"{path}: the bag holds no images (Image, CompressedImage, CompressedVideo or"
            " FFMPEGPacket), only"
            f" {_listing(topics)}"
        )
    recorded = {name: topic for name, topic in images.items() if topic.count} or images
    if len(recorded) > 1:
        raise RecordingError(
            f"{path}: several image topics, choose one with --topic (node: topic):"
            f" {_listing(recorded)}"
        )
    return next(iter(recorded))


def _truth_topic(topics: dict[str, Topic], image_topic: str) -> str | None:
    """Return the topic of the ground truth, preferably one in the namespace of the images."""
    namespace = image_topic.strip("/").partition("/")[0]
    candidates = sorted(
        (name.strip("/").partition("/")[0] != namespace, name)
        for name, topic in topics.items()
        if topic.msgtype == _JOINT_STATE and name.rpartition("/")[2] == _TRUTH and topic.count
    )
    return candidates[0][1] if candidates else None


@dataclass(frozen=True, slots=True)
class _StoredPicture:
    """A message with an image or a packet of video, and what its header says.

    Attributes
    ----------
    message : StoredMessage
        The message.
    stamp : int
        Stamp of the header [ns]. Where it says none or cannot be read: as long after the picture
        before it as it was received after that one.
    frame_id : str
        Coordinate frame of the camera.
    """

    message: StoredMessage
    stamp: int
    frame_id: str


@dataclass(slots=True)
class _RecordedTruth:
    """Ground truth on a topic of a bag, as far as it can be read.

    Attributes
    ----------
    topic : str
        Name of the topic.
    states : dict of int to CableState
        By stamp [ns].
    unreadable : int
        Number of messages that cannot be decoded.
    reason : str
        Reason for the first of them.
    is_whole : bool
        Whether it could be read to its end.
    """

    topic: str
    states: dict[int, CableState] = field(default_factory=dict)
    unreadable: int = 0
    reason: str = ""
    is_whole: bool = True

    def notes(self) -> list[str]:
        """Return notes for the user about the ground truth."""
        notes = []
        if self.unreadable:
            notes.append(unreadable_note(self.topic, self.unreadable, self.reason))
        if not self.is_whole:
            notes.append(f"the ground truth on {self.topic} is damaged: {len(self.states)} read")
        return notes


def _read_truth(path: Path, storage: BagStorage, topic: str) -> _RecordedTruth:
    truth = _RecordedTruth(topic)
    try:
        with closing(storage.messages([topic])) as messages:
            for message in messages:
                _add_truth(truth, message, is_ros1(path))
    except RecordingError:
        truth.is_whole = False
    return truth


def _add_truth(truth: _RecordedTruth, message: StoredMessage, from_ros1: bool) -> None:
    try:
        joints = deserialise(message, is_ros1=from_ros1)
        state, stamp = read_state(joints), stamp_or_received(joints, message.time)
    # Deserialising foreign bytes raises what the parser happens to raise.
    except Exception as error:  # noqa: BLE001
        truth.unreadable += 1
        truth.reason = truth.reason or one_line(error)
        return
    if state is not None and state.is_finite():
        truth.states[stamp] = state


def read_bag_truth(path: Path) -> dict[int, CableState]:
    """Read the ground truth of a bag by stamp [ns], whether it holds images or not.

    Raises
    ------
    RecordingError
        The bag or a label in it cannot be read, or it holds no ground truth.
    """
    with closing(open_bag(path)) as storage:
        topic = _truth_topic(storage.topics, "")
        if topic is None:
            raise RecordingError(
                f"{path}: the bag holds no {_TRUTH} ({_JOINT_STATE}) to take labels from, only"
                f" {_listing(storage.topics)}"
            )
        truth = _read_truth(path, storage, topic)
    if truth.unreadable:
        raise RecordingError(
            f"{path}: the ground truth on {topic} cannot be read ({truth.reason}); record it again"
        )
    if not truth.is_whole:
        raise RecordingError(
            f"{path}: {topic} is damaged after {len(truth.states)} labels; copy it again"
        )
    return truth.states


class BagSource(Source):
    """Images of one topic of a bag.

    Attributes
    ----------
    topic : str
        The image topic.
    storage : BagStorage
        The bag, opened, to read what else it holds.

    Raises
    ------
    RecordingError
        Nothing can be read, or the topic is missing or not unique.
    """

    def __init__(self, chosen: ChosenRecording) -> None:
        super().__init__(chosen)
        path = chosen.path
        self._is_ros1 = is_ros1(path)
        self.storage = open_bag(path)
        self.topic = _choose_topic(path, self.storage.topics, chosen.topic)
        stored = self.storage.topics[self.topic]
        self.frame_count = stored.count
        self._type = stored.msgtype
        self.compressed = stored.msgtype == COMPRESSED_IMAGE
        self._is_video = stored.msgtype in VIDEO_TYPES
        if self._is_video:
            # Packets before the first key frame are no frames.
            self.frame_count = None
        if not stored.count:
            raise RecordingError(f"{path}: topic {self.topic} holds no images; record it again")
        if self.storage.note:
            self.note = f"{self.storage.note} ({stored.count} frames)"
        self._truth = self._find_truth() if chosen.with_truth else {}
        self.has_truth = bool(self._truth)

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        self.storage.close()

    @property
    def camera_frame(self) -> str:
        """`frame_id` of the first image; `DEFAULT_FRAME_ID` if it names none."""
        with closing(self._read(0)) as items:
            first = next((item for item in items if not item.image.missing), None)
        return first.frame_id if first is not None else DEFAULT_FRAME_ID

    def _header(self, message: StoredMessage) -> MessageHeader | None:
        """Read the header without unpacking the picture; also a CompressedVideo begins like one."""
        return read_header(beginning(message.data, _HEADER_ROOM), is_ros1=self._is_ros1)

    def _stored_pictures(self) -> Generator[_StoredPicture]:
        ahead: int | None = None
        with closing(self.storage.messages([self.topic])) as messages:
            for message in messages:
                header = self._header(message)
                if header is not None and is_given(header.stamp):
                    ahead = header.stamp - message.time
                elif ahead is None:
                    ahead = self._first_ahead()
                frame_id = header.frame_id if header is not None else ""
                yield _StoredPicture(message, message.time + ahead, frame_id or DEFAULT_FRAME_ID)

    def _first_ahead(self) -> int:
        """Return the first stamp minus its time of reception [ns]; 0 if there is none.

        The clocks of the camera and the recorder may differ by years.
        """
        # Reading the frames will meet the damage, and says so.
        with suppress(RecordingError), closing(self.storage.messages([self.topic])) as messages:
            for message in messages:
                if (header := self._header(message)) is not None and is_given(header.stamp):
                    return header.stamp - message.time
        return 0

    def _deserialise(self, message: StoredMessage) -> Message:
        self._check_type(message.msgtype)
        return deserialise(message, is_ros1=self._is_ros1)

    def _check_type(self, msgtype: str) -> None:
        """Refuse pictures of another type, which something else has sent under the same name."""
        if msgtype != self._type and msgtype in IMAGE_TYPES:
            other, own = (name.rpartition("/")[2] for name in (msgtype, self._type))
            raise FrameError(
                f"it is a {other}, and {self.topic} is read as {own}: two publishers have sent"
                " different types under that name; record each under a name of its own"
            )

    def _find_truth(self) -> dict[int, CableState]:
        """Read the ground truth by stamp; what is damaged is said when the frames are read."""
        topic = _truth_topic(self.storage.topics, self.topic)
        if topic is None:
            return {}
        truth = _read_truth(self.path, self.storage, topic)
        self.note = "; ".join(note for note in (self.note, *truth.notes()) if note)
        return truth.states

    def _read(self, start: int) -> Generator[Frame]:
        if self._is_video:
            yield from self._read_video(start)
        else:
            yield from self._read_pictures(lambda count, _: count >= start)

    def _read_chosen(self, wanted: Callable[[int], bool]) -> Generator[Frame]:
        if self._is_video:
            yield from super()._read_chosen(wanted)
        else:
            yield from self._read_pictures(lambda _, stamp: wanted(stamp))

    def _read_pictures(self, wanted: Callable[[int, int], bool]) -> Generator[Frame]:
        """Yield the frames of which the number and the stamp [ns] are wanted."""
        count = 0
        try:
            with closing(self._stored_pictures()) as pictures:
                for picture in pictures:
                    if wanted(count, picture.stamp):
                        yield self._frame(count, picture)
                    count += 1
        except RecordingError as error:
            raise damage(self.path, count, str(error)) from error
        if self.frame_count is not None and count < self.frame_count:
            raise RecordingError(
                f"{self.path}: damaged: {self.frame_count - count} of the {self.frame_count} frames"
                " that its index promises are missing; all others have been read; get an undamaged"
                " copy of the recording"
            )

    def _read_video(self, start: int) -> Generator[Frame]:
        """Decode from the beginning; what comes before the first key frame is no frame."""
        count, has_begun, first = 0, False, 0
        try:
            for picture in self._pictures():
                if not has_begun and picture.picture is not None:
                    has_begun, first = True, picture.packet.stamp
                # Also what is coded after it and shown before it, from frames that are not there.
                if not has_begun or (picture.picture is None and picture.packet.stamp < first):
                    continue
                if count >= start:
                    yield self._video_frame(count, picture)
                count += 1
        except RecordingError as error:
            raise damage(self.path, count, str(error)) from error
        if not has_begun:
            raise RecordingError(
                f"{self.path}: not one picture of {self.topic} can be decoded; it holds no key"
                " frame, or its coding is not known"
            )

    def _pictures(self) -> Iterator[DecodedPicture]:
        decoder = StreamDecoder()
        with closing(self._stored_pictures()) as pictures:
            for stored in pictures:
                received = stored.message.time
                try:
                    packet = read_packet(self._deserialise(stored.message), received)
                # Deserialising foreign bytes raises what the parser happens to raise.
                except Exception as error:  # noqa: BLE001
                    nothing = Packet(stored.stamp, stored.frame_id, "", b"", received)
                    yield DecodedPicture(nothing, None, _reason(error))
                    continue
                yield from decoder.take(packet)
        yield from decoder.end()

    def _video_frame(self, index: int, decoded: DecodedPicture) -> Frame:
        packet = decoded.packet
        image = (
            raw_from_array(decoded.picture, "bgr8")
            if decoded.picture is not None
            else missing_image(decoded.reason)
        )
        truth = self._truth.get(packet.stamp)
        return Frame(index, packet.stamp, image, packet.frame_id, truth, packet.received)

    def _frame(self, index: int, picture: _StoredPicture) -> Frame:
        message, stamp, frame_id = picture.message, picture.stamp, picture.frame_id
        try:
            content = self._deserialise(message)
            image = read_compressed_image(content) if self.compressed else read_image(content)
            stamp = stamp_or_received(content, picture.stamp)
            frame_id = content.header.frame_id or DEFAULT_FRAME_ID
        # Deserialising foreign bytes raises what the parser happens to raise.
        except Exception as error:  # noqa: BLE001
            image = missing_image(_reason(error), compressed=self.compressed)
        return Frame(index, stamp, image, frame_id, self._truth.get(stamp), message.time)
