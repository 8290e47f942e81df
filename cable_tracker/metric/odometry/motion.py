"""Motion of a vehicle between two times, integrated from the twists of its odometry."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.history import History
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.stamps import NANOSECONDS

LONGEST_HOLD = 0.2
"""Time after its stamp for which a twist is held [s]; then odometry is late."""

FARTHEST = 0.5
"""Longest time from a picture to the nearest twist of those that are interpolated [s]: in a longer
silence a vehicle may stop and turn."""

LONGEST_STEP = 2.0
"""Motion over a longer time is not predicted [s]."""

FROZEN_COUNT = 8
"""Number of bit-wise equal twists that show that an instrument hangs."""

LARGEST_TWIST = 1e12
"""Velocities and variances beyond it are none [SI units]: an instrument that knows nothing may say
the largest number there is, whose sums and squares are infinite."""

UNKNOWN_SPEED, UNKNOWN_TURN = 10.0, math.radians(90.0)
"""A velocity or rate of turn whose standard deviation is larger is not measured [m/s, rad/s]: it is
more than a vehicle under water does, and instruments say so by a huge variance."""

TWIST = 6
"""Components of a twist: linear x, y, z [m/s], angular x, y, z [rad/s], in base_link."""

TURNS_ALONE = np.diag([UNKNOWN_VARIANCE] * 3 + [0.0] * 3)
"""Covariance of the twist of an instrument that measures turns alone, shape (6, 6)."""


@dataclass(frozen=True, slots=True)
class Unaided:
    """Stands for a motion that is unknown, or that the filter is not told of.

    Attributes
    ----------
    why : str
        In words.
    disagrees : bool
        Whether odometry has come and contradicts what the camera sees.
    """

    why: str
    disagrees: bool = False


SWITCHED_OFF = Unaided("the parameter motion_aid is false")
FIRST_FRAME = Unaided("no frame has come before")
NOT_PROVED = Unaided("odometry has not yet been seen to agree with what the camera sees")
CABLE_DISAGREES = Unaided("odometry disagrees with what the camera sees", disagrees=True)
TURN_NOT_MEASURED = Unaided(
    "odometry measures no turns (the covariance of its rates is beyond"
    f" {math.degrees(UNKNOWN_TURN):.0f} deg/s); give an imu"
)
TEXTURE_DISAGREES = Unaided(
    "odometry disagrees with how the sea bed moves in the image", disagrees=True
)


@dataclass(frozen=True, slots=True, eq=False)
class PoseChange:
    """Relative pose of base_link at a later time in base_link at an earlier time.

    Attributes
    ----------
    rotation : FloatArray
        From the later base_link to the earlier one, shape (3, 3).
    translation : FloatArray
        Position of the later origin in the earlier frame, shape (3,) [m].
    covariance : FloatArray
        Covariance of translation and rotation vector, shape (6, 6) [m, rad].
    seconds : float
        The time between.
    """

    rotation: FloatArray
    translation: FloatArray
    covariance: FloatArray
    seconds: float

    @property
    def has_translation(self) -> bool:
        """Whether the translation is known: all velocities that it comes from were measured."""
        return bool((self._sigmas()[:3] <= UNKNOWN_SPEED).all())

    @property
    def measured_turns(self) -> int:
        """Number of axes about which rates of turn were measured, 0 to 3."""
        return int((self._sigmas()[3:] <= UNKNOWN_TURN).sum())

    def _sigmas(self) -> FloatArray:
        sigmas: FloatArray = np.sqrt(self.covariance.diagonal()) / self.seconds
        return sigmas


class Odometry:
    """The last twists of a vehicle, with their covariances.

    Parameters
    ----------
    instrument : str
        Name of the instrument that measures velocities, for messages about missing motion.

    Attributes
    ----------
    missing : Unaided or None
        Says that there has not been any twist; None from the first one on.
    """

    def __init__(self, instrument: str = "odometry") -> None:
        self._instrument = instrument
        self._twists = History()
        self.missing: Unaided | None = Unaided(f"no {instrument} has come")

    def add(self, stamp: int, twist: FloatArray, covariance: FloatArray) -> None:
        """Take a twist (6,) and its covariance (6, 6) of a time [ns]."""
        self.missing = None
        self._twists.add(stamp, np.concatenate((twist, covariance.ravel())))

    def add_turn(self, stamp: int, rates: FloatArray) -> None:
        """Take rates of turn (3,) [rad/s] of a time [ns], measured without velocities."""
        self.add(stamp, np.concatenate((np.zeros(3), rates)), TURNS_ALONE)

    def motion(self, start: int, end: int) -> PoseChange | Unaided:
        """Return the vehicle's motion from one time to a later one [ns], or why it is not known.

        The twist is interpolated between its stamps, and held for a moment after the last.
        """
        if self.missing is not None:
            return self.missing
        seconds = (end - start) / NANOSECONDS
        why = self._why_unknown(start, end, seconds)
        if why:
            return Unaided(why)
        within = self._twists.between(start + 1, end)
        knots = [self._knot(start), *within, self._knot(end)]
        # Written so that NaN counts as too large.
        if not all((np.abs(values) <= LARGEST_TWIST).all() for _, values in knots):
            return Unaided(f"{self._instrument} is not finite, or as good as infinite")
        return _integrated(knots, seconds)

    def turned_by(self, gyroscope: Odometry, start: int, end: int) -> PoseChange:
        """Return the way by these velocities, along the turn that another instrument measured.

        Of both, `motion` must be known between the two times [ns]. A way bends as the vehicle
        turns: with a turn that was not measured, another place would be reached.
        """
        stamps = {start, end}
        for source in (self, gyroscope):
            stamps |= {stamp for stamp, _ in source._twists.between(start + 1, end)}
        knots = [
            (stamp, _with_rates(self._knot(stamp)[1], gyroscope._knot(stamp)[1]))
            for stamp in sorted(stamps)
        ]
        return _integrated(knots, (end - start) / NANOSECONDS)

    def _why_unknown(self, start: int, end: int, seconds: float) -> str:
        name = self._instrument
        if not 0.0 < seconds <= LONGEST_STEP:
            return f"{seconds:g} s between frames are not bridged"
        first, last = self._twists.at(start), self._twists.at(end)
        if first is None or last is None:
            return f"{name} has only later stamps than the image"
        if last.age > LONGEST_HOLD:
            return f"the last {name} is more than {LONGEST_HOLD:g} s older than the image"
        if max(first.nearest, last.nearest) > FARTHEST:
            return f"the nearest {name} is more than {FARTHEST:g} s from the image"
        is_frozen = self._twists.is_frozen(FROZEN_COUNT, end)
        return f"{name} says the same again and again" if is_frozen else ""

    def _knot(self, stamp: int) -> tuple[int, FloatArray]:
        reading = self._twists.at(stamp)
        assert reading is not None
        return stamp, reading.values


def moved_between(
    odometry: Odometry, gyroscope: Odometry, start: int, end: int
) -> PoseChange | Unaided:
    """Return the motion of base_link between two times [ns], or why it is not known.

    Of what is returned the rotation is known, the translation perhaps not (see
    `PoseChange.has_translation`). A turn that odometry does not measure about all axes is that of
    the gyroscope, if there is one.
    """
    moved = odometry.motion(start, end)
    if isinstance(moved, PoseChange) and moved.measured_turns == 3:
        return moved
    turned = gyroscope.motion(start, end)
    if isinstance(turned, PoseChange):
        if isinstance(moved, PoseChange) and moved.has_translation:
            return odometry.turned_by(gyroscope, start, end)
        return turned
    if isinstance(moved, PoseChange) and moved.measured_turns:
        # Odometry in a plane: to keep level is nearer to the truth than not to turn.
        return moved
    if gyroscope.missing is None:
        return turned
    return TURN_NOT_MEASURED if isinstance(moved, PoseChange) else moved


def _with_rates(twist: FloatArray, turning: FloatArray) -> FloatArray:
    """Return velocities of one twist and rates of turn of another, each with its covariance.

    Twists are followed by their covariances, in one row, shape (42,).
    """
    joined = turning.copy()
    joined[:3] = twist[:3]
    covariance = joined[TWIST:].reshape(TWIST, TWIST)
    covariance[:3, :3] = twist[TWIST:].reshape(TWIST, TWIST)[:3, :3]
    return joined


def _integrated(knots: list[tuple[int, FloatArray]], seconds: float) -> PoseChange:
    values = np.array([each for _, each in knots])
    steps = np.array([(end - begin) / NANOSECONDS for (begin, _), (end, _) in pairwise(knots)])
    means = (values[:-1] + values[1:]) / 2
    turns = means[:, 3:TWIST] * steps[:, None]
    halves, wholes = np.split(rotations_by(np.concatenate((turns / 2, turns))), 2)
    # The velocity is that of the middle of the step.
    ways = np.einsum("nij,nj->ni", halves, means[:, :3]) * steps[:, None]
    rotation, translation = np.eye(3), np.zeros(3)
    for way, whole in zip(ways, wholes, strict=True):
        translation += rotation @ way
        rotation = np.asarray(rotation @ whole)
    covariance = (steps / seconds @ means[:, TWIST:]).reshape(TWIST, TWIST)
    # Errors of odometry are biases more than noise: over one step they are taken as constant.
    return PoseChange(rotation, translation, covariance * seconds**2, seconds)


def rotations_by(vectors: FloatArray) -> FloatArray:
    """Return rotations by rotation vectors (N, 3) [rad], shape (N, 3, 3), by Rodrigues' formula."""
    angles = np.sqrt((vectors * vectors).sum(axis=1))
    cross = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -z, y, -x
    cross[:, 1, 0], cross[:, 2, 0], cross[:, 2, 1] = z, -y, x
    safe = np.maximum(angles, 1e-8)
    is_turned = angles >= 1e-8
    sine = np.where(is_turned, np.sin(safe) / safe, 1.0)
    cosine = np.where(is_turned, (1.0 - np.cos(safe)) / safe**2, 0.0)
    turned: FloatArray = (
        np.eye(3) + sine[:, None, None] * cross + cosine[:, None, None] * (cross @ cross)
    )
    return turned
