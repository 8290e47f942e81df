"""Lays a dive on the earth by its fixes, and takes out how odometry drifts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.metric.frames import rotation_in_plane
from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.frame_table import Samples
from cable_tracker.survey.interpolation import interpolated
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.navigation import Poses, turned
from cable_tracker.tracking.robust import RAYLEIGH_MEDIAN

FEWEST_FIXES = 3
LEAST_WAY = 2.0
"""Smallest extent of the fixes from which a dive is turned on the earth [m]."""

OUTLIER = 4.0
"""Distance from which on a fix is an outlier [standard deviations]."""

DRIFT_NOISE, RATE_NOISE = 2e-5, 1e-7
"""Growth of the variances of odometry's error and of its rate [m²/s, m²/s³]."""

FIRST_DRIFT, FIRST_RATE = 25.0, 0.02**2
"""Variances of odometry's error and of its rate at the beginning [m², m²/s²]."""


@dataclass(frozen=True, slots=True, eq=False)
class Georeference:
    """How a dive's own frame lies in a local frame.

    Attributes
    ----------
    turn : float
        From the dive's x to east [rad].
    shift : FloatArray
        Position of the dive's origin, shape (2,) [m].
    stamps : IndexArray
        Stamps of the fixes, shape (F,) [ns].
    drift : FloatArray
        By how much odometry is off then, shape (F, 2) [m].
    variances : FloatArray
        Variance of each component of the drift, shape (F,) [m²].
    left_out : int
        Fixes that did not count.
    turn_variance : float
        Variance of the turn [rad²].
    ends : FloatArray
        Positions in the dive's frame at the first and the last fix, shape (2, 2) [m].
    """

    turn: float
    shift: FloatArray
    stamps: IndexArray
    drift: FloatArray
    variances: FloatArray
    left_out: int
    turn_variance: float
    ends: FloatArray

    def apply(self, places: FloatArray, stamps: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Return places of the dive's frame (N, 2) in the local one, and variances (N,) [m²]."""
        base = self.stamps[0]
        own, asked = (self.stamps - base) / NANOSECONDS, (stamps - base) / NANOSECONDS
        drift = interpolated(asked, own, self.drift)
        variances = np.interp(asked, own, self.variances)
        beyond = np.maximum(np.maximum(own[0] - asked, asked - own[-1]), 0.0)
        variances = variances + DRIFT_NOISE * beyond + FIRST_RATE * beyond**2
        # Between fixes the drift takes up an error of the turn, beyond them nothing does.
        last = self.ends[np.where(asked < own[0], 0, 1)]
        way = np.where(beyond > 0.0, ((places - last) ** 2).sum(axis=1), 0.0)
        variances = variances + self.turn_variance * way
        return turned(places, self.turn) + self.shift + drift, variances


def georeference(
    poses: Poses, fixes: Samples, frame: LocalFrame, disk: Disk | None = None
) -> Georeference | None:
    """Lay a dive on the earth by its fixes; None where they are too few or too close together.

    The dive is turned and shifted as a whole so that it fits best; what is left over is how
    odometry drifts, a random walk with a rate that wanders, smoothed over all fixes.
    """
    disk = disk or Disk()
    stamps, values = fixes.arrays()
    places = disk.filled(len(stamps), lambda rows: poses.at(stamps[rows]))
    known = np.isfinite(places).all(axis=1)
    stamps, values, places = stamps[known], values[known], places[known, :2]
    # After a clock set back a time has no second place: the poses are those of its first pass.
    is_new = stamps >= np.maximum.accumulate(stamps)
    stamps, values, places = stamps[is_new], values[is_new], places[is_new]
    if len(stamps) < FEWEST_FIXES:
        return None
    measured = frame.from_degrees(values[:, 0], values[:, 1])
    variances = values[:, 2:4].mean(axis=1)
    kept = np.ones(len(stamps), bool)
    for _ in range(3):
        if kept.sum() < FEWEST_FIXES or np.ptp(places[kept], axis=0).max() < LEAST_WAY:
            return None
        turn, shift, turn_variance = _fitted(places[kept], measured[kept], 1.0 / variances[kept])
        kept = _plausible(_residuals(places, measured, turn, shift), variances, disk)
    if kept.sum() < FEWEST_FIXES:
        return None
    residuals = _residuals(places, measured, turn, shift)[kept]
    drift, doubts = _smoothed_drift(stamps[kept], residuals, variances[kept], disk)
    return Georeference(
        turn, shift, stamps[kept], drift, doubts, int((~kept).sum()), turn_variance,
        places[kept][[0, -1]],
    )  # fmt: skip


def _fitted(
    places: FloatArray, measured: FloatArray, weights: FloatArray
) -> tuple[float, FloatArray, float]:
    """Return turn and shift that take places (N, 2) to measured ones, and the turn's variance."""
    total = weights.sum()
    own, other = (weights @ places) / total, (weights @ measured) / total
    a, b = places - own, measured - other
    turn = math.atan2(
        float(weights @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(weights @ (a * b).sum(1))
    )
    variance = 1.0 / float(weights @ (a**2).sum(axis=1))
    return turn, other - rotation_in_plane(turn) @ own, variance


def _residuals(
    places: FloatArray, measured: FloatArray, turn: float, shift: FloatArray
) -> FloatArray:
    """Return by how much measured places (F, 2) miss those of the way, turned and shifted."""
    residuals: FloatArray = measured - (turned(places, turn) + shift)
    return residuals


def _plausible(residuals: FloatArray, variances: FloatArray, disk: Disk) -> BoolArray:
    """Tell which fixes belong to the way: near a running median of what is left over."""
    half = 10
    padded = np.pad(residuals, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    middles = disk.filled(len(residuals), lambda rows: np.median(windows[rows], axis=2))
    off = np.hypot(*(residuals - middles).T)
    spread = max(float(np.median(off)) / RAYLEIGH_MEDIAN, 1e-3)
    allowed = OUTLIER * np.maximum(np.sqrt(variances), spread)
    return np.asarray(off <= allowed)


def _smoothed_drift(
    stamps: IndexArray, residuals: FloatArray, variances: FloatArray, disk: Disk
) -> tuple[FloatArray, FloatArray]:
    """Smooth what is left over (F, 2); a Kalman filter forwards and Rauch, Tung, Striebel back."""
    count = len(stamps)
    steps = np.diff(stamps, prepend=stamps[0]) / NANOSECONDS
    means, spreads, before_means, before_spreads = (disk.array((count, 2, 2)) for _ in range(4))
    mean, spread = np.zeros((2, 2)), np.diag([FIRST_DRIFT, FIRST_RATE])
    for k in range(count):
        move, noise = _drift_step(float(steps[k]))
        mean, spread = move @ mean, move @ spread @ move.T + noise
        before_means[k], before_spreads[k] = mean, spread
        gain = spread[:, 0] / (spread[0, 0] + variances[k])
        mean = mean + np.outer(gain, residuals[k] - mean[0])
        spread = spread - np.outer(gain, spread[0])
        means[k], spreads[k] = mean, spread
    for k in range(count - 2, -1, -1):
        move, _ = _drift_step(float(steps[k + 1]))
        back = spreads[k] @ move.T @ np.linalg.inv(before_spreads[k + 1])
        means[k] += back @ (means[k + 1] - before_means[k + 1])
        spreads[k] += back @ (spreads[k + 1] - before_spreads[k + 1]) @ back.T
    found = means[:, 0].copy(), spreads[:, 0, 0].copy()
    disk.let_go()
    return found


def _drift_step(seconds: float) -> tuple[FloatArray, FloatArray]:
    t = seconds
    move = np.array([[1.0, t], [0.0, 1.0]])
    noise = RATE_NOISE * np.array([[t**3 / 3, t**2 / 2], [t**2 / 2, t]])
    noise[0, 0] += DRIFT_NOISE * t
    return move, noise
