"""What else a bag holds besides pictures: calibration, altitude, attitude, odometry, fixes.

Topics are found by their types. Where several have the right one, the user chooses; without a
choice nothing is guessed, and a note says so.
"""

from __future__ import annotations

from collections.abc import Container, Generator, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Protocol

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import RecordingError, one_line
from cable_tracker.sequences.bag_storage import BagStorage, Topic, is_ros1, open_storage
from cable_tracker.sequences.messages import Message
from cable_tracker.sequences.stored_message import StoredMessage
from cable_tracker.sequences.unpacking import deserialise
from cable_tracker.stamps import NANOSECONDS

NO_TOPIC = "none"
"""A choice that leaves an instrument out."""

TRUTH_NAMESPACE = "ground_truth"
"""Topics inside say how it was, not what an instrument said."""

TF_STATIC = "/tf_static"
TF_TYPE = "tf2_msgs/msg/TFMessage"


class Instrument(str, Enum):
    """What can be read besides pictures."""

    CAMERA_INFO = "camera_info"
    ALTITUDE = "altitude"
    IMU = "imu"
    ODOMETRY = "odometry"
    FIX = "fix"


FOUND_TYPES: Mapping[Instrument, tuple[str, ...]] = {
    Instrument.CAMERA_INFO: ("sensor_msgs/msg/CameraInfo",),
    Instrument.ALTITUDE: ("sensor_msgs/msg/Range",),
    Instrument.IMU: ("sensor_msgs/msg/Imu",),
    Instrument.ODOMETRY: ("nav_msgs/msg/Odometry",),
    Instrument.FIX: ("sensor_msgs/msg/NavSatFix",),
}
"""Types that are taken without being asked for."""

NUMBER_TYPES = ("std_msgs/msg/Float32", "std_msgs/msg/Float64")
"""An altitude may be one of these as well, where its topic is named: a number says not of what."""


@dataclass(frozen=True, slots=True)
class InstrumentMessage:
    """One message of an instrument.

    Attributes
    ----------
    instrument : Instrument
        Which one.
    message : Message
        As rosbags reads it.
    stamp : int
        Of its header; the time it was received where there is none [ns].
    received : int
        When it was written into the bag [ns].
    """

    instrument: Instrument
    message: Message
    stamp: int
    received: int


@dataclass(frozen=True, slots=True, eq=False)
class StaticTransform:
    """Where a frame is in its parent.

    Attributes
    ----------
    parent, child : str
        Names without a leading slash.
    rotation : FloatArray
        From the child to the parent, shape (3, 3).
    translation : FloatArray
        Of the child's origin in the parent, shape (3,) [m].
    """

    parent: str
    child: str
    rotation: FloatArray
    translation: FloatArray


@dataclass(frozen=True, slots=True)
class InstrumentChoice:
    """Which topics to read, by instrument; `NO_TOPIC` leaves one out.

    Attributes
    ----------
    topics : mapping of Instrument to str
        What is not in it is found by its type.
    """

    topics: Mapping[Instrument, str] = field(default_factory=dict)


class _Listed(Protocol):
    topics: dict[str, Topic]


@dataclass(frozen=True, slots=True)
class FoundInstruments:
    """The topics that are read, and what the user should know about the others.

    Attributes
    ----------
    topics : dict of Instrument to str
        As the bag calls them.
    notes : tuple of str
        One sentence for each instrument that could not be chosen.
    """

    topics: dict[Instrument, str]
    notes: tuple[str, ...]


def find_instruments(
    storage: _Listed, image_topic: str, choice: InstrumentChoice
) -> FoundInstruments:
    """Find the topics of all instruments.

    Of several calibrations that beside the images counts.

    Raises
    ------
    RecordingError
        A topic that the user named is not there, or of no type that can be read.
    """
    topics: dict[Instrument, str] = {}
    notes = []
    for instrument in Instrument:
        wanted = choice.topics.get(instrument)
        if wanted == NO_TOPIC:
            continue
        if wanted is not None:
            topics[instrument] = _named(storage, instrument, wanted)
            continue
        candidates = _candidates(storage, instrument)
        if instrument is Instrument.CAMERA_INFO:
            candidates = _beside(candidates, image_topic) or candidates
        if len(candidates) == 1:
            topics[instrument] = candidates[0]
        elif candidates:
            option = instrument.value.replace("_", "-")
            notes.append(
                f"several topics for {instrument.value}, none of them is read; choose one with"
                f" --{option}-topic: {', '.join(candidates)}"
            )
    return FoundInstruments(topics, tuple(notes))


def _candidates(storage: _Listed, instrument: Instrument) -> list[str]:
    return sorted(
        name
        for name, topic in storage.topics.items()
        if topic.msgtype in FOUND_TYPES[instrument]
        and topic.count
        and TRUTH_NAMESPACE not in name.split("/")
    )


def _beside(candidates: list[str], image_topic: str) -> list[str]:
    """Return the calibrations in the namespace of the images, or one level above it."""
    place = image_topic.strip("/").split("/")[:-1]
    for depth in (len(place), len(place) - 1):
        if depth < 0:
            break
        near = [name for name in candidates if name.strip("/").split("/")[:-1] == place[:depth]]
        if near:
            return near
    return []


def _named(storage: _Listed, instrument: Instrument, wanted: str) -> str:
    matching = [name for name in storage.topics if name.strip("/") == wanted.strip("/")]
    if not matching:
        known = ", ".join(sorted(storage.topics))
        raise RecordingError(
            f"there is no topic {wanted} for {instrument.value}; choose one of {known}"
        )
    name = matching[0]
    types = FOUND_TYPES[instrument]
    if instrument is Instrument.ALTITUDE:
        types = (*types, *NUMBER_TYPES)
    if storage.topics[name].msgtype not in types:
        raise RecordingError(
            f"the topic {wanted} for {instrument.value} is of type {storage.topics[name].msgtype};"
            f" name one of type {' or '.join(types)}"
        )
    return name


@dataclass(slots=True)
class _Unreadable:
    """What cannot be read of a topic: why the first message, and when each was received [ns].

    Times, not a count: a bag is read several times, by copies and after jumps.
    """

    reason: str
    times: set[int] = field(default_factory=set)


class InstrumentSource:
    """The instruments of one bag.

    Parameters
    ----------
    path : Path
        The bag.
    image_topic : str
        Whose calibration is meant.
    choice : InstrumentChoice
        What the user wants.
    storage : BagStorage or None
        The bag, if it is open already.

    Attributes
    ----------
    found : FoundInstruments
        What is read.

    Raises
    ------
    RecordingError
        The bag cannot be read, or a topic that the user named is not there.
    """

    def __init__(
        self,
        path: Path,
        image_topic: str,
        choice: InstrumentChoice | None = None,
        storage: BagStorage | None = None,
    ) -> None:
        self.path = path
        self._is_ros1 = is_ros1(path)
        self._storage = storage or open_storage(path)
        try:
            self.found = find_instruments(self._storage, image_topic, choice or InstrumentChoice())
        except RecordingError as error:
            raise RecordingError(f"{path}: {error}") from error
        self._unreadable: dict[str, _Unreadable] = {}

    def remarks(self) -> tuple[str, ...]:
        """Say which messages could not be read so far: a sentence for each topic, by name."""
        return tuple(
            f"{topic}: {len(found.times)} of its messages cannot be read and are left out (the"
            f" first: {found.reason}); check how the bag was recorded"
            for topic, found in sorted(self._unreadable.items())
        )

    def leave_out(self, instrument: Instrument) -> None:
        """Do not read an instrument after all."""
        self.found.topics.pop(instrument, None)

    def messages(
        self,
        pauses: Mapping[Instrument, int] | None = None,
        start: int = 0,
        *,
        only: Container[Instrument] = tuple(Instrument),
    ) -> Generator[InstrumentMessage]:
        """Yield the messages of the chosen topics of some instruments, in the order of the bag.

        What was received before `start` [ns] is left out, and so is what was received sooner after
        another message of its instrument than `pauses` says [ns]. A message that cannot be read is
        left out too, see `remarks`. Where the bag is damaged the messages end, without an error:
        the source of the frames reports the damage.
        """
        instruments = {topic: each for each, topic in self.found.topics.items() if each in only}
        own = {topic: (pauses or {}).get(each, 0) for topic, each in instruments.items()}
        for stored, message in self._read(list(instruments), own, start):
            yield InstrumentMessage(
                instruments[stored.topic], message, _stamp_of(message, stored.time), stored.time
            )

    def static_messages(self) -> Iterator[Message]:
        """Yield the messages of `/tf_static`."""
        if TF_STATIC in self._storage.topics:
            for _, message in self._read([TF_STATIC]):
                yield message

    def static_transforms(self) -> tuple[StaticTransform, ...]:
        """Read where the frames of the vehicle are; of those said twice, the last counts."""
        found: dict[str, StaticTransform] = {}
        for message in self.static_messages():
            for each in message.transforms:
                transform = _transform(each)
                if transform is not None:
                    found[transform.child] = transform
        return tuple(found.values())

    def first(self, instrument: Instrument) -> Message | None:
        """Read the first message of an instrument; None if there is none."""
        topic = self.found.topics.get(instrument)
        if topic is None:
            return None
        with closing(self._read([topic])) as messages:
            found = next(messages, None)
        return None if found is None else found[1]

    def _read(
        self, topics: list[str], pauses: Mapping[str, int] | None = None, start: int = 0
    ) -> Generator[tuple[StoredMessage, Message]]:
        pauses, last = pauses or {}, dict[str, int]()
        with closing(self._storage.messages(topics, start)) as messages:
            iterator: Iterator[StoredMessage] = iter(messages)
            while True:
                try:
                    stored = next(iterator, None)
                except RecordingError:
                    return
                if stored is None:
                    return
                before = last.get(stored.topic)
                # Unpacking takes longer than all else.
                if before is not None and 0 <= stored.time - before < pauses.get(stored.topic, 0):
                    continue
                last[stored.topic] = stored.time
                try:
                    message = deserialise(stored, is_ros1=self._is_ros1)
                # Deserialising foreign bytes raises what the parser happens to raise.
                except Exception as error:  # noqa: BLE001
                    self._note_unreadable(stored, error)
                    continue
                yield stored, message

    def _note_unreadable(self, stored: StoredMessage, error: Exception) -> None:
        found = self._unreadable.setdefault(stored.topic, _Unreadable(one_line(error)))
        found.times.add(stored.time)


def _stamp_of(message: Message, received: int) -> int:
    header = getattr(message, "header", None)
    if header is None:
        return received
    stamp = int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)
    return stamp or received


def _transform(message: Message) -> StaticTransform | None:
    q, t = message.transform.rotation, message.transform.translation
    x, y, z, w = (float(value) for value in (q.x, q.y, q.z, q.w))
    norm = float(np.linalg.norm((x, y, z, w)))
    place = np.array([float(t.x), float(t.y), float(t.z)])
    if not abs(norm - 1.0) <= 0.1 or not np.isfinite(place).all():
        return None
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    parent = str(message.header.frame_id).strip("/")
    return StaticTransform(parent, str(message.child_frame_id).strip("/"), rotation, place)


def place_in(
    transforms: tuple[StaticTransform, ...], frame: str, base: str
) -> tuple[FloatArray, FloatArray] | None:
    """Return rotation (3, 3) and origin (3,) [m] of a frame in another; None: not connected.

    Transforms are followed from the frame up to the base, and from the base up where it hangs
    below.
    """
    up = _chain(transforms, frame.strip("/"))
    down = _chain(transforms, base.strip("/"))
    for name, (rotation, place) in up.items():
        if name in down:
            base_rotation, base_place = down[name]
            return base_rotation.T @ rotation, base_rotation.T @ (place - base_place)
    return None


def _chain(
    transforms: tuple[StaticTransform, ...], frame: str
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return the place of a frame in itself and in each of its ancestors."""
    by_child = {each.child: each for each in transforms}
    rotation, place = np.eye(3), np.zeros(3)
    chain = {frame: (rotation, place)}
    while frame in by_child:
        step = by_child[frame]
        frame = step.parent
        if frame in chain:
            break
        rotation, place = step.rotation @ rotation, step.rotation @ place + step.translation
        chain[frame] = (rotation, place)
    return chain
