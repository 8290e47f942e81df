"""Recorded messages of instruments, handed on in step with the frames that are tracked."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy, deepcopy
from typing import Generic, Self

from cable_tracker.metric.recorded.instrument_feed import InstrumentFeed
from cable_tracker.metric.sight import AnySight
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage
from cable_tracker.sequences.frame import Frame


class RecordedInstruments(Generic[AnySight]):
    """Hands instruments of a recording to a sight; a frame may be any, see `jump`.

    Parameters
    ----------
    feed : InstrumentFeed
        Messages of the instruments.
    make_sight : callable
        Makes a sight that knows what is known before the recording begins.

    Attributes
    ----------
    sight : Sight
        Knows what the instruments have said so far.
    """

    def __init__(self, feed: InstrumentFeed, make_sight: Callable[[], AnySight]) -> None:
        self._feed, self._make_sight = feed, make_sight
        self.sight = make_sight()

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
        other._feed, other.sight = self._feed.copy(), deepcopy(self.sight)
        return other

    def advance(self, frame: Frame) -> list[InstrumentMessage]:
        """Take and return the messages of instruments up to a frame and shortly after it."""
        taken = list(self._feed.up_to(frame))
        for message in taken:
            self.sight.take_message(message.instrument, message.stamp, message.message)
        return taken

    def jump(self, *, to_start: bool = False) -> None:
        """Continue at any frame; all measurements are forgotten, the calibration stays.

        With `to_start` that is the first frame, and the calibration is read again too.
        """
        self._feed.jump(to_start=to_start)
        if to_start:
            self.sight = self._make_sight()
        else:
            self.sight.forget_all()
