"""A vehicle that is driven by thrusters through moving water.

World frame here: x along the general course of the cable, y to its left, z up from the bottom;
metres. base_link as REP 103 has it: x forward, y left, z up, at the camera.

Surge, sway, heave and yaw are four bodies of their own, with added mass, linear and quadratic drag;
Coriolis forces, which are small at these speeds, are left out. An autopilot turns a velocity
through the water into thrust and keeps the altitude; it does not know the current.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.frames import rotation_of
from cable_tracker.simulation.trajectory import Bands, Harmonics

AXES = 4
"""Surge, sway, heave, yaw."""

LONGEST_STEP = 0.01
"""Motion is integrated in steps of at most this [s]."""

TILT_BANDS: Bands = ((0.08, 0.15), (0.2, 0.3), (0.35, 0.5))
"""Frequency bands of the simulated roll and pitch [Hz]."""

CURRENT_BANDS: Bands = ((0.005, 0.01), (0.015, 0.03))
"""Frequency bands of the simulated current [Hz]."""

CURRENT_VARIATION = 0.25
"""The current wavers by up to this share of its strength."""


def _axes(surge: float, sway: float, heave: float, yaw: float) -> FloatArray:
    return np.array([surge, sway, heave, yaw])


@dataclass(frozen=True, slots=True, eq=False)
class VehicleModel:
    """A small inspection vehicle; arrays have shape (4,): surge, sway, heave, yaw.

    Attributes
    ----------
    mass : FloatArray
        With the water that moves along [kg, kg m²].
    linear_drag, quadratic_drag : FloatArray
        [N s/m, N m s] and [N s²/m², N m s²].
    most_thrust : FloatArray
        [N, N m].
    thrust_lag : float
        Time constant of the thrusters [s].
    stiffness : FloatArray
        Gain of the autopilot on deviations of velocity [1/s].
    altitude_stiffness, most_heave : float
        Gain on deviations of altitude [1/s], and limit of the vertical speed [m/s].
    tilt : float
        Roll and pitch stay within +- this [rad].
    """

    mass: FloatArray = field(default_factory=lambda: _axes(80.0, 110.0, 110.0, 12.0))
    linear_drag: FloatArray = field(default_factory=lambda: _axes(20.0, 40.0, 40.0, 6.0))
    quadratic_drag: FloatArray = field(default_factory=lambda: _axes(60.0, 120.0, 120.0, 10.0))
    most_thrust: FloatArray = field(default_factory=lambda: _axes(90.0, 60.0, 60.0, 25.0))
    thrust_lag: float = 0.3
    stiffness: FloatArray = field(default_factory=lambda: _axes(1.2, 1.2, 1.2, 2.5))
    altitude_stiffness: float = 0.5
    most_heave: float = 0.3
    tilt: float = math.radians(1.5)

    def drag(self, velocity: FloatArray) -> FloatArray:
        """Return the drag at a velocity through the water, shape (4,) [N, N m]."""
        slowed: FloatArray = velocity * (self.linear_drag + self.quadratic_drag * np.abs(velocity))
        return slowed


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """Commanded velocity through the water, in base_link.

    Attributes
    ----------
    surge, sway, heave : float
        Velocity forward, to the left, up [m/s]. While `heave` is not 0 it
        shifts the altitude that is kept.
    turn : float
        Rate of turn to the left [rad/s].
    """

    surge: float = 0.0
    sway: float = 0.0
    heave: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Current:
    """Moving water, the same everywhere.

    Attributes
    ----------
    mean : FloatArray
        x, y in the world, shape (2,) [m/s].
    variation : Harmonics
        Variation of the strength over time, relative to the mean.
    """

    mean: FloatArray
    variation: Harmonics

    @classmethod
    def random(cls, speed: float, rng: np.random.Generator) -> Current:
        """Draw the direction and the variation of a current of some speed [m/s]."""
        direction = float(rng.uniform(0.0, 2 * math.pi))
        mean = speed * np.array([math.cos(direction), math.sin(direction)])
        return cls(mean, Harmonics.random(CURRENT_VARIATION, CURRENT_BANDS, rng))

    def at(self, time: float) -> FloatArray:
        """Return x, y at a time [s], shape (2,) [m/s]."""
        velocity: FloatArray = self.mean * (1.0 + float(self.variation.values(np.array(time))))
        return velocity


@dataclass(frozen=True, slots=True, eq=False)
class VehicleState:
    """Pose and velocity of a vehicle at one instant.

    Attributes
    ----------
    position : FloatArray
        Position of base_link in the world, shape (3,) [m]; z is the altitude.
    angles : FloatArray
        Roll, pitch, yaw as REP 103 has them, yaw from the world's x, shape (3,) [rad].
    twist : FloatArray
        Linear and angular velocity in base_link, shape (6,) [m/s, rad/s].
    acceleration : FloatArray
        Linear, in base_link, without gravity, shape (3,) [m/s²].
    """

    position: FloatArray
    angles: FloatArray
    twist: FloatArray
    acceleration: FloatArray

    def moved(self, seconds: float) -> VehicleState:
        """Return the state some seconds later, or earlier, at constant velocity."""
        ground = rotation_of(self.angles) @ self.twist[:3]
        return replace(
            self,
            position=self.position + ground * seconds,
            angles=self.angles + angle_rates(self.angles, self.twist[3:]) * seconds,
        )


class Vehicle:
    """A simulated vehicle: its pose and velocity, integrated over time.

    Parameters
    ----------
    current : Current
        The water around it.
    pose : FloatArray
        Initial x, y, z, yaw, shape (4,) [m, rad]. The vehicle keeps the altitude z.
    rng : numpy.random.Generator
        Draws roll and pitch over time.
    """

    def __init__(self, current: Current, pose: FloatArray, rng: np.random.Generator) -> None:
        self._model = VehicleModel()
        self._current = current
        self._pose = pose.astype(np.float64)
        self._velocity = np.zeros(AXES)
        self._thrust = np.zeros(AXES)
        self._gain = np.zeros(AXES)
        self._altitude_setpoint = float(pose[2])
        self._time = 0.0
        self._roll = Harmonics.random(self._model.tilt, TILT_BANDS, rng)
        self._pitch = Harmonics.random(self._model.tilt, TILT_BANDS, rng)

    @property
    def velocity(self) -> FloatArray:
        """Through the water: surge, sway, heave, yaw, shape (4,) [m/s, rad/s]."""
        return self._velocity.copy()

    @property
    def pose(self) -> FloatArray:
        """x, y, z, yaw in the world, shape (4,) [m, rad]."""
        return self._pose.copy()

    def advance(self, command: VelocityCommand, altitude: float, seconds: float) -> None:
        """Integrate the motion over some time.

        Parameters
        ----------
        command : VelocityCommand
            Held for all of the time.
        altitude : float
            Measured altitude, for the autopilot [m].
        seconds : float
            Duration [s].
        """
        steps = max(1, math.ceil(seconds / LONGEST_STEP - 1e-9))
        for _ in range(steps):
            self._step(command, altitude, seconds / steps)

    def _step(self, command: VelocityCommand, altitude: float, step: float) -> None:
        model = self._model
        self._altitude_setpoint += command.heave * step
        limit = model.most_heave
        climb = model.altitude_stiffness * (self._altitude_setpoint - altitude)
        heave = command.heave if command.heave else min(max(climb, -limit), limit)
        wanted = _axes(command.surge, command.sway, heave, command.turn)
        push = model.mass * model.stiffness * (wanted - self._velocity) + model.drag(wanted)
        push = np.clip(push, -model.most_thrust, model.most_thrust)
        self._thrust += (push - self._thrust) * -math.expm1(-step / model.thrust_lag)
        self._gain = (self._thrust - model.drag(self._velocity)) / model.mass
        self._velocity = self._velocity + self._gain * step
        self._pose = self._pose + self._pose_rates() * step
        self._time += step

    def _pose_rates(self) -> FloatArray:
        """Return the rates of x, y, z and yaw in the world, shape (4,) [m/s, rad/s]."""
        surge, sway, heave, turn = self._velocity
        cos, sin = math.cos(self._pose[3]), math.sin(self._pose[3])
        x, y = self._current.at(self._time)
        return np.array([cos * surge - sin * sway + x, sin * surge + cos * sway + y, heave, turn])

    def state(self) -> VehicleState:
        """Return the true pose, velocity and acceleration now."""
        step = 1e-3
        times = np.array([self._time - step, self._time, self._time + step])
        rolls, pitches = self._roll.values(times), self._pitch.values(times)
        roll, pitch = float(rolls[1]), float(pitches[1])
        rates = (
            float(rolls[2] - rolls[0]) / (2 * step),
            float(pitches[2] - pitches[0]) / (2 * step),
            float(self._velocity[3]),
        )
        yaw = float(self._pose[3])
        angles = np.array([roll, pitch, yaw])
        to_world = rotation_of(angles)
        over_ground = self._pose_rates()[:3]
        # Surge, sway and heave are along axes that turn with the yaw, but stay level.
        level = rotation_of(np.array([0.0, 0.0, yaw]))
        turning = np.cross([0.0, 0.0, self._velocity[3]], self._velocity[:3])
        return VehicleState(
            position=self._pose[:3].copy(),
            angles=angles,
            twist=np.concatenate((to_world.T @ over_ground, body_rates(angles, rates))),
            acceleration=to_world.T @ (level @ (self._gain[:3] + turning)),
        )


def body_rates(angles: FloatArray, rates: tuple[float, float, float]) -> FloatArray:
    """Return the angular velocity in base_link for rates of roll, pitch, yaw, shape (3,)."""
    roll, pitch, _ = angles
    p, q, r = rates
    return np.array(
        [
            p - r * math.sin(pitch),
            q * math.cos(roll) + r * math.sin(roll) * math.cos(pitch),
            -q * math.sin(roll) + r * math.cos(roll) * math.cos(pitch),
        ]
    )


def angle_rates(angles: FloatArray, body: FloatArray) -> FloatArray:
    """Return the rates of roll, pitch, yaw, shape (3,), for an angular velocity in base_link."""
    roll, pitch, _ = angles
    p, q, r = body
    level = q * math.sin(roll) + r * math.cos(roll)
    return np.array(
        [
            p + level * math.tan(pitch),
            q * math.cos(roll) - r * math.sin(roll),
            level / math.cos(pitch),
        ]
    )
