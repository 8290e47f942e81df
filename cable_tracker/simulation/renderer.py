"""Pictures of a cable on the sea bed, seen by a camera in turbid water above it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.geometry import project_borders
from cable_tracker.cable.state import CableState
from cable_tracker.simulation.clutter import Streak, streak_cover
from cable_tracker.simulation.seabed import CABLE_REACH, CHANNELS, make_bed, make_cable
from cable_tracker.simulation.texture import TiledTexture
from cable_tracker.simulation.trajectory import REFERENCE_WIDTH

FLAKES = 90
"""Flakes of marine snow in the water below the camera at full clutter, whatever the image size."""

TYPICAL_RADIUS = 18.0
"""Radius of the cable that the flakes' speed goes by [px at the reference width]."""

SPREAD = 1.3
"""The flakes drift through a field this much larger than the image."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Where each pixel of one frame looks, all float32 of shape (H, W).

    Attributes
    ----------
    p, q : Image
        World coordinates across and along the cable [radii], q without the way travelled.
    footprint : Image
        Extent of a pixel on the bottom [radii].
    inside : Image
        How much of the pixel lies between the two borders, 0 to 1.
    """

    p: Image
    q: Image
    footprint: Image
    inside: Image


@dataclass(frozen=True, slots=True, eq=False)
class Snow:
    """Flakes suspended in the water.

    Attributes
    ----------
    places : FloatArray
        Column and row at rest, shape (F, 2) [shares of the image size].
    nearness : FloatArray
        How many times faster than the bottom a flake passes, shape (F,).
    radii : FloatArray
        Shape (F,) [px at the reference width].
    tones : FloatArray
        Added light, shape (F,), 0 to 1.
    """

    places: FloatArray
    nearness: FloatArray
    radii: FloatArray
    tones: FloatArray

    @classmethod
    def random(cls, count: int, rng: np.random.Generator) -> Snow:
        """Draw flakes; those near the camera are large, faint and fast."""
        nearness = 1 + rng.gamma(1.5, 0.5, count)
        radii = 0.45 * nearness**1.3 * rng.uniform(0.7, 1.3, count)
        tones = np.clip(rng.uniform(0.15, 0.5, count) / nearness, 0.05, 0.45)
        return cls(rng.random((count, 2)), nearness, radii, tones)


class SeabedRenderer:
    """Renders frames of one dive.

    Parameters
    ----------
    image_size : (int, int)
        Width and height of the frames [px].
    clutter : float
        0 (clean cable in clear water) to 1 (half hidden in turbid water).
    noise : float
        Standard deviation of the sensor's noise [grey levels].
    streaks : tuple of Streak
        Ropes and furrows along the way.
    rng : numpy.random.Generator
        Draws textures and lamps once, and then the noise of frame after frame.
    """

    def __init__(
        self,
        image_size: tuple[int, int],
        clutter: float,
        noise: float,
        streaks: tuple[Streak, ...],
        rng: np.random.Generator,
    ) -> None:
        width, height = image_size
        self._image_size = image_size
        self._clutter = clutter
        self._noise = noise
        self._streaks = streaks
        self._rng = rng
        self._scale = width / REFERENCE_WIDTH
        resolution = int(np.clip(round(5 * self._scale), 2, 10)) * 4
        self._bed: TiledTexture = make_bed(resolution, rng)
        self._cable: TiledTexture = make_cable(resolution, clutter, rng)
        self._snow = Snow.random(round(FLAKES * clutter), rng)
        columns = np.arange(width, dtype=np.float32) - np.float32((width - 1) / 2)
        rows = np.float32((height - 1) / 2) - np.arange(height, dtype=np.float32)
        self._x, self._y = columns[None, :], rows[:, None]
        self._lamps = self._make_lamps(rng)

    def render(self, state: CableState, travel: float) -> Image:
        """Render the next frame.

        Parameters
        ----------
        state : CableState
            Where the cable runs [px, rad].
        travel : float
            How far the vehicle has come along the cable [radii of the cable].

        Returns
        -------
        Image
            Grey, uint8, shape (H, W).
        """
        view = self._look(state)
        scene = self._ground(view, travel)
        scene = self._lay_cable(scene, view, travel)
        scene = self._lay_streaks(scene, view, travel, on_top=True)
        light = self._through_water(scene)
        self._add_snow(light, state, travel)
        return self._expose(light)

    def _look(self, state: CableState) -> View:
        cos, sin = np.float32(np.cos(state.angle)), np.float32(np.sin(state.angle))
        across = self._x * cos + self._y * sin - np.float32(state.distance)
        along = self._y * cos - self._x * sin
        half = np.float32(state.width / 2)
        # The borders converge to a vanishing point, and so does everything parallel to them on
        # the bottom. The limit only keeps pixels near the horizon finite.
        radius = np.maximum(half - along * np.float32(np.tan(state.skew)), np.float32(0.04) * half)
        borders = project_borders(state.to_array()[None, :])
        (left, right), (rho_left, rho_right) = borders.angles[0], borders.offsets[0]
        from_left = self._signed_distance(left, rho_left)
        from_right = -self._signed_distance(right, rho_right)
        inside = np.clip(from_left + 0.5, 0, 1) * np.clip(from_right + 0.5, 0, 1)
        footprint = np.sqrt(half / radius) / radius
        return View(across / radius, along / radius, footprint, inside)

    def _signed_distance(self, angle: float, offset: float) -> Image:
        cos, sin = np.float32(np.cos(angle)), np.float32(np.sin(angle))
        distance: Image = self._x * cos + self._y * sin - np.float32(offset)
        return distance

    def _ground(self, view: View, travel: float) -> Image:
        ground = self._bed.sample(view.p, view.q, travel, view.footprint)
        return self._lay_streaks(ground, view, travel, on_top=False)

    def _lay_cable(self, ground: Image, view: View, travel: float) -> Image:
        texels = self._cable.sample(view.p, view.q, travel, view.footprint)
        beyond = np.abs(view.p) >= CABLE_REACH
        texels[beyond] = 0.0
        bare = 1 - texels[..., CHANNELS.burial]
        side = np.clip(np.abs(view.p) - 1, 0, None)
        lee = np.clip(view.p - 1, 0, None) + 9 * (view.p < 1)
        shadow = 0.4 * np.exp(-side / np.float32(0.3)) + 0.25 * np.exp(-lee / np.float32(0.9))
        shaded = ground * (1 - bare * shadow)
        roundness = np.sqrt(np.clip(1 - view.p * view.p, 0, 1))
        skin = texels[..., CHANNELS.surface] * (0.68 + 0.32 * roundness) * (1 - 0.08 * view.p)
        cover = view.inside * bare
        scene = shaded + (skin - shaded) * cover
        growth = texels[..., CHANNELS.growth]
        scene += (texels[..., CHANNELS.growth_tone] - scene) * growth
        return np.asarray(scene)

    def _lay_streaks(self, scene: Image, view: View, travel: float, *, on_top: bool) -> Image:
        for streak in self._streaks:
            if streak.on_top == on_top:
                cover = streak_cover(streak, view.p, view.q, travel, view.footprint)
                if cover is not None:
                    scene = scene + (np.float32(streak.tone) - scene) * cover
        return scene

    def _make_lamps(self, rng: np.random.Generator) -> Image:
        """Return the light that falls on each pixel: two pools of light, dark corners."""
        width, height = self._image_size
        reach = np.hypot(width, height) / 2
        x, y = self._x / reach, self._y / reach
        light = np.full((height, width), 0.42, dtype=np.float32)
        for side in (-1, 1):
            centre_x = side * rng.uniform(0.15, 0.4)
            centre_y = rng.uniform(-0.25, 0.35)
            spread = rng.uniform(0.45, 0.65)
            strength = rng.uniform(0.35, 0.6)
            square = (x - centre_x) ** 2 + (y - centre_y) ** 2
            light += strength * np.exp(-square / (2 * spread**2))
        vignette = 1 - 0.3 * (x * x + y * y)
        return np.asarray(light * vignette, dtype=np.float32)

    def _through_water(self, scene: Image) -> Image:
        """Dim and veil the scene as turbid water does, and blur it."""
        haze = 0.12 + 0.38 * self._clutter
        veil = 0.27 * np.sqrt(self._lamps)
        light = (1 - haze) * scene * self._lamps + haze * veil
        sigma = (0.6 + 0.5 * self._clutter) * max(self._scale, 0.5)
        return cv2.GaussianBlur(light, (0, 0), sigma)

    def _add_snow(self, light: Image, state: CableState, travel: float) -> None:
        """Draw the flakes; they pass faster than the bottom, and come round again."""
        if self._snow.radii.size == 0:
            return
        size = np.array(self._image_size, dtype=np.float64)
        forward = travel * TYPICAL_RADIUS * self._scale * self._snow.nearness
        sideways = np.full_like(forward, state.distance)
        drift = np.stack((sideways, forward), axis=1) / size
        share = np.mod(self._snow.places + drift / SPREAD, 1.0)
        centres = (share - 0.5) * SPREAD * size + (size - 1) / 2
        layer = np.zeros(light.shape, dtype=np.float32)
        for centre, radius, tone in zip(
            centres, self._snow.radii * self._scale, self._snow.tones, strict=True
        ):
            _draw_flake(layer, centre, radius, tone)
        light += layer * self._lamps

    def _expose(self, light: Image) -> Image:
        grey = 255.0 * light
        if self._noise > 0:
            grey += np.float32(self._noise) * self._rng.standard_normal(
                light.shape, dtype=np.float32
            )
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def _draw_flake(layer: Image, centre: FloatArray, radius: float, tone: float) -> None:
    """Add a soft spot of light."""
    reach = int(np.ceil(2.5 * radius)) + 1
    height, width = layer.shape
    column, row = int(centre[0]), int(centre[1])
    left, right = max(column - reach, 0), min(column + reach + 1, width)
    top, bottom = max(row - reach, 0), min(row + reach + 1, height)
    if left >= right or top >= bottom:
        return
    x = np.arange(left, right) - centre[0]
    y = np.arange(top, bottom) - centre[1]
    spread = 2 * max(radius, 0.5) ** 2
    spot = np.exp(-(y * y) / spread)[:, None] * np.exp(-(x * x) / spread)[None, :]
    layer[top:bottom, left:right] += tone * spot
