"""Where the vehicle was: odometry without its jumps, and how it lies on the earth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pyproj import Transformer

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.errors import ParameterError
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.frame_table import Rows, Samples
from cable_tracker.survey.on_disk import Disk, Unwrapping, surroundings
from cable_tracker.tracking.robust import GAUSSIAN_MAD

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
        """Return x, y, yaw at stamps (M,), shape (M, 3); NaN where odometry was silent.

        Only what lies around these stamps is read.
        """
        count = len(self.stamps)
        if count < 2:
            return np.full((len(stamps), 3), np.nan)
        base, end = self.stamps[0], (self.stamps[-1] - self.stamps[0]) / NANOSECONDS
        around = surroundings(self.stamps, stamps)
        known = self.stamps[around]
        own, asked = (known - base) / NANOSECONDS, (stamps - base) / NANOSECONDS
        found = np.column_stack([np.interp(asked, own, column) for column in self.places[around].T])
        after = np.clip(np.searchsorted(known, stamps), 1, len(known) - 1)
        gap = own[after] - own[after - 1]
        outside = (asked < -0.1) | (asked > end + 0.1)
        found[outside | (gap > LONGEST_GAP)] = np.nan
        return found


def joined_poses(samples: Samples, disk: Disk | None = None) -> Poses:
    """Return the way of a vehicle, with the pieces of an odometry that jumps put together.

    Over a jump the vehicle is taken to have gone on as before: how far it moved meanwhile is not
    known, and nothing else is.
    """
    disk = disk or Disk()
    way, jumps = _in_order(samples, disk)
    if not len(way):
        return Poses(np.zeros(0, np.int64), np.zeros((0, 3)))
    stamps = disk.filled(len(way), lambda rows: way["stamp"][rows], np.int64)
    places = disk.filled(len(way), lambda rows: way["place"][rows])
    broken: list[int] = []
    for rows in disk.blocks(len(way), 1):
        broken += _broken(way[rows.start - 1 : rows.stop], rows.start)
    for start in broken:
        _join_at(places, start, stamps, disk)
    return Poses(stamps, places, tuple(sorted({*jumps, *(int(stamps[k]) for k in broken)})))


POSE = np.dtype([("stamp", "i8"), ("place", "f8", (3,)), ("speed", "f8")])
"""x, y, yaw without jumps by a whole turn [m, rad], and speed [m/s]."""


def _in_order(samples: Samples, disk: Disk) -> tuple[Rows, list[int]]:
    """Return usable poses whose stamps grow, and where the clock went back [ns]."""
    all_stamps, all_values = samples.arrays()
    way, jumps, yaws = disk.growing(POSE), list[int](), Unwrapping()
    latest: int | None = None
    before = 0
    for rows in disk.blocks(len(all_stamps)):
        values = all_values[rows]
        usable = np.abs(values[:, :2]).max(axis=1, initial=0.0) < BAD_PLACE
        stamps, values = all_stamps[rows][usable], values[usable]
        if not len(stamps):
            continue
        if latest is None:
            latest, before = int(stamps[0]) - 1, int(stamps[0])
        running = np.maximum.accumulate(np.concatenate(([latest], stamps)))
        fresh = stamps > running[:-1]
        back = np.diff(stamps, prepend=before) < -NANOSECONDS
        jumps += running[1:][back].tolist()
        latest, before = int(running[-1]), int(stamps[-1])
        poses = np.zeros(int(fresh.sum()), POSE)
        poses["stamp"], poses["speed"] = stamps[fresh], values[fresh, 3]
        poses["place"][:, :2] = values[fresh, :2]
        poses["place"][:, 2] = yaws.apply(values[fresh, 2])
        way.extend(poses)
    return way.rows(), jumps


def _broken(way: Rows, first: int) -> list[int]:
    """Return where a way (N,) jumps, whose second pose has the number `first`."""
    seconds = np.maximum(np.diff(way["stamp"]) / NANOSECONDS, 0.0)
    steps = np.hypot(*np.diff(way["place"][:, :2], axis=0).T)
    speeds = way["speed"]
    reach = JUMP + seconds * np.minimum(np.maximum(speeds[1:], speeds[:-1]) * 2 + 0.1, FASTEST)
    turns = np.abs(np.diff(way["place"][:, 2]))
    jumps = (steps > reach) | (turns > JUMP_TURN + 2.0 * seconds)
    return [first + int(k) for k in np.flatnonzero(jumps)]


def _join_at(places: FloatArray, start: int, stamps: IndexArray, disk: Disk) -> None:
    """Move everything from a row on so that the way goes on as before it."""
    before = max(start - 2, 0)
    step = max(float(stamps[start - 1] - stamps[before]), 1.0)
    share = min(float(stamps[start] - stamps[start - 1]) / step, 3.0)
    expected = places[start - 1] + share * (places[start - 1] - places[before])
    if start - 1 == before:
        expected = places[start - 1].copy()
    origin = places[start].copy()
    turn = float(expected[2] - origin[2])
    for rows in disk.blocks(len(places), start):
        places[rows, :2] = turned(places[rows, :2] - origin[:2], turn) + expected[:2]
        places[rows, 2] += turn


def turned(places: FloatArray, turn: float) -> FloatArray:
    """Return places (N, 2) turned by an angle to the left [rad].

    Written out: the last bit of a product of matrices depends on how many rows they have.
    """
    cos, sin = math.cos(turn), math.sin(turn)
    x, y = places.T
    return np.column_stack((x * cos - y * sin, x * sin + y * cos))


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

    def apply(self, places: FloatArray, stamps: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Return places of the dive's frame (N, 2) in the local one, and variances (N,) [m²]."""
        base = self.stamps[0]
        own, asked = (self.stamps - base) / NANOSECONDS, (stamps - base) / NANOSECONDS
        drift = np.column_stack([np.interp(asked, own, column) for column in self.drift.T])
        variances = np.interp(asked, own, self.variances)
        beyond = np.maximum(np.maximum(own[0] - asked, asked - own[-1]), 0.0)
        variances = variances + DRIFT_NOISE * beyond + FIRST_RATE * beyond**2
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
        kept = _plausible(_left(places, measured, turn, shift), variances, disk)
    if kept.sum() < FEWEST_FIXES:
        return None
    left = _left(places, measured, turn, shift)[kept]
    drift, doubts = _smoothed_drift(stamps[kept], left, variances[kept], disk)
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


def _plausible(left: FloatArray, variances: FloatArray, disk: Disk) -> BoolArray:
    """Tell which fixes belong to the way: near a running median of what is left over."""
    half = 10
    padded = np.pad(left, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    middles = disk.filled(len(left), lambda rows: np.median(windows[rows], axis=2))
    off = np.hypot(*(left - middles).T)
    spread = max(GAUSSIAN_MAD * float(np.median(off)) / math.sqrt(2 * math.log(2)), 1e-3)
    allowed = OUTLIER * np.maximum(np.sqrt(variances), spread)
    return np.asarray(off <= allowed)


def _smoothed_drift(
    stamps: IndexArray, left: FloatArray, variances: FloatArray, disk: Disk
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
        mean = mean + np.outer(gain, left[k] - mean[0])
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
