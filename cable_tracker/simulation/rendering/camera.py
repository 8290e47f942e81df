"""A pinhole camera carried by a vehicle above a flat sea bed.

World frame of the renderer: x across to the right and y along the general course of the cable, z
up, metres; the bottom is z = 0. A vehicle at rest looks along y, and a camera that looks straight
down then has its image axes x and y parallel to those of the world.

World frame of the vehicle, see `vehicle`: x along the course and y to its left, a quarter turn
about the vertical. From one to the other axes are exchanged and signs changed, so that nothing is
rounded.

Camera frame: x to the right of the image, y up, z backwards, so that it looks along -z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.tracking.image_frame import to_image

NEAREST = 0.02
"""Nothing closer to the camera's plane than this is projected [m]."""

FARTHEST_ANGLE = 1.6
"""Points are projected up to this many half diagonals from the centre; distortion folds beyond."""

UNDISTORTION_STEPS = 30
"""Distortion is inverted by this many corrections."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraPoses:
    """Poses of a camera at N instants.

    Attributes
    ----------
    positions : FloatArray
        Positions in the world, shape (N, 3) [m].
    rotations : FloatArray
        Rotations from the camera frame to the world frame, shape (N, 3, 3).
    """

    positions: FloatArray
    rotations: FloatArray

    def to_camera(self, points: FloatArray) -> FloatArray:
        """Turn world points (N, ..., 3) into the camera frame of each instant."""
        shape = (-1,) + (1,) * (points.ndim - 2) + (3,)
        relative = points - self.positions.reshape(shape)
        in_camera: FloatArray = np.einsum("n...i,nij->n...j", relative, self.rotations)
        return in_camera


Distortion = tuple[float, float, float, float, float]
"""k1, k2, p1, p2, k3 of the distortion model "plumb_bob", with y down as everywhere else."""

NO_DISTORTION: Distortion = (0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera and how it is mounted.

    Attributes
    ----------
    image_size : (int, int)
        Width and height [px].
    focal : float
        Focal length [px].
    mounting : float
        Forward tilt of the camera: 0 straight down, pi/2 straight ahead [rad].
    distortion : Distortion
        Distortion of the lens.
    """

    image_size: tuple[int, int]
    focal: float
    mounting: float = 0.0
    distortion: Distortion = NO_DISTORTION

    @property
    def is_distorted(self) -> bool:
        """Whether the lens has a distortion."""
        return any(self.distortion)

    def sees_all_pixels(self) -> bool:
        """Return whether each pixel's line of sight is projected to that pixel again, to 0.01 px.

        Too strong a distortion folds the picture, so that no ray leads to some pixels.
        """
        if not self.is_distorted:
            return True
        with np.errstate(all="ignore"):
            found = self.project(np.moveaxis(self.rays().astype(np.float64), 0, -1))
        return bool((np.abs(found - self._pixels()) < 0.01).all())

    def poses(self, positions: FloatArray, angles: FloatArray) -> CameraPoses:
        """Return the poses of the camera on a vehicle at N instants.

        Parameters
        ----------
        positions : FloatArray
            Of the camera in the world, shape (N, 3) [m].
        angles : FloatArray
            Roll, pitch, yaw of the vehicle as REP 103 has them, yaw from the world's y, shape
            (N, 3) [rad].
        """
        roll, pitch, yaw = angles.T
        mounting = rotation_about(0, np.full_like(yaw, self.mounting))
        turned = chain(rotation_about(2, yaw), rotation_about(0, -pitch), rotation_about(1, roll))
        return CameraPoses(positions, chain(turned, mounting))

    def vehicle_angles(self, poses: CameraPoses) -> FloatArray:
        """Return the angles of the vehicle that carries the camera, (N, 3); see `poses`."""
        count = poses.positions.shape[0]
        body = chain(poses.rotations, rotation_about(0, np.full(count, -self.mounting)))
        pitch = -np.arcsin(np.clip(body[:, 2, 1], -1.0, 1.0))
        yaw = np.arctan2(-body[:, 0, 1], body[:, 1, 1])
        roll = np.arctan2(-body[:, 2, 0], body[:, 2, 2])
        return np.stack((roll, pitch, yaw), axis=1)

    def project(self, points: FloatArray) -> FloatArray:
        """Project points of the camera frame.

        Parameters
        ----------
        points : FloatArray
            Shape (..., 3) [m].

        Returns
        -------
        FloatArray
            x, y in the image frame [px], shape (..., 2); NaN for points behind the camera or so far
            aside that the distortion has no meaning there.
        """
        depth = -points[..., 2]
        usable = depth > NEAREST
        safe = np.where(usable, depth, 1.0)
        plane = np.stack((points[..., 0] / safe, points[..., 1] / safe), axis=-1)
        if self.is_distorted:
            limit = FARTHEST_ANGLE * np.hypot(*self.image_size) / 2 / self.focal
            usable &= np.hypot(plane[..., 0], plane[..., 1]) < limit
            plane = self._distort(plane)
        return np.where(usable[..., None], plane * self.focal, np.nan)

    def rays(self) -> Image:
        """Return the direction of each pixel's line of sight in the camera frame.

        Returns
        -------
        Image
            Float32, shape (3, H, W), with z = -1.
        """
        width, height = self.image_size
        plane = self._pixels() / self.focal
        if self.is_distorted:
            plane = self._undistort(plane)
        directions = (plane[..., 0], plane[..., 1], -np.ones((height, width)))
        return np.stack(directions).astype(np.float32)

    def _pixels(self) -> FloatArray:
        """Return the pixels' coordinates in the image frame, shape (H, W, 2) [px]."""
        width, height = self.image_size
        x, y = to_image(
            np.arange(width, dtype=np.float64),
            np.arange(height, dtype=np.float64),
            self.image_size,
        )
        return np.stack(np.meshgrid(x, y), axis=-1)

    def _distort(self, plane: FloatArray) -> FloatArray:
        k1, k2, p1, p2, k3 = self.distortion
        x, y = plane[..., 0], -plane[..., 1]
        square = x * x + y * y
        radial = 1 + square * (k1 + square * (k2 + square * k3))
        bent_x = x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x)
        bent_y = y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y
        return np.stack((bent_x, -bent_y), axis=-1)

    def _undistort(self, plane: FloatArray) -> FloatArray:
        straight = plane
        for _ in range(UNDISTORTION_STEPS):
            straight = straight + (plane - self._distort(straight))
        return straight


def rotation_about(axis: int, angles: FloatArray) -> FloatArray:
    """Return the right-handed rotations about a coordinate axis, shape (N, 3, 3)."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    rotations = np.zeros((angles.size, 3, 3))
    rotations[:, axis, axis] = 1.0
    rotations[:, first, first] = rotations[:, second, second] = np.cos(angles)
    rotations[:, second, first] = np.sin(angles)
    rotations[:, first, second] = -np.sin(angles)
    return rotations


def chain(first: FloatArray, *others: FloatArray) -> FloatArray:
    """Multiply N matrices each, shape (N, 3, 3), by sums in a fixed order.

    Products by a threaded library may come out differently on another machine.
    """
    product = first
    for other in others:
        product = np.einsum("nij,njk->nik", product, other)
    return product


def from_renderer(vectors: FloatArray) -> FloatArray:
    """Return vectors of the renderer's world in the vehicle's, shape (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((y, -x, z), axis=-1)


def to_renderer(vectors: FloatArray) -> FloatArray:
    """Return vectors of the vehicle's world in the renderer's, shape (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((-y, x, z), axis=-1)
