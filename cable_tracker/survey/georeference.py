"""Georeferences a dive by its fixes, and corrects the drift of odometry."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray, interpolated
from cable_tracker.metric.frames import rotation_in_plane
from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.frame_table import Samples
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.trajectory import JUMP, Trajectory, turned
from cable_tracker.tracking.robust import GAUSSIAN_MAD, RAYLEIGH_MEDIAN

FEWEST_FIXES = 3
LEAST_EXTENT = 2.0
"""Smallest extent of the fixes from which a dive is turned on the earth [m]."""

OUTLIER = 4.0
"""Distance from which on a fix is an outlier [standard deviations]."""

DISTANCE_SHARE = 0.1
"""Share of the distance between two fixes by which odometry may be off."""

MOST_GROUPS = 30
"""Number of groups of fixes that are told apart at a time."""

LONGEST_STEP = 10.0
"""Longest time over which the drift is interpolated [s]."""

NEW_RATE = 0.1**2
"""Variance of the rate of odometry's error after it has begun anew: what the vehicle turned
meanwhile is not known, either [m²/s²]."""

UNSEEN_SPEED = 1.0
"""Standard deviation of a vehicle's speed while odometry that begins anew is silent [m/s]."""

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
        Angle from the dive's x to east [rad].
    shift : FloatArray
        Position of the dive's origin, shape (2,) [m].
    stamps : IndexArray
        Times of the fixes, and of others between them, shape (T,) [ns].
    drift : FloatArray
        Error of odometry at these times, shape (T, 2) [m].
    variances : FloatArray
        Variance of each component of the drift, shape (T,) [m²].
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

    def apply(self, points: FloatArray, stamps: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Return points of the dive's frame (N, 2) in the local one, and variances (N,) [m²]."""
        base = self.stamps[0]
        own, asked = (self.stamps - base) / NANOSECONDS, (stamps - base) / NANOSECONDS
        drift = interpolated(asked, own, self.drift)
        variances = np.interp(asked, own, self.variances)
        beyond = np.maximum(np.maximum(own[0] - asked, asked - own[-1]), 0.0)
        variances = variances + DRIFT_NOISE * beyond + FIRST_RATE * beyond**2
        # Between fixes the drift takes up an error of the turn, beyond them nothing does.
        last = self.ends[np.where(asked < own[0], 0, 1)]
        squares = np.where(beyond > 0.0, ((points - last) ** 2).sum(axis=1), 0.0)
        variances = variances + self.turn_variance * squares
        return turned(points, self.turn) + self.shift + drift, variances


@dataclass(frozen=True, slots=True, eq=False)
class _Fixes:
    """Fixes of a dive; one row each.

    Attributes
    ----------
    stamps : IndexArray
        Shape (F,) [ns].
    odometry : FloatArray
        Position of the vehicle by odometry, x, y in the dive's frame, shape (F, 2) [m].
    measured : FloatArray
        Position by the fixes, east and north in the local frame, shape (F, 2) [m].
    variances : FloatArray
        Variance of each component, shape (F,) [m²].
    """

    stamps: IndexArray
    odometry: FloatArray
    measured: FloatArray
    variances: FloatArray

    def chosen(self, rows: BoolArray) -> _Fixes:
        """Return some of them, given by a mask (F,)."""
        return _Fixes(
            self.stamps[rows], self.odometry[rows], self.measured[rows], self.variances[rows]
        )

    def residuals(self, turn: float, shift: FloatArray) -> FloatArray:
        """Return by how much they miss the turned [rad] and shifted [m] poses, shape (F, 2) [m]."""
        missed: FloatArray = self.measured - (turned(self.odometry, turn) + shift)
        return missed


@dataclass(frozen=True, slots=True, eq=False)
class _Joints:
    """Where odometry began anew or jumped, and its trajectory was joined.

    Attributes
    ----------
    before, after : IndexArray
        Times of the poses before and after each, shape (J,) [ns].
    variances : FloatArray
        Variance of each component of the motion between, which is not known, shape (J,) [m²].
    """

    before: IndexArray
    after: IndexArray
    variances: FloatArray

    def added(self, start: int, end: int) -> float:
        """Return the variance of the motion between two times [ns] that is not known [m²]."""
        return float(self.variances[(self.after > start) & (self.after <= end)].sum())


def georeference(
    trajectory: Trajectory, fixes: Samples, frame: LocalFrame, disk: Disk
) -> Georeference | None:
    """Lay a dive on the earth by its fixes; None where they are too few or too close together.

    The dive is turned and shifted as a whole so that it fits best; what is left over is how
    odometry drifts, a random walk with a rate that wanders, smoothed over all fixes.
    """
    joints, placed = _joints_of(trajectory), _placed(trajectory, fixes, frame, disk)
    if len(placed.stamps) < FEWEST_FIXES:
        return None
    candidates = placed.chosen(_of_one_way(placed, joints))
    kept = candidates
    for _ in range(3):
        if len(kept.stamps) < FEWEST_FIXES or np.ptp(kept.odometry, axis=0).max() < LEAST_EXTENT:
            return None
        turn, shift, turn_variance = _fitted(kept)
        kept = candidates.chosen(
            _plausible(candidates.residuals(turn, shift), candidates.variances, disk)
        )
    if len(kept.stamps) < FEWEST_FIXES:
        return None
    times, drift, variances = _smoothed_drift(kept, kept.residuals(turn, shift), joints, disk)
    left_out, ends = len(placed.stamps) - len(kept.stamps), kept.odometry[[0, -1]]
    return Georeference(turn, shift, times, drift, variances, left_out, turn_variance, ends)


def _placed(trajectory: Trajectory, fixes: Samples, frame: LocalFrame, disk: Disk) -> _Fixes:
    """Return the fixes of which odometry says where the vehicle was."""
    stamps, values = fixes.arrays()
    poses = disk.filled(len(stamps), lambda rows: trajectory.at(stamps[rows]))
    measured = frame.from_degrees(values[:, 0], values[:, 1])
    placed = _Fixes(stamps, poses[:, :2], measured, values[:, 2:4].mean(axis=1))
    placed = placed.chosen(np.isfinite(poses).all(axis=1))
    # After a clock set back a time has no second place: the poses are those of its first pass.
    return placed.chosen(placed.stamps >= np.maximum.accumulate(placed.stamps))


def _joints_of(trajectory: Trajectory) -> _Joints:
    rows = np.array(trajectory.joints, np.int64)
    before, after = trajectory.stamps[rows - 1], trajectory.stamps[rows]
    return _Joints(before, after, (JUMP + UNSEEN_SPEED * (after - before) / NANOSECONDS) ** 2)


def _of_one_way(fixes: _Fixes, joints: _Joints) -> BoolArray:
    """Tell which fixes are as far apart as the vehicle has moved: of several groups the largest.

    A receiver may begin with places of long ago, and they would turn the whole dive.
    """
    measured, moved = (
        np.hypot(*np.diff(points, axis=0).T) for points in (fixes.measured, fixes.odometry)
    )
    # Where fixes state less than they are off by, their scatter counts.
    scatter = (GAUSSIAN_MAD * float(np.median(np.abs(measured - moved)))) ** 2
    groups: list[list[int]] = []
    for row in range(len(fixes.stamps)):
        # The largest first: sooner or later the vehicle is as far from any other place, too.
        groups.sort(key=len, reverse=True)
        fitting = (g for g in groups if _fit_together(fixes, g[-1], row, joints, scatter))
        own = next(fitting, None)
        if own is None:
            groups = [*groups[: MOST_GROUPS - 1], [row]]
        else:
            own.append(row)
    kept = np.zeros(len(fixes.stamps), bool)
    kept[max(groups, key=len)] = True
    return kept


def _fit_together(fixes: _Fixes, first: int, second: int, joints: _Joints, scatter: float) -> bool:
    """Tell whether two fixes are as far apart as the vehicle moved.

    `scatter` is the least variance of the difference [m²].
    """
    measured = math.dist(fixes.measured[first], fixes.measured[second])
    moved = math.dist(fixes.odometry[first], fixes.odometry[second])
    start, end = int(fixes.stamps[first]), int(fixes.stamps[second])
    variance = max(float(fixes.variances[first] + fixes.variances[second]), scatter)
    variance += joints.added(start, end) + FIRST_RATE * ((end - start) / NANOSECONDS) ** 2
    return abs(measured - moved) <= OUTLIER * math.sqrt(variance) + DISTANCE_SHARE * moved


def _fitted(fixes: _Fixes) -> tuple[float, FloatArray, float]:
    """Return turn and shift from positions by odometry to fixes, and the turn's variance."""
    weights = 1.0 / fixes.variances
    total = weights.sum()
    own, other = (weights @ fixes.odometry) / total, (weights @ fixes.measured) / total
    a, b = fixes.odometry - own, fixes.measured - other
    turn = math.atan2(
        float(weights @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(weights @ (a * b).sum(1))
    )
    variance = 1.0 / float(weights @ (a**2).sum(axis=1))
    return turn, other - rotation_in_plane(turn) @ own, variance


def _plausible(residuals: FloatArray, variances: FloatArray, disk: Disk) -> BoolArray:
    """Tell which fixes belong to the trajectory: near a running median of what is left over."""
    half = 10
    # Mirrored: the first one repeated would be its own median, however wrong it is.
    padded = np.pad(residuals, ((half, half), (0, 0)), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    middles = disk.filled(len(residuals), lambda rows: np.median(windows[rows], axis=2))
    off = np.hypot(*(residuals - middles).T)
    spread = max(float(np.median(off)) / RAYLEIGH_MEDIAN, 1e-3)
    allowed = OUTLIER * np.maximum(np.sqrt(variances), spread)
    return np.asarray(off <= allowed)


def _smoothed_drift(
    fixes: _Fixes, residuals: FloatArray, joints: _Joints, disk: Disk
) -> tuple[IndexArray, FloatArray, FloatArray]:
    """Smooth what is left over (F, 2); a Kalman filter forwards and Rauch, Tung, Striebel back.

    Returned are times (T,) [ns], the drift then (T, 2) [m], and its variances (T,) [m²].
    """
    stamps, observed, variances = _at_drift_times(fixes, residuals, joints)
    count = len(stamps)
    steps = np.diff(stamps, prepend=stamps[0]) / NANOSECONDS
    means, spreads, before_means, before_spreads = (disk.array((count, 2, 2)) for _ in range(4))
    mean, spread = np.zeros((2, 2)), np.diag([FIRST_DRIFT, FIRST_RATE])
    for k in range(count):
        move, noise = _drift_step(float(steps[k]))
        if unseen := joints.added(int(stamps[max(k - 1, 0)]), int(stamps[k])):
            noise += np.diag([unseen, NEW_RATE])
        mean, spread = move @ mean, move @ spread @ move.T + noise
        before_means[k], before_spreads[k] = mean, spread
        gain = spread[:, 0] / (spread[0, 0] + variances[k])
        mean = mean + np.outer(gain, observed[k] - mean[0])
        spread = spread - np.outer(gain, spread[0])
        means[k], spreads[k] = mean, spread
    for k in range(count - 2, -1, -1):
        move, _ = _drift_step(float(steps[k + 1]))
        back = spreads[k] @ move.T @ np.linalg.inv(before_spreads[k + 1])
        means[k] += back @ (means[k + 1] - before_means[k + 1])
        spreads[k] += back @ (spreads[k + 1] - before_spreads[k + 1]) @ back.T
    found = stamps, means[:, 0].copy(), spreads[:, 0, 0].copy()
    disk.release_pages()
    return found


def _at_drift_times(
    fixes: _Fixes, residuals: FloatArray, joints: _Joints
) -> tuple[IndexArray, FloatArray, FloatArray]:
    """Return the times at which the drift is worked out, (T,) [ns], residuals and variances then.

    There are so many between two fixes that the drift may be interpolated: over a silence of the
    receiver it wanders, and where odometry begins anew it jumps. Where no fix is, the variance is
    infinite.
    """
    longest = round(LONGEST_STEP * NANOSECONDS)
    between = [
        np.linspace(start, end, math.ceil((end - start) / longest), endpoint=False)[1:]
        for start, end in pairwise(fixes.stamps.tolist())
        if end - start > longest
    ]
    inside = (joints.before > fixes.stamps[0]) & (joints.after < fixes.stamps[-1])
    others = np.concatenate(
        (*between, joints.before[inside], joints.after[inside]), dtype=np.int64, casting="unsafe"
    )
    stamps = np.concatenate((fixes.stamps, others))
    order = np.argsort(stamps, kind="stable")
    observed = np.concatenate((residuals, np.zeros((len(others), 2))))
    variances = np.concatenate((fixes.variances, np.full(len(others), np.inf)))
    return stamps[order], observed[order], variances[order]


def _drift_step(seconds: float) -> tuple[FloatArray, FloatArray]:
    t = seconds
    move = np.array([[1.0, t], [0.0, 1.0]])
    noise = RATE_NOISE * np.array([[t**3 / 3, t**2 / 2], [t**2 / 2, t]])
    noise[0, 0] += DRIFT_NOISE * t
    return move, noise
