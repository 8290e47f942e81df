"""Relative state of a target as seen from the vehicle: bearing, range, and size.

An extended Kalman filter, as J. Ha's thesis cites one (Johnson et al. 2006). Its state is bearing
and elevation of the target, the logarithm of its range, their rates, and a slow bias of the
logarithm of its apparent size. Without the bias the range would be far too sure of itself: a
contour errs by the same few per cent in frame after frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from cable_tracker.arrays import FloatArray

BEARING, ELEVATION, LOG_RANGE, BEARING_RATE, ELEVATION_RATE, LOG_RANGE_RATE, SIZE_BIAS = range(7)
"""Rows of the state."""

POSE_SIZE, STATE_SIZE = 3, 7
"""Rows of the pose, and of the pose with its rates and the bias of the size."""

BEARING_SIGMA = math.radians(0.6)
"""Standard deviation of one measured bearing or elevation [rad]."""

SIZE_SIGMA = 0.03
"""Standard deviation of one measured log size."""

GATE, GATE_TIME = 4.0, 0.6
"""Limit beyond which measurements are passed over [standard deviations], and time without an
accepted one after which it is open [s]."""


@dataclass(frozen=True, slots=True)
class RelativeNoise:
    """Noise of the motion, and of the bias of the measured size.

    Attributes
    ----------
    angular_acceleration : float
        Spectral density of the bearing's and elevation's acceleration [rad/s^1.5].
    range_acceleration : float
        Spectral density of the log range's acceleration [1/s^1.5].
    bias_sigma, bias_time : float
        Standard deviation of the bias of log size, and the time over which it changes [s].
    rate_sigma : float
        Standard deviation of the rates at the beginning [rad/s, 1/s].
    """

    angular_acceleration: float = 0.15
    range_acceleration: float = 0.15
    bias_sigma: float = 0.05
    bias_time: float = 20.0
    rate_sigma: float = 0.5


USUAL = RelativeNoise()
"""Noise for a target of known size."""

SLOW = RelativeNoise(
    angular_acceleration=0.01,
    range_acceleration=0.01,
    bias_sigma=1.0,
    bias_time=1e6,
    rate_sigma=0.01,
)
"""Noise for a target of unknown size that hardly moves: its size may be wrong by a factor of e."""

GUESSED_RANGE = 5.0
"""Initial range of a target of unknown size [m]."""

DIFFERENCE = 1e-5
"""Step of numerical derivatives [rad, log m]."""

LEAST_RANGE, MOST_RANGE = 0.01, 1e4
"""Smallest and largest range of a target [m]: no camera sees farther through water or air."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetSighting:
    """Measurements of a target in one frame.

    Attributes
    ----------
    bearing, elevation : float
        Angles of the target's centre [rad].
    angular_size : float
        Root of the contour's area over the focal length; the target's size over its range.
    is_whole : bool
        Whether that size is valid: not at the border of the picture, not half hidden.
    """

    bearing: float
    elevation: float
    angular_size: float
    is_whole: bool


@dataclass(frozen=True, slots=True, eq=False)
class RelativeState:
    """The belief about where the target is. Never changed in place.

    Attributes
    ----------
    mean : FloatArray
        Rows from `BEARING` to `SIZE_BIAS`, shape (7,) [rad, log m, per second].
    covariance : FloatArray
        Shape (7, 7).
    target_size : float
        Root of the area that the target shows [m].
    noise : RelativeNoise
        See there.
    unseen : float
        Time since a measurement was last taken [s].
    axes : FloatArray
        From the axes of bearing and elevation (ahead, left, up) to those of base_link, shape
        (3, 3).
    """

    mean: FloatArray
    covariance: FloatArray
    target_size: float
    noise: RelativeNoise
    unseen: float = 0.0
    axes: FloatArray = field(default_factory=lambda: np.eye(3))

    @property
    def range(self) -> float:
        """Distance to the target [m]."""
        return math.exp(float(self.mean[LOG_RANGE]))

    @property
    def range_sigma(self) -> float:
        """Standard deviation of the range [m]."""
        return self.range * math.sqrt(float(self.covariance[LOG_RANGE, LOG_RANGE]))

    def position(self) -> FloatArray:
        """Return where the target is in the axes of base_link, shape (3,) [m]."""
        position: FloatArray = self.axes @ _cartesian(self.mean[:POSE_SIZE])
        return position

    def position_covariance(self) -> FloatArray:
        """Return its covariance, shape (3, 3) [m²]."""
        bearing, elevation = (float(self.mean[row]) for row in (BEARING, ELEVATION))
        cb, sb, ce, se = (
            math.cos(bearing), math.sin(bearing), math.cos(elevation), math.sin(elevation),
        )  # fmt: skip
        jacobian = (
            self.range
            * self.axes
            @ np.array([[-ce * sb, -se * cb, ce * cb], [ce * cb, -se * sb, ce * sb], [0.0, ce, se]])
        )
        covariance: FloatArray = jacobian @ self.covariance[:POSE_SIZE, :POSE_SIZE] @ jacobian.T
        return covariance

    def predicted(self, dt: float) -> RelativeState:
        """Return the belief `dt` seconds later.

        A target that is not seen for long does not go on to where no number reaches.
        """
        transition = np.eye(STATE_SIZE)
        transition[:POSE_SIZE, BEARING_RATE:SIZE_BIAS] += dt * np.eye(POSE_SIZE)
        keep = math.exp(-dt / self.noise.bias_time)
        transition[SIZE_BIAS, SIZE_BIAS] = keep
        mean = transition @ self.mean
        mean[LOG_RANGE] = min(max(mean[LOG_RANGE], math.log(LEAST_RANGE)), math.log(MOST_RANGE))
        densities = [self.noise.angular_acceleration] * 2 + [self.noise.range_acceleration]
        added = np.zeros((STATE_SIZE, STATE_SIZE))
        for row, density in enumerate(densities):
            block = density**2 * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
            both = [row, row + POSE_SIZE]
            added[np.ix_(both, both)] = block
        added[SIZE_BIAS, SIZE_BIAS] = (1.0 - keep**2) * self.noise.bias_sigma**2
        covariance = transition @ self.covariance @ transition.T + added
        return replace(self, mean=mean, covariance=covariance, unseen=self.unseen + dt)

    def after_motion(self, rotation: FloatArray, translation: FloatArray) -> RelativeState:
        """Return the belief relative to the pose that the camera has moved to.

        What the camera's own way changes of bearing and elevation depends on the range: sightings
        from several places make it known (parallax).

        Parameters
        ----------
        rotation : FloatArray
            From its own axes later to those earlier, shape (3, 3).
        translation : FloatArray
            Displacement of the camera, in its own earlier axes, shape (3,) [m].
        """

        def carried(pose: FloatArray) -> FloatArray:
            return _polar((_cartesian(pose) - translation) @ rotation)

        pose = self.mean[:POSE_SIZE]
        moved = carried(pose)
        jacobian = np.eye(STATE_SIZE)
        for column in range(POSE_SIZE):
            step = np.zeros(POSE_SIZE)
            step[column] = DIFFERENCE
            change = carried(pose + step) - carried(pose - step)
            change[BEARING] = math.remainder(change[BEARING], 2.0 * math.pi)
            jacobian[:POSE_SIZE, column] = change / (2.0 * DIFFERENCE)
        mean = self.mean.copy()
        mean[:POSE_SIZE] = moved
        covariance = jacobian @ self.covariance @ jacobian.T
        return replace(self, mean=mean, covariance=covariance)

    def updated(self, seen: TargetSighting) -> RelativeState:
        """Return the belief after a sighting; unchanged if the gate refuses it.

        The size counts only while the contour is whole.
        """
        rows = 3 if seen.is_whole and seen.angular_size > 0.0 else 2
        model = np.zeros((rows, STATE_SIZE))
        model[0, BEARING] = model[1, ELEVATION] = 1.0
        measured = [seen.bearing, seen.elevation]
        sigmas = [BEARING_SIGMA] * 2
        if rows == 3:
            # log(size / range) and a bias of the size.
            model[2, LOG_RANGE], model[2, SIZE_BIAS] = -1.0, 1.0
            measured.append(math.log(seen.angular_size / self.target_size))
            sigmas.append(SIZE_SIGMA)
        innovation = np.array(measured) - model @ self.mean
        innovation[0] = math.remainder(innovation[0], 2.0 * math.pi)
        spread = model @ self.covariance @ model.T + np.diag(np.square(sigmas))
        distance = float(innovation @ np.linalg.solve(spread, innovation))
        is_open = self.unseen > GATE_TIME
        if distance > GATE**2:
            return _begin(seen, self) if is_open and rows == 3 else self
        gain = np.linalg.solve(spread, model @ self.covariance).T
        mean = self.mean + gain @ innovation
        rest = np.eye(STATE_SIZE) - gain @ model
        # Joseph's form keeps the covariance positive.
        covariance = rest @ self.covariance @ rest.T + gain @ np.diag(np.square(sigmas)) @ gain.T
        return replace(self, mean=mean, covariance=covariance, unseen=0.0)


def _cartesian(pose: FloatArray) -> FloatArray:
    """Return ahead, left, up [m] of bearing, elevation and log range, shape (3,)."""
    bearing, elevation, log_range = (float(value) for value in pose)
    flat = math.cos(elevation)
    return math.exp(log_range) * np.array(
        [flat * math.cos(bearing), flat * math.sin(bearing), math.sin(elevation)]
    )


def _polar(position: FloatArray) -> FloatArray:
    """Return bearing, elevation and log range of ahead, left, up [m], shape (3,)."""
    ahead, left, up = (float(value) for value in position)
    flat = math.hypot(ahead, left)
    distance = max(math.hypot(flat, up), LEAST_RANGE)
    return np.array([math.atan2(left, ahead), math.atan2(up, flat), math.log(distance)])


def begin_without_size(seen: TargetSighting) -> RelativeState:
    """Return the belief about a target of unknown size: the range is as good as open.

    The unknown size takes the place of the bias. The target is taken to move slowly (`SLOW`), else
    the camera's way would say nothing of the range.
    """
    return begin_relative_state(seen, seen.angular_size * GUESSED_RANGE, SLOW)


def begin_relative_state(
    seen: TargetSighting, target_size: float, noise: RelativeNoise = USUAL
) -> RelativeState:
    """Return the belief after the first sighting.

    Parameters
    ----------
    seen : TargetSighting
        Sighting of a wholly visible target, of an angular size above 0.
    target_size : float
        Root of the area that it shows, above 0 [m].
    noise : RelativeNoise
        See there.
    """
    empty = RelativeState(np.zeros(STATE_SIZE), np.eye(STATE_SIZE), target_size, noise)
    return _begin(seen, empty)


def _begin(seen: TargetSighting, before: RelativeState) -> RelativeState:
    """Return the belief that one sighting alone gives."""
    noise = before.noise
    mean = np.zeros(STATE_SIZE)
    mean[:POSE_SIZE] = (
        seen.bearing,
        seen.elevation,
        math.log(before.target_size / seen.angular_size),
    )
    bias = noise.bias_sigma**2
    variances = [BEARING_SIGMA**2] * 2 + [SIZE_SIGMA**2 + bias] + [noise.rate_sigma**2] * 3 + [bias]
    covariance = np.diag(variances)
    # What the bias adds to the size, the range takes up.
    covariance[LOG_RANGE, SIZE_BIAS] = covariance[SIZE_BIAS, LOG_RANGE] = bias
    return replace(before, mean=mean, covariance=covariance, unseen=0.0)
