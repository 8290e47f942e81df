"""Values between those that are known."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray


def interpolated(asked: FloatArray | float, known: FloatArray, columns: FloatArray) -> FloatArray:
    """Return columns (N, C), known at growing places (N,), at others (M,), shape (M, C).

    At one place the shape is (C,). Before the first and after the last they stay as they are there.
    """
    return np.stack([np.interp(asked, known, column) for column in columns.T], axis=-1)
