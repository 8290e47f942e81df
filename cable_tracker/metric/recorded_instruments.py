"""The instruments of a recording: their fusion in step with frames, metres, and aid for the filter.

The same as the tracker node does with what it hears, except that a recording knows the future: what
instruments said shortly after a frame is known when the frame is tracked, so that their
measurements are interpolated instead of held.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from copy import copy, deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Self

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.metric.cable_instrument_fusion import CABLE_INSTRUMENTS, CableInstrumentFusion
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.instrument_fusion import AnyFusion
from cable_tracker.metric.vehicle_description import (
    VehicleDescription,
    VehicleFile,
    describe_vehicle,
    read_vehicle_file,
)
from cable_tracker.metric.withheld import Withheld
from cable_tracker.sequences.bags.bag import BagSource
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage, InstrumentSource
from cable_tracker.sequences.bags.instruments import (
    Instrument,
    InstrumentChoice,
    refuse_named_topics,
)
from cable_tracker.sequences.bags.storage_files import METADATA, VEHICLE_FILE
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.source_base import Source

LOOK_AHEAD = 250_000_000
"""Time after a frame up to which messages are known when it is tracked [ns]. Those of the fastest
instruments are kept for much longer."""

LOOK_BACK = 2_000_000_000
"""Time before a frame from which messages are read after a jump in the recording [ns]: nothing
older counts."""


class InstrumentFeed:
    """Hands out the messages of a bag's instruments in step with its frames.

    Parameters
    ----------
    source : InstrumentSource or None
        Source of the messages; None: there are none.
    pauses : mapping of Instrument to int
        Shortest interval between used messages of an instrument [ns].
    """

    def __init__(
        self, source: InstrumentSource | None, pauses: Mapping[Instrument, int] | None = None
    ) -> None:
        self._source = source
        self._pauses = pauses
        self._messages: Generator[InstrumentMessage] | None = None
        self._next: InstrumentMessage | None = None
        self._begin = 0
        self._jumps = False

    def copy(self) -> InstrumentFeed:
        """Return a copy that continues from here; it reads on when it is first asked.

        With pauses it may pass over other messages than this one.
        """
        other = InstrumentFeed(self._source, self._pauses)
        other._begin, other._jumps = self._begin, self._jumps
        return other

    def jump(self, *, to_start: bool = False) -> None:
        """Continue at any frame, from the messages received shortly before it.

        With `to_start`, with all that was received before it.
        """
        self.close()
        self._messages, self._begin, self._jumps = None, 0, not to_start

    def up_to(self, frame: Frame) -> Iterator[InstrumentMessage]:
        """Yield what was received up to a frame and shortly after, and was not handed out before.

        Nothing for a frame of which it is not known when it was received.
        """
        if frame.received is None:
            return
        if self._jumps:
            self._begin, self._jumps = max(0, frame.received - LOOK_BACK), False
        if self._messages is None:
            source = self._source
            messages = source.messages(self._pauses, self._begin) if source else _no_messages()
            self._messages, self._next = messages, next(messages, None)
        last = frame.received + LOOK_AHEAD
        self._begin = max(self._begin, last + 1)
        while self._next is not None and self._next.received <= last:
            message = self._next
            self._next = next(self._messages, None)
            yield message

    def close(self) -> None:
        """Read no more."""
        self._next = None
        if self._messages is None:
            self._messages = _no_messages()
        self._messages.close()


def _no_messages() -> Generator[InstrumentMessage]:
    yield from ()


class RecordedInstruments(Generic[AnyFusion]):
    """Feeds the instruments of a recording to their fusion; a frame may be any, see `jump`.

    Parameters
    ----------
    feed : InstrumentFeed
        Messages of the instruments.
    make_fusion : callable
        Makes the fusion as it is before the recording begins.

    Attributes
    ----------
    fusion : InstrumentFusion
        Fusion of the messages so far.
    """

    def __init__(self, feed: InstrumentFeed, make_fusion: Callable[[], AnyFusion]) -> None:
        self._feed, self._make_fusion = feed, make_fusion
        self.fusion = make_fusion()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def close(self) -> None:
        """Read no more of the recording."""
        self._feed.close()

    def copy(self) -> Self:
        """Return a copy that continues as this one would."""
        other = copy(self)
        other._feed, other.fusion = self._feed.copy(), deepcopy(self.fusion)
        return other

    def advance(self, frame: Frame) -> list[InstrumentMessage]:
        """Take and return the messages of instruments up to a frame and shortly after it."""
        taken = list(self._feed.up_to(frame))
        for message in taken:
            self.fusion.take_message(message.instrument, message.stamp, message.message)
        return taken

    def jump(self, *, to_start: bool = False) -> None:
        """Continue at any frame; all measurements are forgotten, the calibration stays.

        With `to_start` that is the first frame, and the calibration is read again too.
        """
        self._feed.jump(to_start=to_start)
        if to_start:
            self.fusion = self._make_fusion()
        else:
            self.fusion.forget_all()


@dataclass(frozen=True, slots=True)
class Pauses:
    """Intervals between measurements that are used; 0 by default, which uses all.

    Attributes
    ----------
    readings : int
        Interval between two readings of imu, odometry and altimeter [ns].
    calibration : int
        Interval between two calibrations [ns].
    texture : float
        Least time between two comparisons of texture, see `MotionAiding` [s].
    """

    readings: int = 0
    calibration: int = 0
    texture: float = 0.0

    def of_instruments(self) -> dict[Instrument, int]:
        """Return the pauses of instruments; those that are not in it are read whole [ns]."""
        fast = (Instrument.IMU, Instrument.ODOMETRY, Instrument.ALTITUDE)
        return {**dict.fromkeys(fast, self.readings), Instrument.CAMERA_INFO: self.calibration}


class RecordedCableInstruments(RecordedInstruments[CableInstrumentFusion]):
    """Turns the estimates of a recording into metres, and its odometry into aid for the filter.

    Parameters
    ----------
    vehicle : VehicleDescription
        Mounting, doubts, and a calibration if the bag has none.
    source : InstrumentSource or None
        Instruments of the bag; None where there are none.
    pauses : Pauses
        Shortest intervals between used messages of each instrument.
    """

    def __init__(
        self,
        vehicle: VehicleDescription,
        source: InstrumentSource | None,
        pauses: Pauses = Pauses(),
    ) -> None:
        self._measured = self._stood_in = 0
        self._stand_in = ""
        super().__init__(
            InstrumentFeed(source, pauses.of_instruments()),
            lambda: CableInstrumentFusion(vehicle.parameters, vehicle.calibration, pauses.texture),
        )
        self._aids = vehicle.parameters.motion_aid and (
            source is not None and Instrument.ODOMETRY in source.found.topics
        )

    @property
    def is_aided(self) -> bool:
        """Whether there is odometry for the filter."""
        return self._aids

    def motion(self, stamp: int, image: Image) -> MotionAid | None:
        """Return how the cable has moved since the frame before; `image` (H, W), `stamp` [ns].

        None without odometry, or while it disagrees with what the camera sees.
        """
        return self.fusion.motion(stamp, image) if self._aids else None

    def measure(self, estimate: CableEstimate) -> CrossTrack | Withheld:
        """Return the cable of an estimate in metres, or why not."""
        self._measured += 1
        stand_in = self.fusion.stand_in_at(estimate.stamp)
        if stand_in:
            self._stood_in += 1
            self._stand_in = self._stand_in or stand_in
        return self.fusion.measure(estimate)

    def remarks(self) -> tuple[str, ...]:
        """Return a remark where `fixed_altitude` stood in, to be asked for after tracking."""
        if not self._stood_in:
            return ()
        counted = f"in {self._stood_in} of {self._measured} frames"
        return (f"{counted} {self._stand_in}; metres may jump there",)


@dataclass(frozen=True, slots=True)
class RecordedVehicle:
    """The vehicle of a recording, and its instruments.

    Attributes
    ----------
    vehicle : VehicleDescription
        Description by tf_static and the vehicle file.
    source : InstrumentSource or None
        Instruments of the bag; None for a recording that is no bag.
    """

    vehicle: VehicleDescription
    source: InstrumentSource | None

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for the user before anything is tracked."""
        return (*self._found_notes, *self.vehicle.notes)

    @property
    def notes_on_recording(self) -> tuple[str, ...]:
        """Those of `notes` that say something of the recording itself."""
        return (*self._found_notes, *self.vehicle.notes_on_frames)

    @property
    def _found_notes(self) -> tuple[str, ...]:
        return () if self.source is None else self.source.found.notes

    def remarks(self) -> tuple[str, ...]:
        """Return remarks about unreadable messages, to be asked for after tracking."""
        return () if self.source is None else self.source.remarks()

    @property
    def has_instruments(self) -> bool:
        """Whether there is anything that metres could be made of."""
        topics = {} if self.source is None else self.source.found.topics
        found = any(instrument in topics for instrument in CABLE_INSTRUMENTS)
        return found or self.vehicle.calibration is not None

    @property
    def wants_metres(self) -> bool:
        """Whether there are instruments, or a vehicle file from which metres are expected."""
        return self.has_instruments or bool(self.vehicle.said)

    def instruments(self, pauses: Pauses = Pauses()) -> RecordedCableInstruments | None:
        """Return the instruments from the start on; None where no metres are wanted."""
        return (
            RecordedCableInstruments(self.vehicle, self.source, pauses)
            if self.wants_metres
            else None
        )


def own_vehicle_file(path: Path) -> Path:
    """Return where the `vehicle.yaml` of a recording lies, if it has one."""
    # A storage file may be named instead of its bag's folder.
    is_in_bag = path.is_file() and (path.parent / METADATA).is_file()
    return (path.parent if is_in_bag else path) / VEHICLE_FILE


def recorded_vehicle(
    recording: Source, choice: InstrumentChoice | None = None, vehicle_file: Path | None = None
) -> RecordedVehicle:
    """Find out what a recording holds besides its pictures.

    Parameters
    ----------
    recording : Source
        An open recording.
    choice : InstrumentChoice or None
        Which topics the user wants.
    vehicle_file : Path or None
        The user's `vehicle.yaml`; None: the one in the bag's folder, if there is one.

    Raises
    ------
    RecordingError
        The bag cannot be read, or a topic that the user named is not there, as in what is no bag.
    ParameterError
        The vehicle file is not acceptable.
    """
    if not isinstance(recording, BagSource):
        refuse_named_topics(recording.path, choice)
    file = VehicleFile()
    own = own_vehicle_file(recording.path)
    if vehicle_file is not None or own.is_file():
        file = read_vehicle_file(vehicle_file or own)
    if not isinstance(recording, BagSource):
        return RecordedVehicle(describe_vehicle(None, "", file), None)
    source = InstrumentSource(recording.path, recording.storage, recording.topic, choice)
    vehicle = describe_vehicle(source, recording.camera_frame, file)
    return RecordedVehicle(vehicle, source)
