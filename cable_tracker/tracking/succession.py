"""How a frame follows the one before: the time between them, and whether tracking can go on."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real

from cable_tracker.errors import FrameError
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import REFERENCE_RATE

LATE = 0.2
"""A frame that is older than the one before by no more was overtaken on the way [s]."""

SHORTEST = 1000
"""Stamps nearer to each other are in seconds or milliseconds: no camera is so fast [ns]."""

BEYOND_TIME = 2**63
"""Stamps and their differences are held in 64 bits [ns]."""


@dataclass(frozen=True, slots=True)
class FrameMark:
    """What of a frame matters for the next one.

    Attributes
    ----------
    size : (int, int)
        Width and height [px].
    stamp : int
        Time [ns].
    """

    size: tuple[int, int]
    stamp: int


@dataclass(frozen=True, slots=True)
class Succession:
    """How a frame follows the one before.

    Attributes
    ----------
    dt : float
        Time since the frame before [s]; that of the reference rate where tracking starts.
    event : str
        Why tracking must start anew; empty where it goes on.
    is_same_size : bool
        Whether both frames have the same size.
    """

    dt: float
    event: str
    is_same_size: bool = True


def succession(before: FrameMark | None, now: FrameMark, maximum_gap: float) -> Succession:
    """Compare a frame with the one before it.

    Parameters
    ----------
    before : FrameMark or None
        None for the first frame.
    now : FrameMark
        The new frame.
    maximum_gap : float
        A longer pause means starting anew [s].

    Raises
    ------
    FrameError
        The new stamp is no time. Both have the same time or nearly so, as stamps in other units
        have, or the new frame is a little older: it came out of order.
    """
    _check_time(now.stamp)
    if before is None:
        return Succession(1.0 / REFERENCE_RATE, "")
    if is_out_of_order(before.stamp, now.stamp):
        raise FrameError(_why_out_of_order(before.stamp, now.stamp))
    event = _reason_to_start_anew(before, now, maximum_gap)
    dt = 1.0 / REFERENCE_RATE if event else (now.stamp - before.stamp) / NANOSECONDS
    return Succession(dt, event, before.size == now.size)


def _check_time(stamp: int) -> None:
    # Written so that NaN fails too: it would pass every comparison, with this frame and the next.
    if not (isinstance(stamp, Real) and -BEYOND_TIME <= stamp < BEYOND_TIME):
        raise FrameError(f"the stamp {stamp!r} is no time; give whole nanoseconds")


def is_out_of_order(before: int, now: int) -> bool:
    """Tell whether `succession` refuses a frame of a stamp [ns] after one of the stamp `before`."""
    return -LATE * NANOSECONDS <= now - before < SHORTEST


def _why_out_of_order(before: int, now: int) -> str:
    if now == before:
        return f"the stamp {now / NANOSECONDS:.9f} s is that of the frame before"
    if now > before:
        return (
            f"the stamp is only {now - before} ns after that of the frame before;"
            " stamps are in nanoseconds"
        )
    late = (before - now) / NANOSECONDS
    return f"the frame is {late:.3f} s older than the one before: out of order"


def _reason_to_start_anew(before: FrameMark, now: FrameMark, maximum_gap: float) -> str:
    if now.size != before.size:
        old, new = (f"{width}x{height}" for width, height in (before.size, now.size))
        return f"the image size changed from {old} to {new}"
    gap = (now.stamp - before.stamp) / NANOSECONDS
    if gap < 0:
        return f"time went back by {-gap:.3f} s"
    return f"no frame for {gap:.3f} s" if gap > maximum_gap else ""


def joined_events(*events: str) -> str:
    """Return what there is to say of a frame, one after the other; what is empty is left out."""
    return "; ".join(filter(None, events))
