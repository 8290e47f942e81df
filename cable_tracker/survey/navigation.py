"""Where the vehicle was: odometry without its jumps, and how it lies on the earth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pyproj import Transformer

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.errors import ParameterError
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.frame_table import Samples

LONGEST_GAP = 1.0
"""Over a longer silence of odometry no pose is interpolated [s]."""

JUMP = 0.5
"""A pose that is farther from where the vehicle can have gone is a jump [m]."""

JUMP_TURN = math.radians(20.0)
"""The same of its direction [rad]."""

FASTEST = 5.0
"""No vehicle over a cable is faster [m/s]."""

BAD_PLACE = 1e7
"""Farther from its origin no odometry is [m]."""

FEWEST_FIXES = 3
LEAST_WAY = 2.0
"""How many fixes, and over how long a way [m], it takes to turn a dive on the earth."""

OUTLIER = 4.0
"""Fixes farther off than this do not count [standard deviations]."""

ROBUST = 1.4826
"""From a median deviation to a standard deviation."""

DRIFT_NOISE, RATE_NOISE = 2e-5, 1e-7
"""By how much the variances of odometry's error, and of its rate, grow [m²/s, m²/s³]."""

FIRST_DRIFT, FIRST_RATE = 25.0, 0.02**2
"""What they are at the beginning [m², m²/s²]."""


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """A vehicle's way in one frame, without jumps.

    Attributes
    ----------
    stamps : FloatArray
        Int64, shape (N,) [ns].
    places : FloatArray
        x, y, yaw (unwrapped), shape (N, 3) [m, rad].
    jumps : tuple of int
        Stamps at which odometry began anew or jumped; it was joined there [ns].
    """

    stamps: IndexArray
    places: FloatArray
    jumps: tuple[int, ...] = ()

    def at(self, stamps: IndexArray) -> FloatArray:
        """Return x, y, yaw at stamps (M,), shape (M, 3); NaN where odometry was silent."""
        if len(self.stamps) < 2:
            return np.full((len(stamps), 3), np.nan)
        base = self.stamps[0]
        own, asked = (self.stamps - base) / NANOSECONDS, (stamps - base) / NANOSECONDS
        found = np.column_stack([np.interp(asked, own, column) for column in self.places.T])
        after = np.clip(np.searchsorted(self.stamps, stamps), 1, len(self.stamps) - 1)
        gap = own[after] - own[after - 1]
        outside = (asked < own[0] - 0.1) | (asked > own[-1] + 0.1)
        found[outside | (gap > LONGEST_GAP)] = np.nan
        return found


def joined_poses(samples: Samples) -> Poses:
    """Return the way of a vehicle, with the pieces of an odometry that jumps put together.

    Over a jump the vehicle is taken to have gone on as before: how far it moved meanwhile is not
    known, and nothing else is.
    """
    stamps, values = samples.arrays()
    usable = np.abs(values[:, :2]).max(axis=1, initial=0.0) < BAD_PLACE
    stamps, values = stamps[usable], values[usable]
    if not len(stamps):
        return Poses(stamps, np.zeros((0, 3)))
    order, jumps = _in_order(stamps)
    places = values[order, :2]
    yaws = np.unwrap(values[order, 2])
    stamps, speeds = stamps[order], values[order, 3]
    seconds = np.maximum(np.diff(stamps) / NANOSECONDS, 0.0)
    steps = np.hypot(*np.diff(places, axis=0).T)
    reach = JUMP + seconds * np.minimum(np.maximum(speeds[1:], speeds[:-1]) * 2 + 0.1, FASTEST)
    turns = np.abs(np.diff(yaws))
    broken = np.flatnonzero((steps > reach) | (turns > JUMP_TURN + 2.0 * seconds)) + 1
    joined = np.column_stack((places, yaws))
    for start in broken:
        joined = _joined_at(joined, int(start), stamps)
    return Poses(stamps, joined, tuple(sorted({*jumps, *(int(stamps[k]) for k in broken)})))


def _in_order(stamps: IndexArray) -> tuple[IndexArray, list[int]]:
    """Return which readings to take so that stamps grow, and where the clock went back."""
    running = np.maximum.accumulate(stamps)
    fresh = np.concatenate(([True], stamps[1:] > running[:-1]))
    back = np.flatnonzero(np.diff(stamps) < -NANOSECONDS) + 1
    return np.flatnonzero(fresh), [int(running[k]) for k in back]


def _joined_at(places: FloatArray, start: int, stamps: IndexArray) -> FloatArray:
    """Move everything from a row on so that the way goes on as before it."""
    before = max(start - 2, 0)
    step = max(float(stamps[start - 1] - stamps[before]), 1.0)
    share = min(float(stamps[start] - stamps[start - 1]) / step, 3.0)
    expected = places[start - 1] + share * (places[start - 1] - places[before])
    if start - 1 == before:
        expected = places[start - 1].copy()
    turn = float(expected[2] - places[start, 2])
    cos, sin = math.cos(turn), math.sin(turn)
    rest = places[start:, :2] - places[start, :2]
    joined = places.copy()
    joined[start:, :2] = rest @ np.array([[cos, sin], [-sin, cos]]) + expected[:2]
    joined[start:, 2] += turn
    return joined


class LocalFrame:
    """Metres east and north of a place on the earth: a plane that touches the ellipsoid there.

    Parameters
    ----------
    latitude, longitude : float
        Of its origin, WGS 84 [deg].

    Raises
    ------
    ParameterError
        There is no such place.
    """

    def __init__(self, latitude: float, longitude: float) -> None:
        if not (abs(latitude) <= 90.0 and abs(longitude) <= 360.0):
            raise ParameterError(
                f"datum: {latitude}, {longitude} is no place on the earth; give latitude,longitude"
                " in degrees, as 54.25,7.9"
            )
        self.latitude, self.longitude = latitude, longitude
        self._to_local = Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad"
            " +step +proj=cart +ellps=WGS84"
            f" +step +proj=topocentric +ellps=WGS84 +lat_0={latitude!r} +lon_0={longitude!r} +h_0=0"
        )

    def from_degrees(self, latitude: FloatArray, longitude: FloatArray) -> FloatArray:
        """Return metres east and north of places on the ellipsoid, shape (N, 2)."""
        east, north, _ = self._to_local.transform(longitude, latitude, np.zeros_like(latitude))
        return np.column_stack((east, north))

    def to_degrees(self, places: FloatArray) -> FloatArray:
        """Return latitude and longitude of metres east and north (N, 2), shape (N, 2)."""
        # Back to height 0: the plane leaves the ellipsoid by the square of the distance.
        up = -(places**2).sum(axis=1) / (2 * 6.371e6)
        longitude, latitude, _ = self._to_local.transform(
            places[:, 0], places[:, 1], up, direction="INVERSE"
        )
        return np.column_stack((latitude, longitude))


@dataclass(frozen=True, slots=True, eq=False)
class Georeference:
    """How a dive's own frame lies in a local frame.

    Attributes
    ----------
    turn : float
        From the dive's x to east [rad].
    shift : FloatArray
        Of the dive's origin, shape (2,) [m].
    stamps : FloatArray
        Of the fixes, shape (F,) [ns].
    drift : FloatArray
        By how much odometry is off then, shape (F, 2) [m].
    variances : FloatArray
        Of each component of it, shape (F,) [m²].
    left_out : int
        Fixes that did not count.
    """

    turn: float
    shift: FloatArray
    stamps: IndexArray
    drift: FloatArray
    variances: FloatArray
    left_out: int

    @property
    def rotation(self) -> FloatArray:
        """From the dive's frame to the local one, shape (2, 2)."""
        cos, sin = math.cos(self.turn), math.sin(self.turn)
        return np.array([[cos, -sin], [sin, cos]])

    def apply(self, places: FloatArray, stamps: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Return places of the dive's frame (N, 2) in the local one, and variances (N,) [m²]."""
        base = self.stamps[0]
        own, asked = (self.stamps - base) / NANOSECONDS, (stamps - base) / NANOSECONDS
        drift = np.column_stack([np.interp(asked, own, column) for column in self.drift.T])
        variances = np.interp(asked, own, self.variances)
        beyond = np.maximum(np.maximum(own[0] - asked, asked - own[-1]), 0.0)
        variances = variances + DRIFT_NOISE * beyond + FIRST_RATE * beyond**2
        return places @ self.rotation.T + self.shift + drift, variances


def georeference(poses: Poses, fixes: Samples, frame: LocalFrame) -> Georeference | None:
    """Lay a dive on the earth by its fixes; None where they are too few or too close together.

    The dive is turned and shifted as a whole so that it fits best; what is left over is how
    odometry drifts, a random walk with a rate that wanders, smoothed over all fixes.
    """
    stamps, values = fixes.arrays()
    places = poses.at(stamps)
    known = np.isfinite(places).all(axis=1)
    stamps, values, places = stamps[known], values[known], places[known, :2]
    order = np.argsort(stamps, kind="stable")
    stamps, values, places = stamps[order], values[order], places[order]
    if len(stamps) < FEWEST_FIXES:
        return None
    measured = frame.from_degrees(values[:, 0], values[:, 1])
    variances = values[:, 3:5].mean(axis=1)
    kept = np.ones(len(stamps), bool)
    for _ in range(3):
        if kept.sum() < FEWEST_FIXES or np.ptp(places[kept], axis=0).max() < LEAST_WAY:
            return None
        turn, shift = _fitted(places[kept], measured[kept], 1.0 / variances[kept])
        kept = _plausible(_left(places, measured, turn, shift), variances)
    if kept.sum() < FEWEST_FIXES:
        return None
    left = _left(places, measured, turn, shift)[kept]
    drift, doubts = _smoothed_drift(stamps[kept], left, variances[kept])
    return Georeference(turn, shift, stamps[kept], drift, doubts, int((~kept).sum()))


def _fitted(
    places: FloatArray, measured: FloatArray, weights: FloatArray
) -> tuple[float, FloatArray]:
    """Return turn and shift that take places (N, 2) to measured ones (N, 2)."""
    total = weights.sum()
    own, other = (weights @ places) / total, (weights @ measured) / total
    a, b = places - own, measured - other
    turn = math.atan2(
        float(weights @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(weights @ (a * b).sum(1))
    )
    cos, sin = math.cos(turn), math.sin(turn)
    return turn, other - np.array([[cos, -sin], [sin, cos]]) @ own


def _left(places: FloatArray, measured: FloatArray, turn: float, shift: FloatArray) -> FloatArray:
    cos, sin = math.cos(turn), math.sin(turn)
    left: FloatArray = measured - (places @ np.array([[cos, sin], [-sin, cos]]) + shift)
    return left


def _plausible(left: FloatArray, variances: FloatArray) -> BoolArray:
    """Tell which fixes belong to the way: near a running median of what is left over."""
    half = 10
    padded = np.pad(left, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    off = np.hypot(*(left - np.median(windows, axis=2)).T)
    spread = max(ROBUST * float(np.median(off)) / math.sqrt(2 * math.log(2)), 1e-3)
    allowed = OUTLIER * np.maximum(np.sqrt(variances), spread)
    return np.asarray(off <= allowed)


def _smoothed_drift(
    stamps: IndexArray, left: FloatArray, variances: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Smooth what is left over (F, 2); a Kalman filter forwards and Rauch, Tung, Striebel back."""
    count = len(stamps)
    steps = np.diff(stamps, prepend=stamps[0]) / NANOSECONDS
    means, spreads = np.zeros((count, 2, 2)), np.zeros((count, 2, 2))
    before_means, before_spreads = np.zeros((count, 2, 2)), np.zeros((count, 2, 2))
    mean, spread = np.zeros((2, 2)), np.diag([FIRST_DRIFT, FIRST_RATE])
    for k in range(count):
        move, noise = _drift_step(float(steps[k]))
        mean, spread = move @ mean, move @ spread @ move.T + noise
        before_means[k], before_spreads[k] = mean, spread
        gain = spread[:, 0] / (spread[0, 0] + variances[k])
        mean = mean + np.outer(gain, left[k] - mean[0])
        spread = spread - np.outer(gain, spread[0])
        means[k], spreads[k] = mean, spread
    for k in range(count - 2, -1, -1):
        move, _ = _drift_step(float(steps[k + 1]))
        back = spreads[k] @ move.T @ np.linalg.inv(before_spreads[k + 1])
        means[k] += back @ (means[k + 1] - before_means[k + 1])
        spreads[k] += back @ (spreads[k + 1] - before_spreads[k + 1]) @ back.T
    return means[:, 0], spreads[:, 0, 0]


def _drift_step(seconds: float) -> tuple[FloatArray, FloatArray]:
    t = seconds
    move = np.array([[1.0, t], [0.0, 1.0]])
    noise = RATE_NOISE * np.array([[t**3 / 3, t**2 / 2], [t**2 / 2, t]])
    noise[0, 0] += DRIFT_NOISE * t
    return move, noise
