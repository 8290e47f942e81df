"""From the cable in the image to the cable on the sea bed, in metres.

The centreline and the camera's centre span a plane; where it cuts the sea bed, the cable lies. All
results are in the level frame of `frames`: lateral offset = y of the cable at some x, heading error
= direction of the cable from +x. See docs/metric.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cable_tracker.arrays import (
    BoolArray,
    FloatArray,
    IndexArray,
    mean_and_covariance,
    sigma_points,
)
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import (
    points_on_lines,
    project_borders,
    segment_inside,
    wrap_angles,
)
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE
from cable_tracker.compilation import compiled
from cable_tracker.errors import MetricError
from cable_tracker.libraries import refusals_as
from cable_tracker.metric.altitude import Altitude
from cable_tracker.metric.calibration import Calibration, CameraModel, camera_for
from cable_tracker.metric.frames import Attitude, Mounting, rotations_of
from cable_tracker.metric.withheld import Reason, Withheld

POINTS_PER_LINE = 11
"""Points along each line whose lines of sight are followed."""

LEAST_DEPRESSION = math.radians(3.0)
"""Lines of sight that go down less steeply count as at the horizon [rad]."""

LARGEST_HEADING = math.radians(80.0)
"""A cable that runs more across has no offset to the left or right [rad]."""

LEAST_HEIGHT = 0.05
"""The camera must be this far above the cable's axis [m]."""


@dataclass(frozen=True, slots=True)
class MetricSettings:
    """Settings that are constant during a dive.

    Attributes
    ----------
    mounting : Mounting
        Mounting of the camera.
    look_ahead : float
        Distance in front of base_link at which the offset is given besides x = 0 [m].
    cable_height : float
        Height of the cable's axis above the sea bed [m].
    """

    mounting: Mounting = field(default_factory=Mounting)
    look_ahead: float = 1.0
    cable_height: float = 0.0

    def __post_init__(self) -> None:
        """Refuse numbers that are none.

        Raises
        ------
        MetricError
            `look_ahead` or `cable_height` is not finite.
        """
        for name, value in (("look_ahead", self.look_ahead), ("cable_height", self.cable_height)):
            if not math.isfinite(value):
                raise MetricError(f"{name} is {value}; give a number of metres")


@dataclass(frozen=True, slots=True, eq=False)
class CrossTrack:
    """The cable beside and below the vehicle, in the level frame.

    Attributes
    ----------
    offset : float
        y of the cable at x = 0; positive: the cable is to the left [m].
    offset_ahead : float
        y of the cable at x = `look_ahead` [m].
    heading : float
        Angle of the cable's direction from +x, in (-pi/2, pi/2]; positive: the cable leads to the
        left [rad].
    diameter : float
        Diameter of the cable, from the distance between its borders [m].
    covariance : FloatArray
        Covariance of offset, offset_ahead, heading, diameter, shape (4, 4) [m, rad].
    look_ahead : float
        [m].
    depth : float
        z of the cable's axis; negative: below base_link [m].
    """

    offset: float
    offset_ahead: float
    heading: float
    diameter: float
    covariance: FloatArray
    look_ahead: float
    depth: float

    def standard_deviations(self) -> FloatArray:
        """Return the standard deviations of offset, offset_ahead, heading, diameter, shape (4,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def at_foot(self) -> tuple[float, FloatArray]:
        """Return the offset at x = 0 and the covariance (2, 2) of offset and heading."""
        return self.offset, self.covariance[np.ix_([0, 2], [0, 2])]

    def ahead(self) -> tuple[float, FloatArray]:
        """Return the offset at x = `look_ahead` and the covariance (2, 2) with the heading."""
        return self.offset_ahead, self.covariance[np.ix_([1, 2], [1, 2])]

    def at(self, ahead: float) -> tuple[float, FloatArray]:
        """Return the offset at any x [m], and the covariance (2, 2) with the heading."""
        offset, covariance = self.at_foot()
        slope = np.array([[1.0, ahead / np.cos(self.heading) ** 2], [0.0, 1.0]])
        return offset + ahead * float(np.tan(self.heading)), slope @ covariance @ slope.T


@dataclass(frozen=True, slots=True, eq=False)
class _CameraPoses:
    """Poses of N cameras in the level frame, but with z = 0 at the sea bed.

    `centres` (N, 3) [m]; `rotations` (N, 3, 3) from the optical to the level frame.
    """

    centres: FloatArray
    rotations: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _SeaBedLines:
    """N cables on the sea bed: `values` (N, 4) offset, offset_ahead, heading, diameter.

    Headings are within pi/2 of the first. `below_horizon` (N,): enough of the line's points are.
    """

    values: FloatArray
    below_horizon: BoolArray


class CrossTrackMeter:
    """Turns estimates in pixels into metres.

    Parameters
    ----------
    settings : MetricSettings
        Mounting and what else is fixed.
    calibration : Calibration or None
        Calibration of the camera.
    """

    def __init__(self, settings: MetricSettings, calibration: Calibration | None = None) -> None:
        self._settings = settings
        self._calibration = calibration

    def measure(
        self,
        estimate: CableEstimate,
        altitude: Altitude | Withheld,
        attitude: Attitude | Withheld,
    ) -> CrossTrack | Withheld:
        """Return the cable in metres, or why not.

        Parameters
        ----------
        estimate : CableEstimate
            Estimate in pixels; sigma points carry its covariance through the geometry.
        altitude : Altitude or Withheld
            Altitude of base_link above the sea bed.
        attitude : Attitude or Withheld
            Attitude of base_link.

        Raises
        ------
        MetricError
            Altitude or attitude is something else, such as a number.
        """
        if not estimate.is_claimed:
            return Withheld(Reason.NOT_TRACKING, f"the tracker's status is {estimate.status.value}")
        for given in (altitude, attitude):
            if isinstance(given, Withheld):
                return given
        if not (isinstance(altitude, Altitude) and isinstance(attitude, Attitude)):
            raise MetricError(
                "give an Altitude and an Attitude: Altitude(2.0, sigma=0.02), Attitude(0.0, 0.0)"
            )
        camera = camera_for(self._calibration, estimate.image_size)
        if isinstance(camera, Withheld):
            return camera
        if not attitude.is_finite():
            return Withheld(
                Reason.BAD_ATTITUDE,
                "roll, pitch or their sigma is not finite, or sigma is negative; look at the imu",
            )
        try:
            with refusals_as(MetricError, "no cross track can be computed"):
                return self._fault_of_view(altitude, attitude) or self._measured(
                    estimate, camera, altitude, attitude
                )
        except MetricError as error:
            return Withheld(Reason.NOT_COMPUTED, str(error))

    def _fault_of_view(self, altitude: Altitude, attitude: Attitude) -> Withheld | None:
        fault = altitude.fault()
        if fault is not None:
            return fault
        at = np.array([[altitude.metres, attitude.roll, attitude.pitch]])
        camera = self._camera_poses(at)
        # Written so that NaN fails too.
        if not camera.rotations[0, 2, 2] < -math.sin(LEAST_DEPRESSION):
            return Withheld(
                Reason.CAMERA_LOOKS_UP,
                "with this mounting and attitude the camera looks at the horizon or above it;"
                " see the parameters camera_roll and camera_pitch (90 deg is straight down)",
            )
        if not camera.centres[0, 2] - self._settings.cable_height >= LEAST_HEIGHT:
            return Withheld(
                Reason.CAMERA_TOO_LOW,
                f"at an altitude of {altitude.metres:.2f} m the camera would be in the ground;"
                " see the parameters camera_z and cable_height",
            )
        return None

    def _measured(
        self, estimate: CableEstimate, camera: CameraModel, altitude: Altitude, attitude: Attitude
    ) -> CrossTrack | Withheld:
        state = estimate.state
        segment = segment_inside(state.angle, state.distance, camera.image_size)
        if segment is None:
            return Withheld(Reason.OUT_OF_VIEW, "the estimate runs past the image")
        along = _places_along(state.angle, segment)
        mean, covariance = _joint_moments(estimate, altitude, attitude)
        points = np.concatenate((mean[None, :], sigma_points(mean, covariance)))
        lines = self._sea_bed_lines(points, along, camera)
        fault = _fault_of_lines(lines)
        if fault is not None:
            return fault
        # Whether a sum beyond all numbers overflows or is invalid depends on the processor.
        with np.errstate(over="ignore", invalid="ignore"):
            centre, spread = mean_and_covariance(lines.values[1:])
        if not (np.isfinite(centre).all() and np.isfinite(spread).all()):
            raise MetricError(
                "the cable's place is beyond all numbers; see the parameters camera_x, camera_y,"
                " camera_z, look_ahead and cable_height"
            )
        return CrossTrack(
            offset=float(centre[0]),
            offset_ahead=float(centre[1]),
            heading=float(wrap_angles(centre[2])),
            # A size is never negative: of a thin cable, sigma points whose borders have changed
            # places, or cross, would make the mean too large.
            diameter=float(lines.values[0, 3]),
            covariance=spread,
            look_ahead=self._settings.look_ahead,
            depth=self._settings.cable_height - altitude.metres,
        )

    def _camera_poses(self, situations: FloatArray) -> _CameraPoses:
        """Return the poses of the camera at altitude, roll, pitch (N, 3) [m, rad]."""
        angles = np.column_stack((situations[:, 1:], np.zeros(len(situations))))
        level = rotations_of(angles)
        centres = level @ self._settings.mounting.position
        centres[:, 2] += situations[:, 0]
        return _CameraPoses(centres, level @ self._settings.mounting.rotation)

    def _sea_bed_lines(
        self, points: FloatArray, along: FloatArray, camera: CameraModel
    ) -> _SeaBedLines:
        """Follow cables with what is known of the vehicle, (N, 7), down to the sea bed."""
        cameras = self._camera_poses(points[:, POSE_SIZE:])
        borders = project_borders(points[:, :POSE_SIZE])
        angles = np.column_stack((points[:, ANGLE], borders.angles))
        offsets = np.column_stack((points[:, DISTANCE], borders.offsets))
        rays = camera.rays(points_on_lines(angles, offsets, along))
        moments, usable = _moments(rays, cameras.rotations, math.sin(LEAST_DEPRESSION))
        # Rays of a straight cable lie in a plane, whose normal is that of their least moment; the
        # distortion of the lens bends only the line that the filter has fitted.
        normals = np.linalg.eigh(moments)[1][..., 0]
        values = self._cut(cameras, normals)
        # About the middle, headings are averaged like numbers, also across the wrap.
        heading = values[0, 2]
        values[:, 2] = heading + wrap_angles(values[:, 2] - heading)
        return _SeaBedLines(values, usable.min(axis=1) >= 2)

    def _cut(self, cameras: _CameraPoses, normals: FloatArray) -> FloatArray:
        """Cut planes through the camera, (N, 3, 3): centreline, left, right, with the sea bed."""
        x, y, z = normals[:, 0].T
        centre = cameras.centres
        drop = self._settings.cable_height - centre[:, 2]
        safe = np.where(np.abs(y) > 1e-9, y, 1e-9)
        offsets = [
            centre[:, 1] - (x * (ahead - centre[:, 0]) + z * drop) / safe
            for ahead in (0.0, self._settings.look_ahead)
        ]
        heading = wrap_angles(_headings(normals))
        # The plane's distance from the vertical through the camera, and the drop to the axis.
        level = np.hypot(x, y)
        reach = np.abs(drop) / np.maximum(level, 1e-9)
        # Planes that touch a cable hold its direction. What turns them about the line of sight is
        # an error of the skew, which would make a thin cable thicker.
        towards = np.sign(np.einsum("ni,ni->n", normals[:, 1], normals[:, 2]))
        between = normals[:, 1] - towards[:, None] * normals[:, 2]
        along = np.cos(heading) * between[:, 0] + np.sin(heading) * between[:, 1]
        across = np.sqrt(np.maximum(np.sum(between**2, axis=1) - along**2, 0.0))
        return np.column_stack((*offsets, heading, reach * across))


def _joint_moments(
    estimate: CableEstimate, altitude: Altitude, attitude: Attitude
) -> tuple[FloatArray, FloatArray]:
    """Return mean (7,) and covariance (7, 7) of the cable's pose, altitude, roll and pitch."""
    pose = estimate.state.to_array()[:POSE_SIZE]
    mean = np.array([*pose, altitude.metres, attitude.roll, attitude.pitch])
    covariance = np.zeros((len(mean), len(mean)))
    covariance[:POSE_SIZE, :POSE_SIZE] = estimate.covariance[:POSE_SIZE, :POSE_SIZE]
    covariance[POSE_SIZE:, POSE_SIZE:] = np.diag(
        np.array([altitude.sigma, attitude.sigma, attitude.sigma]) ** 2
    )
    return mean, covariance


def _fault_of_lines(lines: _SeaBedLines) -> Withheld | None:
    """Say why lines, the first of which is the likeliest, are no cable beside the vehicle."""
    if not lines.below_horizon.all():
        return Withheld(
            Reason.HORIZON,
            "too little of the centreline is surely below the horizon; tilt the camera down",
        )
    headings = lines.values[:, 2]
    if not np.abs(wrap_angles(headings)).max() <= LARGEST_HEADING:
        return Withheld(
            Reason.ACROSS,
            f"it runs {math.degrees(headings[0]):.0f} deg across, surely or perhaps, so that it has"
            " no side",
        )
    return None


def _places_along(angle: float, segment: tuple[tuple[float, float], ...]) -> FloatArray:
    """Return where points stand along a line inside the image, from its foot point, (K,) [px]."""
    low, high = (-x * math.sin(angle) + y * math.cos(angle) for x, y in segment)
    return np.linspace(low, high, POINTS_PER_LINE)


@compiled
def _headings(normals: FloatArray) -> FloatArray:
    """Return the directions of the sea bed's cuts with planes of normals (N, 3, 3), (N,) [rad].

    Compiled because NumPy 1.26 rounds an arctan2 by where in memory its result lies.
    """
    headings = np.empty(len(normals))
    for n in range(len(normals)):
        headings[n] = math.atan2(-normals[n, 0, 0], normals[n, 0, 1])
    return headings


def _moments(
    rays: FloatArray, rotations: FloatArray, least_drop: float
) -> tuple[FloatArray, IndexArray]:
    """Return second moments of the rays of lines that surely go down, and how many rays they are.

    Parameters
    ----------
    rays : FloatArray
        Unit vectors of the optical frame, shape (N, L, K, 3); those with NaN do not count.
    rotations : FloatArray
        From the optical to the level frame, shape (N, 3, 3).
    least_drop : float
        How far a ray goes down at least [its length].

    Returns
    -------
    (FloatArray, IndexArray)
        Of rays in the level frame, shape (N, L, 3, 3), and (N, L).
    """
    level = rays @ np.swapaxes(rotations, 1, 2)[:, np.newaxis]
    goes_down = level[..., 2] < -least_drop
    usable = np.where(goes_down[..., np.newaxis], level, 0.0)
    return np.swapaxes(usable, -1, -2) @ usable, goes_down.sum(axis=-1)
