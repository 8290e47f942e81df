"""Recorded messages of instruments, in step with the frames that are tracked, and their fusion."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from copy import copy, deepcopy
from typing import Generic, Self

from cable_tracker.metric.instrument_fusion import AnyFusion
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage, InstrumentSource
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.frame import Frame

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
