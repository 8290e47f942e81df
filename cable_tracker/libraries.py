"""Other libraries: their refusals in the exceptions of this package, and how they compute."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import cv2
import numpy as np
from threadpoolctl import threadpool_limits

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


@contextmanager
def one_thread() -> Iterator[None]:
    """Let OpenCV and NumPy's linear algebra use one thread, as all else does.

    What is measured must not depend on the number of processors. OpenBLAS' threads, moreover, go on
    taking a processor's whole time for a tenth of a second after a product of large matrices.
    """
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(limits=1, user_api="blas"):
            yield
    finally:
        cv2.setNumThreads(before)


@contextmanager
def without_ipp() -> Iterator[None]:
    """Let OpenCV do without Intel's library in this thread.

    The last bit of what its functions for distances and magnitudes return depends on where the data
    lie in memory, which is another place in every run.
    """
    before = cv2.ipp.useIPP()
    cv2.ipp.setUseIPP(False)
    try:
        yield
    finally:
        cv2.ipp.setUseIPP(before)
