"""Renders the sea bed and the cables on it as a camera in turbid water sees them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image, eight_bits
from cable_tracker.sequences.pictures.encoded_pictures import after_jpeg
from cable_tracker.simulation.rendering.appearance import SceneAppearance
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.rendering.clutter import Streak, draw_streak, streak_cover
from cable_tracker.simulation.rendering.laid_cable import CableSkin, ClosestApproach, LaidCable
from cable_tracker.simulation.rendering.seabed import BED_UNIT, CABLE_REACH
from cable_tracker.simulation.rendering.texture import TiledTexture, in_rows
from cable_tracker.simulation.rendering.water import Illumination, Snow, random_lamps
from cable_tracker.tracking.parameter_table import pixel_scale

LEAST_SLOPE = 0.03
"""Lines of sight that go down less steeply, or up, end at the horizon."""

FARTHEST = 30.0
"""Largest visible distance along the camera's axis [m]."""

CELL = 8
"""Cell of the grid on which the region near a cable is determined [px]."""

ROW = 1024
"""Pixels near a cable are gathered into rows of this length."""

MEAN_TONE = 0.3
"""Mean grey that the camera's exposure aims at, 0 to 1."""

TURF_RELIEF = 0.35
"""Strength of light and shade on the slopes of turf on a cable."""

TURF_SLOPE = 1.2
"""Decay of those slopes away from the cable's axis [radii²]."""

EXPOSURE_LIMITS = (0.4, 1.8)
"""Smallest and largest gain of the exposure."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Bottom, cables and clutter.

    Attributes
    ----------
    bed : TiledTexture
        The bottom.
    cables : tuple of LaidCable
        Cables from the lowest to the topmost.
    streaks : tuple of Streak
        Ropes, furrows, tracks.
    streak_unit : float
        Unit of their places [m].
    """

    bed: TiledTexture
    cables: tuple[LaidCable, ...]
    streaks: tuple[Streak, ...]
    streak_unit: float


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """Viewing geometry of each pixel of a frame, float32 (H, W); `rays` is (3, H, W).

    `x`, `y` are places on the bottom, relative to below the eye [m]; `footprint` is the extent of a
    pixel there [m] and `depth` the distance along the camera's axis [m].
    """

    eye: FloatArray
    rays: Image
    x: Image
    y: Image
    depth: Image
    footprint: Image


class SceneRenderer:
    """Renders the frames of one dive, one after the other.

    Parameters
    ----------
    appearance : SceneAppearance
        Water, light, and the camera's faults.
    rng : numpy.random.Generator
        Draws lamps and flakes once, and then the noise of frame after frame.
    """

    def __init__(
        self, camera: Camera, scene: Scene, appearance: SceneAppearance, rng: np.random.Generator
    ) -> None:
        self._camera = camera
        self._scene = scene
        self._appearance = appearance
        self._rng = rng
        self._rays = camera.rays()
        lamps = random_lamps(rng) if appearance.lamps is None else appearance.lamps
        self._light = Illumination(self._rays, lamps, appearance.water, appearance.daylight)
        self._snow = Snow.random(appearance.water.flakes, rng)

    def render(self, position: FloatArray, rotation: FloatArray, time: float) -> Image:
        """Render the next frame.

        Parameters
        ----------
        position, rotation : FloatArray
            Pose of the camera in the world: (3,) [m], and (3, 3).
        time : float
            [s], for what moves by itself.

        Returns
        -------
        Image
            Grey, uint8, shape (H, W).
        """
        view = self._viewing_geometry(position, rotation)
        scene = self._ground(view)
        for cable in self._scene.cables:
            self._lay_cable(scene, view, cable)
        scene = self._lay_streaks(scene, view, on_top=True)
        light = self._light.radiance(scene, view.depth)
        flakes = self._snow.layer(self._camera, position, rotation, time)
        if flakes is not None:
            light += flakes * self._light.irradiance(np.full_like(view.depth, 1.0))
        return self._expose(light)

    def hidden(
        self, cable: LaidCable, position: FloatArray, world: FloatArray, usable: BoolArray
    ) -> BoolArray:
        """Return which points of a cable's borders are covered, shape (2, K).

        Parameters
        ----------
        cable : LaidCable
            One of the scene's.
        position : FloatArray
            Position of the camera, shape (3,) [m].
        world : FloatArray
            Points of the two borders in the world, (2, K, 3) [m].
        usable : BoolArray
            Points to check, shape (2, K); the others count as hidden.
        """
        hidden = np.ones(usable.shape, dtype=np.bool_)
        if not usable.any():
            return hidden
        rays = np.ascontiguousarray((world[usable] - position).T, dtype=np.float32)[:, None]
        fine = np.full(rays.shape[1:], 1e-3, dtype=np.float32)
        skin = cable.skin(cable.tube.closest_approach(position, rays), fine)
        covered = skin.is_covered()
        for other in self._scene.cables[self._scene.cables.index(cable) + 1 :]:
            approach = other.tube.closest_approach(position, rays)
            covered |= (np.abs(approach.p) < 1) & (other.skin(approach, fine).burial < 0.5)
        reach = np.float32(-position[2]) / rays[2]
        p, q = self._streak_places(reach * rays[0], reach * rays[1], position)
        for streak in self._scene.streaks:
            if streak.on_top:
                start = float(position[1]) / self._scene.streak_unit
                cover = streak_cover(streak, p, q, start, fine)
                covered |= False if cover is None else cover > 0.5
        hidden[usable] = covered[0]
        return hidden

    def _viewing_geometry(self, position: FloatArray, rotation: FloatArray) -> _View:
        x, y, z = self._rays
        rays = np.stack(
            [row[0] * x + row[1] * y + row[2] * z for row in rotation.astype(np.float32)]
        )
        np.minimum(rays[2], np.float32(-LEAST_SLOPE), out=rays[2])
        down = -rays[2]
        depth = np.minimum(np.float32(position[2]) / down, np.float32(FARTHEST))
        stretch = np.sqrt(self._light.length / down)
        footprint = depth * stretch * np.float32(1 / self._camera.focal)
        return _View(position, rays, depth * rays[0], depth * rays[1], depth, footprint)

    def _ground(self, view: _View) -> Image:
        unit = np.float32(1 / BED_UNIT)
        across = (view.x + np.float32(view.eye[0])) * unit
        ground = self._scene.bed.sample(
            across, view.y * unit, float(view.eye[1]) / BED_UNIT, view.footprint * unit
        )
        return self._lay_streaks(ground, view, on_top=False)

    def _lay_streaks(self, scene: Image, view: _View, *, on_top: bool) -> Image:
        streaks = [streak for streak in self._scene.streaks if streak.on_top == on_top]
        if not streaks:
            return scene
        p, q = self._streak_places(view.x, view.y, view.eye)
        footprint = view.footprint * np.float32(1 / self._scene.streak_unit)
        start = float(view.eye[1]) / self._scene.streak_unit
        for streak in streaks:
            scene = draw_streak(scene, streak, p, q, start, footprint=footprint)
        return scene

    def _streak_places(self, x: Image, y: Image, eye: FloatArray) -> tuple[Image, Image]:
        unit = np.float32(1 / self._scene.streak_unit)
        return (x + np.float32(eye[0])) * unit, y * unit

    def _lay_cable(self, scene: Image, view: _View, cable: LaidCable) -> None:
        """Draw a cable and its shadow into the scene."""
        near = self._near(view, cable)
        if near.size == 0:
            return
        rays = view.rays.reshape(3, -1)[:, near]
        approach = cable.tube.closest_approach(view.eye, rays)
        pixel = approach.distance * np.float32(1 / (self._camera.focal * cable.tube.radius))
        pixel /= self._light.length.reshape(-1)[near]
        skin = cable.skin(approach, pixel)
        flat = scene.reshape(-1)
        flat[near] = _blend_cable(flat[near], approach, skin, pixel)

    def _near(self, view: _View, cable: LaidCable) -> Image:
        """Return the flat indices of the pixels that may show the cable, see `in_rows`."""
        height, width = view.depth.shape
        coarse = view.rays[:, ::CELL, ::CELL]
        p = np.abs(cable.tube.closest_approach(view.eye, np.ascontiguousarray(coarse)).p)
        step = np.zeros_like(p)
        step[:, 1:] = np.abs(np.diff(p, axis=1))
        step[1:] = np.maximum(step[1:], np.abs(np.diff(p, axis=0)))
        step = cv2.dilate(step, np.ones((3, 3), np.uint8))
        near = (p < CABLE_REACH + 0.5 + 2 * step).astype(np.uint8)
        cells = cv2.dilate(near, np.ones((3, 3), np.uint8))
        pixels = np.repeat(np.repeat(cells, CELL, axis=0), CELL, axis=1)[:height, :width]
        found = np.flatnonzero(pixels)
        return in_rows(found, ROW) if found.size else found

    def _expose(self, light: Image) -> Image:
        scale = pixel_scale(self._camera.image_size[0])
        sigma = self._appearance.water.blur * max(scale, 0.5)
        light = cv2.GaussianBlur(light, (0, 0), sigma)
        gain = np.clip(MEAN_TONE / max(float(light.mean()), 1e-3), *EXPOSURE_LIMITS) ** 0.7
        grey = np.float32(255.0 * gain) * light
        if self._appearance.noise > 0:
            grain = self._rng.standard_normal(light.shape, dtype=np.float32)
            grey += np.float32(self._appearance.noise) * grain
        picture = eight_bits(grey)
        if self._appearance.jpeg_quality is None:
            return picture
        return after_jpeg(picture, self._appearance.jpeg_quality)


def _blend_cable(ground: Image, approach: ClosestApproach, skin: CableSkin, pixel: Image) -> Image:
    """Return the reflected light of pixels near a cable: shadow, round body, growth."""
    p = approach.p
    outside = np.abs(p) - 1 - skin.outline
    bare = (1 - skin.burial) * (1 - skin.turf)
    side = np.clip(outside, 0, None)
    lee = side + 9 * (p < 1)
    shadow = 0.4 * np.exp(-side / np.float32(0.3)) + 0.25 * np.exp(-lee / np.float32(0.9))
    shaded = ground * (1 - np.float32(skin.shade) * bare * shadow)
    # A cable under turf is still a ridge, lit from the left; its slopes have no edges.
    slope = p * np.exp(p * p * np.float32(-1 / TURF_SLOPE))
    shaded *= 1 - np.float32(TURF_RELIEF) * skin.turf * (1 - skin.burial) * slope
    roundness = np.sqrt(np.clip(1 - p * p, 0, 1))
    body = skin.surface * (0.68 + 0.32 * roundness) * (1 - 0.08 * p)
    cover = np.clip(0.5 - outside / pixel, 0, 1) * bare
    scene = shaded + (body - shaded) * cover
    growth = skin.growth * (np.abs(p) < CABLE_REACH)
    return np.asarray(scene + (skin.growth_tone - scene) * growth)
