"""The instruments of a simulated vehicle, and their errors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.frames import rotation_of
from cable_tracker.simulation.vehicle import VehicleState

LEAST_RANGE, MOST_RANGE = 0.1, 50.0
"""Smallest and largest range that the altimeter measures [m]."""


@dataclass(frozen=True, slots=True)
class InstrumentErrors:
    """Errors of the instruments: standard deviations.

    Attributes
    ----------
    velocity, velocity_bias : float
        Standard deviations of noise and constant bias of each linear velocity [m/s].
    velocity_scale : float
        Standard deviation of the scale error of all linear velocities.
    turn, turn_bias : float
        Standard deviations of the noise of each angular velocity, of odometry and imu, and of the
        constant bias of odometry's; the imu has none [rad/s].
    attitude : float
        Standard deviation of each measured roll, pitch and yaw [rad].
    acceleration : float
        Standard deviation of each acceleration component [m/s²].
    altitude : float
        Standard deviation of each measured altitude, as a share of it.
    """

    velocity: float = 0.02
    velocity_bias: float = 0.01
    velocity_scale: float = 0.0
    turn: float = math.radians(0.2)
    turn_bias: float = math.radians(0.05)
    attitude: float = math.radians(0.2)
    acceleration: float = 0.02
    altitude: float = 0.01


USUAL_ERRORS = InstrumentErrors()
"""Errors of the instruments in the simulator's dives."""


@dataclass(frozen=True, slots=True, eq=False)
class OdometryReading:
    """Twist, and the pose that follows from adding twists up.

    Attributes
    ----------
    position : FloatArray
        Position in the frame odom, shape (3,) [m].
    angles : FloatArray
        Roll, pitch, yaw, shape (3,) [rad].
    pose_covariance : FloatArray
        Covariance of position and angles, shape (6, 6) [m², rad²].
    twist : FloatArray
        Twist in base_link, shape (6,) [m/s, rad/s].
    twist_covariance : FloatArray
        Covariance of the twist, of noise and bias together, shape (6, 6) [m²/s², rad²/s²].
    """

    position: FloatArray
    angles: FloatArray
    pose_covariance: FloatArray
    twist: FloatArray
    twist_covariance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ImuReading:
    """Attitude, turn rates and accelerations with gravity, in base_link.

    Attributes
    ----------
    angles : FloatArray
        Roll, pitch, yaw, shape (3,) [rad].
    turn : FloatArray
        Shape (3,) [rad/s].
    acceleration : FloatArray
        Shape (3,) [m/s²].
    """

    angles: FloatArray
    turn: FloatArray
    acceleration: FloatArray


GRAVITY = 9.81
"""[m/s²]."""


class InstrumentSet:
    """Reads the instruments of one vehicle.

    Parameters
    ----------
    start : VehicleState
        True state at the start; odom is the world frame by the vehicle's estimate then.
    """

    def __init__(
        self, errors: InstrumentErrors, start: VehicleState, rng: np.random.Generator
    ) -> None:
        self.errors = errors
        self._rng = rng
        steps = np.repeat([errors.velocity, errors.turn], 3)
        biases = np.repeat([errors.velocity_bias, errors.turn_bias], 3)
        self._steps = steps
        self._biases = biases * rng.standard_normal(6)
        # Without a scale error none is drawn: what is drawn next stays the same.
        scale = errors.velocity_scale
        self._scale = 1.0 + scale * float(rng.standard_normal()) if scale else 1.0
        self._twist_covariance = np.diag(steps**2 + biases**2)
        self._position = start.position.copy()
        self._seconds = 0.0

    def odometry(self, state: VehicleState, seconds: float) -> OdometryReading:
        """Read the velocity log, and integrate it to a pose.

        `seconds` is the time since the reading before; 0 for the first.
        """
        twist = state.twist + self._biases + self._steps * self._rng.standard_normal(6)
        twist[:3] *= self._scale
        angles = self._angles(state)
        self._position = self._position + rotation_of(angles) @ twist[:3] * seconds
        self._position[2] = state.position[2]
        self._seconds += seconds
        drift = self.errors.velocity_bias * self._seconds
        place = max(drift, self.errors.velocity) ** 2
        own = self.errors.attitude**2
        return OdometryReading(
            position=self._position.copy(),
            angles=angles,
            pose_covariance=np.diag([place, place, place, own, own, own]),
            twist=twist,
            twist_covariance=self._twist_covariance,
        )

    def imu(self, state: VehicleState) -> ImuReading:
        """Read the imu."""
        rng, errors = self._rng, self.errors
        up = rotation_of(state.angles).T @ np.array([0.0, 0.0, GRAVITY])
        return ImuReading(
            angles=self._angles(state),
            turn=state.twist[3:] + errors.turn * rng.standard_normal(3),
            acceleration=state.acceleration + up + errors.acceleration * rng.standard_normal(3),
        )

    def altitude(self, state: VehicleState) -> float:
        """Read the altimeter, which is gimballed: the vertical distance to the bottom [m]."""
        wrong = 1.0 + self.errors.altitude * float(self._rng.standard_normal())
        return float(state.position[2]) * wrong

    def _angles(self, state: VehicleState) -> FloatArray:
        angles: FloatArray = state.angles + self.errors.attitude * self._rng.standard_normal(3)
        return angles
