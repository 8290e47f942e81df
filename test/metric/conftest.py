from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import Borders, states_from_borders, wrap_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.altitude import Altitude
from cable_tracker.metric.calibration import Calibration, CameraModel, camera_for
from cable_tracker.metric.frames import Attitude, Mounting, rotations_of
from cable_tracker.tracking.status import TrackingStatus

SIZE = (320, 240)

ALTITUDE = Altitude(1.4)
LEVEL = Attitude()
FORWARD = Mounting(0.3, 0.05, -0.1, 0.0, math.radians(70.0), 0.0)
PINHOLE = Calibration(SIZE, "plumb_bob", (280.0, 275.0), (163.0, 117.0))
LENSES = {
    "pinhole": PINHOLE,
    "plumb_bob": dataclasses.replace(PINHOLE, coefficients=(-0.25, 0.08, 1e-3, -5e-4, 0.0)),
    "rational_polynomial": dataclasses.replace(
        PINHOLE,
        model="rational_polynomial",
        coefficients=(0.3, -0.1, 5e-4, 3e-4, 0.02, 0.5, -0.05, 0.01),
    ),
    "equidistant": dataclasses.replace(
        PINHOLE, model="equidistant", coefficients=(-0.02, 0.01, -0.003, 0.0005)
    ),
}


@dataclass(frozen=True)
class Flight:
    """A vehicle above a straight cable on a flat bottom, in its level frame."""

    offset: float
    heading: float
    diameter: float
    altitude: Altitude
    attitude: Attitude
    mounting: Mounting

    def is_in_view(self, camera: CameraModel) -> bool:
        """Whether a line can be laid through what is seen of each edge."""
        return all(len(self._points(camera, aside)) >= 2 for aside in self._edges())

    def _edges(self) -> tuple[float, float]:
        return self.diameter / 2, -self.diameter / 2

    def seen_by(self, camera: CameraModel) -> CableState:
        """Where the cable's edges are in the image, by projecting points of the flat strip."""
        lines = [self._line(camera, aside) for aside in self._edges()]
        angles, offsets = (np.array([column]) for column in zip(*lines, strict=True))
        angles[0, 1] = angles[0, 0] + np.mod(angles[0, 1] - angles[0, 0] + np.pi, 2 * np.pi) - np.pi
        state = np.zeros((1, 8))
        state[:, :4] = states_from_borders(Borders(angles, offsets))
        return CableState.from_array(wrap_states(state)[0])

    def _line(self, camera: CameraModel, aside: float) -> tuple[float, float]:
        """Fit a line to the points of one edge inside the image; its normal from left to right."""
        chosen = self._points(camera, aside)
        assert len(chosen) >= 2, "the camera does not see the cable"
        middle = chosen.mean(axis=0)
        _, _, directions = np.linalg.svd(chosen - middle)
        along = directions[0] * np.sign(directions[0] @ (chosen[-1] - chosen[0]))
        normal = np.array([along[1], -along[0]])
        return float(np.arctan2(normal[1], normal[0])), float(middle @ normal)

    def _points(self, camera: CameraModel, aside: float) -> FloatArray:
        points = camera.project(self.to_optical(self.edge(aside)))
        return points[(np.abs(points) <= (np.array(camera.image_size) - 1) / 2).all(axis=1)]

    def edge(self, aside: float) -> FloatArray:
        """Points of the bottom beside the cable, to the left if positive, in the level frame."""
        along = np.linspace(-6.0, 12.0, 4_001)[:, None]
        direction = np.array([math.cos(self.heading), math.sin(self.heading), 0.0])
        left = np.array([-direction[1], direction[0], 0.0])
        start = np.array([0.0, self.offset, -self.altitude.metres])
        return start + aside * left + along * direction

    def to_optical(self, points: FloatArray) -> FloatArray:
        angles = np.array([[self.attitude.roll, self.attitude.pitch, 0.0]])
        level = rotations_of(angles)[0]
        in_vehicle = points @ level - self.mounting.position
        return in_vehicle @ self.mounting.rotation


@pytest.fixture
def make_flight() -> Callable[..., Flight]:
    def make(
        offset: float = 0.2,
        heading: float = 0.1,
        *,
        diameter: float = 0.16,
        altitude: Altitude = ALTITUDE,
        attitude: Attitude = LEVEL,
        mounting: Mounting = FORWARD,
    ) -> Flight:
        return Flight(offset, heading, diameter, altitude, attitude, mounting)

    return make


@pytest.fixture
def calibrations() -> dict[str, Calibration]:
    return LENSES


@pytest.fixture(params=LENSES)
def calibration(request: pytest.FixtureRequest) -> Calibration:
    return LENSES[request.param]


@pytest.fixture
def camera_of() -> Callable[[Calibration], CameraModel]:
    def make(calibration: Calibration) -> CameraModel:
        camera = camera_for(calibration, calibration.image_size)
        assert isinstance(camera, CameraModel)
        return camera

    return make


@pytest.fixture
def make_estimate() -> Callable[..., CableEstimate]:
    def make(
        state: CableState,
        sigmas: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
        *,
        status: TrackingStatus = TrackingStatus.TRACKING,
        size: tuple[int, int] = SIZE,
        stamp: int = 1_000_000_000,
    ) -> CableEstimate:
        covariance = np.diag(np.array([*sigmas, 0.0, 0.0, 0.0, 0.0]) ** 2)
        return CableEstimate(stamp, status, state, covariance, 100.0, 1.0, size)

    return make
