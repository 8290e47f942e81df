"""Viewing rays of a calibrated camera's pixels.

Camera optical frame: z forward, x to the right of the image, y down (REP 103). Image frame of this
package: origin at the image centre, x right, y up, pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import MetricError
from cable_tracker.libraries import refusals_as
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.tracking.image_frame import image_to_pixel, pixel_to_image, to_image

UNDISTORTION_STEPS = 100
UNDISTORTION_PRECISION = 1e-12
"""Precision at which the iteration stops [of the normalised image plane]."""

LARGEST_RESIDUAL = 0.05
"""A ray that projects farther than this from its pixel was not found [px]."""

SAME_ASPECT = 0.01
"""Largest relative difference between the scales of calibration and image at which they have the
same aspect."""

LEAST_FOCAL, LARGEST_NUMBER = 0.1, 1e6
"""Smallest focal length [px] and largest number of a calibration. Beyond, as in a message that was
never filled in, squares and products are infinite."""


class DistortionModel(str, Enum):
    """How a lens bends straight lines; the names of sensor_msgs/CameraInfo."""

    PLUMB_BOB = "plumb_bob"
    RATIONAL_POLYNOMIAL = "rational_polynomial"
    EQUIDISTANT = "equidistant"


COEFFICIENT_COUNTS = {
    DistortionModel.PLUMB_BOB: (0, 4, 5),
    DistortionModel.RATIONAL_POLYNOMIAL: (0, 8),
    DistortionModel.EQUIDISTANT: (0, 4),
}
"""Allowed numbers of coefficients of each model; none at all is no distortion."""

MODEL_SYNONYMS = {"fisheye": "equidistant", "": "plumb_bob"}


@dataclass(frozen=True, slots=True)
class Calibration:
    """A calibration as it was read, not yet checked.

    Attributes
    ----------
    image_size : (int, int)
        Width and height of the images that it was made with [px].
    model : str
        Name of the distortion model, as in sensor_msgs/CameraInfo; "fisheye" is "equidistant".
    focal : (float, float)
        fx, fy [px].
    centre : (float, float)
        cx, cy: column and row of the principal point [px], the first pixel's centre being 0.
    coefficients : tuple of float
        plumb_bob: k1, k2, p1, p2[, k3]; rational_polynomial: k1, k2, p1, p2, k3 to k6; equidistant:
        k1 to k4.
    """

    image_size: tuple[int, int]
    model: str
    focal: tuple[float, float]
    centre: tuple[float, float]
    coefficients: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        # What calibrates a camera returns arrays, and only tuples can be compared and looked up.
        for name in ("image_size", "focal", "centre", "coefficients"):
            object.__setattr__(self, name, tuple(np.ravel(getattr(self, name)).tolist()))

    @classmethod
    def of_matrices(
        cls,
        image_size: tuple[int, int],
        model: str,
        camera_matrix: Sequence[float],
        coefficients: Sequence[float],
    ) -> Calibration:
        """Make one from a camera matrix of 9 numbers, row by row."""
        k = [float(value) for value in camera_matrix]
        return cls(
            image_size, model, (k[0], k[4]), (k[2], k[5]), tuple(float(c) for c in coefficients)
        )

    @classmethod
    def of_projection(
        cls, image_size: tuple[int, int], projection_matrix: Sequence[float]
    ) -> Calibration:
        """Make that of rectified images from a projection matrix of 12 numbers, row by row."""
        p = projection_matrix
        rows = (p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10])
        return cls.of_matrices(image_size, DistortionModel.PLUMB_BOB.value, rows, ())

    def cut(self, corner: tuple[int, int], size: tuple[int, int]) -> Calibration:
        """Return the calibration of a region of the image, by its first pixel and size [px]."""
        centre = (self.centre[0] - corner[0], self.centre[1] - corner[1])
        return Calibration(size, self.model, self.focal, centre, self.coefficients)

    def scaled_to(self, size: tuple[int, int]) -> Calibration:
        """Return the calibration of the same image in another resolution [px].

        The outer edges of the image stay where they are, not the centres of its first pixels.
        """
        x, y = size[0] / self.image_size[0], size[1] / self.image_size[1]
        centre = ((self.centre[0] + 0.5) * x - 0.5, (self.centre[1] + 0.5) * y - 0.5)
        focal = (self.focal[0] * x, self.focal[1] * y)
        return Calibration(size, self.model, focal, centre, self.coefficients)


@dataclass(frozen=True, slots=True)
class CameraModel:
    """A camera with a calibration that fits its images. Made by `camera_for`.

    Attributes
    ----------
    calibration : Calibration
        Calibration for images of this size, which has been checked.
    """

    calibration: Calibration

    @property
    def image_size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self.calibration.image_size

    @property
    def model(self) -> DistortionModel:
        """Distortion model of the lens."""
        return _model_of(self.calibration.model)

    @property
    def is_bent(self) -> bool:
        """Whether straight lines are seen bent.

        A fisheye whose coefficients are all zero bends them: radii in its pictures are in
        proportion to the angle from the axis. One without coefficients is a pinhole.
        """
        coefficients = self.calibration.coefficients
        if self.model is DistortionModel.EQUIDISTANT:
            return bool(coefficients)
        return any(coefficients)

    @property
    def matrix(self) -> FloatArray:
        """The camera matrix, shape (3, 3) [px]."""
        (fx, fy), (cx, cy) = self.calibration.focal, self.calibration.centre
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    @property
    def image_matrix(self) -> FloatArray:
        """Matrix from optical frame to image frame, without distortion, shape (3, 3) [px]."""
        (fx, fy), (x, y) = (
            self.calibration.focal, to_image(*self.calibration.centre, self.image_size),
        )  # fmt: skip
        return np.array([[fx, 0.0, x], [0.0, -fy, y], [0.0, 0.0, 1.0]])

    def rays(self, points: FloatArray) -> FloatArray:
        """Return the lines of sight of points of the image frame.

        Parameters
        ----------
        points : FloatArray
            x, y [px], shape (..., 2).

        Returns
        -------
        FloatArray
            Unit vectors in the camera optical frame, shape (..., 3); NaN where the distortion has
            no inverse.

        Raises
        ------
        MetricError
            OpenCV refuses the calibration.
        """
        pixels = image_to_pixel(points, self.image_size).reshape(-1, 2)
        plane = (pixels - self.calibration.centre) / self.calibration.focal
        if not self.is_bent:
            directions = np.column_stack((plane, np.ones(len(plane))))
        elif self.model is DistortionModel.EQUIDISTANT:
            directions = _fisheye_directions(plane, self.calibration.coefficients)
        else:
            directions = self._straightened(pixels)
        rays = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
        if self.is_bent:
            offsets = np.abs(self._pixels(rays) - pixels).max(axis=-1)
            # Written so that NaN counts as not found.
            rays[~(offsets <= LARGEST_RESIDUAL)] = np.nan
        return np.asarray(rays.reshape(*points.shape[:-1], 3))

    def project(self, directions: FloatArray) -> FloatArray:
        """Return where directions of the optical frame (..., 3) are seen, (..., 2) [px].

        In the image frame. NaN behind the camera.
        """
        points = pixel_to_image(self._pixels(directions.reshape(-1, 3)), self.image_size)
        return np.asarray(points.reshape(*directions.shape[:-1], 2))

    def _straightened(self, pixels: FloatArray) -> FloatArray:
        criteria = (
            cv2.TERM_CRITERIA_MAX_ITER + cv2.TERM_CRITERIA_EPS,
            UNDISTORTION_STEPS,
            UNDISTORTION_PRECISION,
        )
        straight = _undistorted(pixels.reshape(-1, 1, 2), self.matrix, self._lens(), criteria)
        return np.column_stack((straight.reshape(-1, 2), np.ones(len(straight))))

    def _lens(self) -> FloatArray:
        return np.array(self.calibration.coefficients, dtype=np.float64)

    def _pixels(self, directions: FloatArray) -> FloatArray:
        """Return column and row where directions (N, 3) are seen, shape (N, 2)."""
        if self.model is DistortionModel.EQUIDISTANT and self.is_bent:
            plane = _fisheye_plane(directions, self.calibration.coefficients)
            return np.asarray(plane * self.calibration.focal + self.calibration.centre)
        ahead = np.where(directions[:, 2:] > 0.0, directions, [0.0, 0.0, 1.0])
        lens = self._lens() if self.is_bent else np.zeros(5)
        with refusals_as(MetricError, "no pixels can be computed with this calibration"):
            pixels, _ = cv2.projectPoints(
                ahead.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), self.matrix, lens
            )
        return np.where(directions[:, 2:] > 0.0, pixels.reshape(-1, 2), np.nan)


def _undistorted(
    pixels: FloatArray, matrix: FloatArray, lens: FloatArray, criteria: tuple[int, int, float]
) -> FloatArray:
    """Return points of the normalised image plane (N, 1, 2) for distorted pixels (N, 1, 2).

    OpenCV 4 takes the criteria of the iteration in a function of its own, which OpenCV 5 has not.
    """
    with refusals_as(MetricError, "the distortion of this calibration cannot be undone"):
        if hasattr(cv2, "undistortPointsIter"):
            straight = cv2.undistortPointsIter(pixels, matrix, lens, np.eye(3), np.eye(3), criteria)
        else:
            straight = cv2.undistortPoints(pixels, matrix, lens, criteria=criteria)
        return np.asarray(straight)


def _fisheye_plane(directions: FloatArray, coefficients: Sequence[float]) -> FloatArray:
    """Return the distorted plane (N, 2) of directions (N, 3), up to any angle from the axis."""
    aside = np.hypot(directions[:, 0], directions[:, 1])
    angle = np.arctan2(aside, directions[:, 2])
    factor = _fisheye_radius(angle, coefficients) / np.where(aside > 0.0, aside, 1.0)
    return directions[:, :2] * factor[:, None]


def _fisheye_radius(angle: FloatArray, coefficients: Sequence[float]) -> FloatArray:
    k1, k2, k3, k4 = coefficients
    square = angle**2
    return np.asarray(angle * (1 + square * (k1 + square * (k2 + square * (k3 + square * k4)))))


def _fisheye_directions(plane: FloatArray, coefficients: Sequence[float]) -> FloatArray:
    """Return directions (N, 3) of points of the distorted plane (N, 2), by Newton's method."""
    k1, k2, k3, k4 = coefficients
    radius = np.hypot(plane[:, 0], plane[:, 1])
    angle = np.minimum(radius, np.pi)
    for _ in range(UNDISTORTION_STEPS // 4):
        square = angle**2
        slope = 1 + square * (3 * k1 + square * (5 * k2 + square * (7 * k3 + square * 9 * k4)))
        # A slope of zero is where the picture folds; the check of the residual finds it.
        step = (_fisheye_radius(angle, coefficients) - radius) / np.where(slope > 0, slope, np.inf)
        angle = np.clip(angle - step, 0.0, np.pi)
    aside = plane / np.where(radius > 0.0, radius, 1.0)[:, None]
    return np.column_stack((aside * np.sin(angle)[:, None], np.cos(angle)))


@lru_cache(maxsize=8)
def camera_for(
    calibration: Calibration | None, image_size: tuple[int, int]
) -> CameraModel | Withheld:
    """Return the camera that images of a size come from, or why there is none.

    A calibration of another size is scaled if the aspect is the same. Otherwise the image may have
    been cropped at an unknown place.
    """
    if calibration is None:
        return Withheld(
            Reason.NO_CALIBRATION, "no camera_info has come; publish one beside the images"
        )
    fault = _fault_of(calibration)
    if fault:
        return Withheld(Reason.BAD_CALIBRATION, fault)
    (width, height), (own_width, own_height) = image_size, calibration.image_size
    if abs(width * own_height / (height * own_width) - 1.0) > SAME_ASPECT:
        return Withheld(
            Reason.OTHER_IMAGE_SIZE,
            f"the calibration is for {own_width}x{own_height} px, the image has {width}x{height} px"
            " and another aspect; calibrate the camera as it is used",
        )
    return CameraModel(calibration.scaled_to(image_size))


def _model_of(name: str) -> DistortionModel:
    return DistortionModel(MODEL_SYNONYMS.get(name, name))


def _fault_of(calibration: Calibration) -> str:
    """Return the fault of a calibration in words; empty if it has none."""
    numbers = (*calibration.focal, *calibration.centre, *calibration.coefficients)
    # Written so that NaN counts as too large.
    if not (np.abs(numbers) <= LARGEST_NUMBER).all():
        return "it has numbers that are not finite, or as good as infinite; calibrate the camera"
    if min(calibration.image_size) < 1:
        return "it says no image size; calibrate the camera"
    if min(calibration.focal) < LEAST_FOCAL:
        return f"its focal length is below {LEAST_FOCAL:g} px; calibrate the camera"
    try:
        model = _model_of(calibration.model)
    except ValueError:
        known = ", ".join(model.value for model in DistortionModel)
        return f"its distortion model {calibration.model!r} is none of {known}"
    counts = COEFFICIENT_COUNTS[model]
    if len(calibration.coefficients) not in counts:
        wanted = " or ".join(str(count) for count in counts)
        return (
            f"{model.value} has {wanted} distortion coefficients, not"
            f" {len(calibration.coefficients)}"
        )
    return ""
