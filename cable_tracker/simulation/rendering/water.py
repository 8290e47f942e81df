"""Light and water: lamps on the vehicle, absorption, scattered light, marine snow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.simulation.rendering.appearance import Lamp, Water
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.tracking.image_frame import to_pixel
from cable_tracker.tracking.parameter_table import pixel_scale

REFERENCE_RANGE = 1.2
"""A lamp of strength 1 lights the bottom with 1 at this distance [m]."""

FLAKE_COUNT = 1500
"""Flakes in the box around the camera at full strength."""

FLAKE_BOX = 1.6
"""Side of the box of flakes that moves with the camera [m]; flakes that leave it come in again."""

NEAREST_FLAKE = 0.12
"""Flakes closer to the camera than this are not drawn [m]."""


def random_lamps(rng: np.random.Generator) -> tuple[Lamp, ...]:
    """Draw two lamps, one on each side of the camera."""
    lamps = []
    for side in (-1, 1):
        lamps.append(
            Lamp(
                place=(side * float(rng.uniform(0.15, 0.35)), float(rng.uniform(-0.1, 0.2)), 0.0),
                aim=(side * float(rng.uniform(-0.05, 0.15)), float(rng.uniform(-0.15, 0.2))),
                spread=float(rng.uniform(0.35, 0.5)),
                strength=float(rng.uniform(0.35, 0.6)),
            )
        )
    return tuple(lamps)


class Illumination:
    """The light that falls on the scene at each pixel, and that returns through the water.

    Parameters
    ----------
    rays : Image
        Line of sight of each pixel in the camera frame, float32, shape (3, H, W), z = -1.
    lamps : tuple of Lamp
        On the vehicle.
    water : Water
        In between.
    daylight : float
        Even light from above.

    Attributes
    ----------
    length : Image
        Length of each ray, float32, shape (H, W).
    """

    def __init__(self, rays: Image, lamps: tuple[Lamp, ...], water: Water, daylight: float) -> None:
        self._rays = rays
        self._lamps = lamps
        self._water = water
        self._daylight = np.float32(daylight)
        self.length: Image = np.sqrt(np.sum(rays * rays, axis=0))
        edge = self.length.max()
        self._vignette = (1 - 0.25 * ((self.length - 1) / (edge - 1))).astype(np.float32)
        self._glow = self._make_glow()

    def radiance(self, scene: Image, depth: Image) -> Image:
        """Return the light that reaches the camera, float32, shape (H, W), 1 at full scale.

        It is that of the scene, lit and attenuated, and what the water scatters back.

        Parameters
        ----------
        scene : Image
            Reflected share, float32, shape (H, W).
        depth : Image
            Distance along the camera's axis, float32, shape (H, W) [m].
        """
        distance = depth * self.length
        radiance = scene * self.irradiance(depth)
        radiance *= np.exp(distance * np.float32(-self._water.absorption))
        closed = 1 - np.exp(distance * np.float32(-self._water.scatter))
        radiance += closed * self._glow
        radiance *= self._vignette
        return np.asarray(radiance)

    def irradiance(self, depth: Image) -> Image:
        """Return the irradiance of points at a depth along each ray, float32, shape (H, W)."""
        light = np.full(depth.shape, self._daylight, dtype=np.float32)
        x, y = self._rays[0] * depth, self._rays[1] * depth
        for lamp in self._lamps:
            axis = _axis(lamp)
            u, v, back = (np.float32(value) for value in lamp.place)
            right, up, forward = x - u, y - v, depth + back
            square = right * right + up * up + forward * forward
            reach = np.sqrt(square)
            cosine = (right * axis[0] + up * axis[1] + forward * axis[2]) / reach
            beam = np.exp((cosine - 1) * np.float32(1 / (1 - np.cos(lamp.spread))))
            fall = np.float32(lamp.strength * REFERENCE_RANGE**2) / np.maximum(square, 0.04)
            light += beam * fall * np.exp(reach * np.float32(-self._water.absorption))
        return light

    def _make_glow(self) -> Image:
        """Return the brightness of endless water: brightest where the beams pass."""
        far = self.irradiance(
            np.full(self._rays.shape[1:], 1.3 * REFERENCE_RANGE, dtype=np.float32)
        )
        return np.asarray(np.float32(self._water.veil) * np.sqrt(far + np.float32(0.02)))


def _axis(lamp: Lamp) -> tuple[np.float32, np.float32, np.float32]:
    axis = np.array((np.tan(lamp.aim[0]), np.tan(lamp.aim[1]), 1.0))
    axis /= np.linalg.norm(axis)
    return np.float32(axis[0]), np.float32(axis[1]), np.float32(axis[2])


@dataclass(frozen=True, slots=True, eq=False)
class Snow:
    """Flakes suspended in the water.

    Attributes
    ----------
    places : FloatArray
        At time 0 in the world, shape (F, 3) [m]; they repeat with the side of the box.
    drift : FloatArray
        Shape (F, 3) [m/s].
    sizes : FloatArray
        Radii, shape (F,) [m].
    tones : FloatArray
        Reflected share, shape (F,).
    """

    places: FloatArray
    drift: FloatArray
    sizes: FloatArray
    tones: FloatArray

    @classmethod
    def random(cls, strength: float, rng: np.random.Generator) -> Snow:
        """Draw flakes that sink slowly in a common current."""
        count = round(FLAKE_COUNT * strength)
        current = np.append(rng.normal(0.0, 0.04, 2), -0.01)
        return cls(
            places=rng.uniform(0.0, FLAKE_BOX, (count, 3)),
            drift=current + rng.normal(0.0, 0.008, (count, 3)),
            sizes=0.0008 * (1 + rng.pareto(3.0, count)).clip(max=4.0),
            tones=rng.uniform(0.15, 0.5, count),
        )

    def layer(
        self, camera: Camera, position: FloatArray, rotation: FloatArray, time: float
    ) -> Image | None:
        """Draw the flakes of one instant, each as bright as in a light of 1; None without any.

        Parameters
        ----------
        position, rotation : FloatArray
            Pose of the camera: (3,) [m], and (3, 3).
        time : float
            [s].

        Returns
        -------
        Image or None
            Float32, shape (H, W).
        """
        if self.sizes.size == 0:
            return None
        half = FLAKE_BOX / 2
        places = np.mod(self.places + self.drift * time - position + half, FLAKE_BOX) - half
        in_camera = np.einsum("fi,ij->fj", places, rotation)
        above = places[:, 2] + position[2] > 0.02
        near = np.flatnonzero(above & (in_camera[:, 2] < -NEAREST_FLAKE))
        depth = -in_camera[near, 2]
        width, height = camera.image_size
        points = camera.project(in_camera[near])
        scale = pixel_scale(width)
        # What is near is out of focus: larger, and as much fainter.
        sharp = np.maximum(camera.focal * self.sizes[near] / depth, 0.35 * scale)
        radii = sharp + scale * 0.35 * np.maximum(1 / depth - 1.5, 0.0)
        tones = np.minimum(self.tones[near] / (0.35 + depth**2), 0.9) * (sharp / radii) ** 1.2
        layer = np.zeros((height, width), dtype=np.float32)
        columns, rows = to_pixel(points[:, 0], points[:, 1], camera.image_size)
        for column, row, radius, tone in zip(columns, rows, radii, tones, strict=True):
            if -20 < column < width + 20 and -20 < row < height + 20:
                _draw_flake(layer, float(column), float(row), float(radius), float(tone))
        return layer


def _draw_flake(layer: Image, column: float, row: float, radius: float, tone: float) -> None:
    """Add a soft spot of light."""
    reach = int(np.ceil(2.5 * radius)) + 1
    height, width = layer.shape
    left, right = max(int(column) - reach, 0), min(int(column) + reach + 1, width)
    top, bottom = max(int(row) - reach, 0), min(int(row) + reach + 1, height)
    if left >= right or top >= bottom:
        return
    x = np.arange(left, right) - column
    y = np.arange(top, bottom) - row
    spread = 2 * max(radius, 0.5) ** 2
    spot = np.exp(-(y * y) / spread)[:, None] * np.exp(-(x * x) / spread)[None, :]
    layer[top:bottom, left:right] += tone * spot
