"""Times in nanoseconds, and those of frames that have none of their own."""

NANOSECONDS = 1_000_000_000

FIRST_STAMP = NANOSECONDS
"""Time of frame 0 [ns]. Not zero, which ROS takes for "no time given"."""

USUAL_RATE = 25.0
"""Frames per second where neither the recording nor the user says [1/s]."""


def stamp_at(seconds: float) -> int:
    """Return the stamp [ns] of a time that is counted from `FIRST_STAMP` [s]."""
    return FIRST_STAMP + round(seconds * NANOSECONDS)


def stamp_of_frame(index: int, rate: float) -> int:
    """Return the time of a frame [ns] at a steady rate [1/s], counted from `FIRST_STAMP`."""
    return FIRST_STAMP + round(index * NANOSECONDS / rate)
