"""Recorded messages of instruments, fused in step with the frames that are tracked."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy, deepcopy
from typing import Generic, Self

from cable_tracker.metric.instrument_fusion import AnyFusion
from cable_tracker.metric.recorded.instrument_feed import InstrumentFeed
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage
from cable_tracker.sequences.frame import Frame


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
