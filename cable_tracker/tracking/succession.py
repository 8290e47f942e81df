"""Which frames can be tracked on, the time between two of them, and when tracking starts anew."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import REFERENCE_RATE

SMALLEST_SIDE = 16
"""Smallest height and width of a frame that can be measured [px]."""

LARGEST_LEVEL = 1e9
"""Largest grey level, of either sign: squares of sums of larger ones leave the range of float32, if
they are amplified."""

MAXIMUM_SIDE = 32_766
"""Largest height and width of a frame that OpenCV looks up pixels in [px]."""

LATE = 0.2
"""A frame that is older than the one before by no more was overtaken on the way [s]."""

SHORTEST = 1000
"""Stamps nearer to each other are in seconds or milliseconds: no camera is so fast [ns]."""

BEYOND_TIME = 2**63
"""Stamps and their differences are held in 64 bits [ns]."""


def check_levels(image: Image) -> None:
    """Refuse a frame, shape (H, W) or (H, W, 3), that is too small or whose levels are none.

    Raises
    ------
    FrameError
        It is too small, of an unknown dtype, or not finite.
    """
    height, width = image.shape[:2]
    if min(height, width) < SMALLEST_SIDE:
        raise FrameError(f"{width}x{height} px is too small; at least {SMALLEST_SIDE} px each way")
    if image.dtype not in (np.uint8, np.float32):
        raise FrameError(f"levels must be uint8 or float32, not {image.dtype}")
    if image.dtype == np.float32 and not np.isfinite(image).all():
        raise FrameError("the picture has pixels that are NaN or infinite")


def check_frame(image: object) -> None:
    """Refuse what is no grey picture.

    Raises
    ------
    FrameError
        It is no array, has not two dimensions, cannot be measured (`check_levels`), is too large,
        or has levels beyond `LARGEST_LEVEL`.
    """
    if not isinstance(image, np.ndarray):
        raise FrameError(f"a picture is a NumPy array, not a {type(image).__name__}")
    if image.ndim != 2:
        raise FrameError(f"a grey picture has shape (height, width), not {image.shape}")
    check_levels(image)
    if max(image.shape) > MAXIMUM_SIDE:
        height, width = image.shape
        raise FrameError(f"{width}x{height} px is too large; at most {MAXIMUM_SIDE} px each way")
    if image.dtype == np.float32 and float(np.abs(image).max()) > LARGEST_LEVEL:
        raise FrameError(f"grey levels must lie between -{LARGEST_LEVEL:g} and {LARGEST_LEVEL:g}")


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
    # Written so that NaN fails too: it would pass every comparison, with this frame and the next.
    if not (isinstance(now.stamp, Real) and -BEYOND_TIME <= now.stamp < BEYOND_TIME):
        raise FrameError(f"the stamp {now.stamp!r} is no time; give whole nanoseconds")
    if before is None:
        return Succession(1.0 / REFERENCE_RATE, "")
    if is_out_of_order(before.stamp, now.stamp):
        raise FrameError(_why_out_of_order(before.stamp, now.stamp))
    event = _reason_to_start_anew(before, now, maximum_gap)
    dt = 1.0 / REFERENCE_RATE if event else (now.stamp - before.stamp) / NANOSECONDS
    return Succession(dt, event, before.size == now.size)


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
    """Return the events of a frame in one line; empty ones are left out."""
    return "; ".join(filter(None, events))
