"""Refusals of other libraries, in the exceptions of this package."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import cv2
import numpy as np

from cable_tracker.errors import CableTrackerError, one_line

REFUSALS = (cv2.error, np.linalg.LinAlgError)
"""What OpenCV and NumPy raise for data, or for a call that another version of theirs knew."""


@contextmanager
def refusals_as(kind: type[CableTrackerError], what: str) -> Iterator[None]:
    """Raise what OpenCV or NumPy refuses as an error of this package.

    Parameters
    ----------
    kind : type of CableTrackerError
        The exception to raise.
    what : str
        What could not be done; the words of the refusal follow it.
    """
    try:
        yield
    except REFUSALS as refusal:
        raise kind(f"{what}: {one_line(refusal)}") from refusal
