"""How much a cable moves from frame to frame: the noise of the movement model.

Tables 4.2 and 4.3 of the thesis list these variances for its sequences.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.model.geometry import states_in_chart
from cable_tracker.cable.model.state import ANGLE, LENGTHS, POSE_COMPONENTS, POSE_SIZE, STATE_SIZE
from cable_tracker.errors import ParameterError
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, REFERENCE_WIDTH

UNITS = np.array([each.factor**2 for each in POSE_COMPONENTS])
"""Turns px² and rad² of d, alpha, w, beta into px² and deg²."""

LONGEST_STEP = 1.5
"""Longest time from one frame to the next one, as a multiple of the usual: after more than that
frames are missing, the clock has jumped, or another recording begins."""


def usual_step(stamps: IndexArray) -> float:
    """Return the usual time from one frame to the next of stamps (N,) [s]; NaN: there is none."""
    steps = np.diff(stamps)
    forwards = steps[steps > 0]
    return float(np.median(forwards)) / NANOSECONDS if len(forwards) else math.nan


def parted_at_gaps(states: FloatArray, stamps: IndexArray) -> FloatArray:
    """Return states with a row of NaN, a frame without a label, wherever frames do not go on.

    Parameters
    ----------
    states : FloatArray
        One row for each frame, shape (N, C).
    stamps : IndexArray
        Times of the frames, shape (N,) [ns].
    """
    steps = np.diff(stamps) / NANOSECONDS
    gaps = np.flatnonzero((steps <= 0.0) | (steps > LONGEST_STEP * usual_step(stamps))) + 1
    return np.insert(states, gaps, np.nan, axis=0)


def at_reference_width(states: FloatArray, widths: FloatArray) -> FloatArray:
    """Return states (N, 8), of pictures of widths (N,) [px], in px of the reference width."""
    scaled = states.copy()
    scaled[:, LENGTHS] *= (REFERENCE_WIDTH / widths)[:, None]
    return scaled


def per_reference_frame(variances: FloatArray, step: float) -> FloatArray:
    """Return variances of steps of a time [s] as those of frames at the reference rate.

    They grow with the time, as those of the filter's diffusion do.
    """
    return variances / (step * REFERENCE_RATE)


def increment_variances(states: FloatArray) -> FloatArray:
    """Return the sample variances of the differences between consecutive states.

    Parameters
    ----------
    states : FloatArray
        d, alpha, w, beta in the first columns, shape (N, 4) or (N, 8) [px, rad]. Rows with NaN are
        frames without a label; the steps to and from them do not count. An angle may go across the
        wrap.

    Returns
    -------
    FloatArray
        Of d [px²], alpha [deg²], w [px²], beta [deg²], shape (4,).

    Raises
    ------
    ParameterError
        There are fewer than two steps between labelled frames.
    """
    full = np.zeros((states.shape[0], STATE_SIZE))
    full[:, :4] = states[:, :4]
    labelled = np.asarray(np.isfinite(full).all(axis=1))
    pairs = labelled[1:] & labelled[:-1]
    count = int(pairs.sum())
    if count < 2:
        raise ParameterError(
            f"{count} steps between labelled frames: give at least 3 consecutive labelled frames"
        )
    before, after = full[:-1][pairs], full[1:][pairs]
    # In the chart of the state before, a step across the wrap is as small as any other.
    steps = states_in_chart(after, before[:, ANGLE]) - before
    variances: FloatArray = np.var(steps[:, :POSE_SIZE], axis=0, ddof=1) * UNITS
    return variances
