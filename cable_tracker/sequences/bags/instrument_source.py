"""The messages of the instruments in a bag."""

from __future__ import annotations

from collections.abc import Container, Generator, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from cable_tracker.errors import RecordingError, one_line
from cable_tracker.sequences.bags.bag_storage import BagStorage, StoredMessage, unreadable_note
from cable_tracker.sequences.bags.instruments import (
    MOST_ALTITUDE,
    TOPICS,
    Instrument,
    InstrumentChoice,
    find_instruments,
)
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages, deserialise
from cable_tracker.sequences.bags.storage_files import is_ros1
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import (
    is_given,
    make_header,
    stamp_of,
    stamp_or_received,
)
from cable_tracker.sequences.messages.static_transforms import (
    TF_STATIC,
    StaticTransform,
    read_transform,
)


@dataclass(frozen=True, slots=True)
class InstrumentMessage:
    """One message of an instrument.

    Attributes
    ----------
    instrument : Instrument
        Which one.
    message : Message
        Message decoded by rosbags.
    stamp : int
        Stamp of the header; without a header, time of reception [ns].
    received : int
        Time of reception by the recorder [ns].
    """

    instrument: Instrument
    message: Message
    stamp: int
    received: int

    def as_ros2(self) -> Message:
        """Return the message in the type of ROS 2, with the stamp that it counts with."""
        message, factory = self.message, RosbagsMessages()
        type_name = TOPICS[self.instrument].type_name
        if not hasattr(message, "header"):
            # A number, which is an altitude.
            header = make_header(factory, self.stamp, "")
            number = float(message.data)
            return factory.make(type_name, header=header, max_range=MOST_ALTITUDE, range=number)
        if not is_given(stamp_of(message.header)):
            message.header = make_header(factory, self.stamp, str(message.header.frame_id))
        is_range = self.instrument is Instrument.ALTITUDE
        if hasattr(message, "K") or (is_range and not hasattr(message, "variance")):
            # ROS 1 names the matrices of a calibration by capitals; its ranges have no variance.
            fields = {name.lower(): value for name, value in vars(message).items()}
            return factory.make(type_name, **fields)
        return message


@dataclass(slots=True)
class _Unreadable:
    """Undecodable messages of a topic: reason for the first, and times of reception [ns].

    Times, not a count: a bag is read several times, by copies and after jumps.
    """

    reason: str
    times: set[int] = field(default_factory=set)


class InstrumentSource:
    """The instruments of one bag.

    Parameters
    ----------
    path : Path
        Path of the bag, for messages.
    storage : BagStorage
        The bag, which its owner closes.
    image_topic : str
        Whose calibration is meant.
    choice : InstrumentChoice or None
        Topics chosen by the user.

    Attributes
    ----------
    found : FoundInstruments
        Topic of each instrument, and how it was found.

    Raises
    ------
    RecordingError
        A topic that the user named is not there.
    """

    def __init__(
        self,
        path: Path,
        storage: BagStorage,
        image_topic: str,
        choice: InstrumentChoice | None = None,
    ) -> None:
        self.path = path
        self._is_ros1 = is_ros1(path)
        self._storage = storage
        try:
            self.found = find_instruments(storage.topics, image_topic, choice or InstrumentChoice())
        except RecordingError as error:
            raise RecordingError(f"{path}: {error}") from error
        self._unreadable: dict[str, _Unreadable] = {}

    def remarks(self) -> tuple[str, ...]:
        """Return remarks about unreadable messages: a sentence for each topic, by name."""
        return tuple(
            unreadable_note(topic, len(found.times), found.reason)
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
                instruments[stored.topic],
                message,
                stamp_or_received(message, stored.time),
                stored.time,
            )

    def static_messages(self) -> Iterator[tuple[int, Message]]:
        """Yield the messages of `/tf_static`, each after its time of reception [ns]."""
        if TF_STATIC in self._storage.topics:
            for stored, message in self._read([TF_STATIC]):
                yield stored.time, message

    def static_transforms(self) -> tuple[StaticTransform, ...]:
        """Read where the frames of the vehicle are; of those said twice, the last counts."""
        found: dict[str, StaticTransform] = {}
        for _, message in self.static_messages():
            for each in message.transforms:
                transform = read_transform(each)
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
