"""Cable courses drawn by a seed, and the scene about a cable as a camera on a vehicle sees it.

The world frame is that of `vehicle`: x along the general course of the cable, y to its left.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.cable.model.geometry import states_in_chart
from cable_tracker.cable.model.state import ANGLE, POSE_SIZE, CableState
from cable_tracker.simulation.borders import fit_states, project_tube, visible_share
from cable_tracker.simulation.dive import (
    SceneSettings,
    Seeds,
    dive_camera,
    make_scene,
    random_course,
)
from cable_tracker.simulation.rendering.appearance import Bottom, SceneAppearance, Skin, Water
from cable_tracker.simulation.rendering.camera import CameraPoses, from_renderer, to_renderer
from cable_tracker.simulation.rendering.laid_cable import Tube
from cable_tracker.simulation.rendering.renderer import SceneRenderer
from cable_tracker.simulation.vehicle import VehicleState

CURVATURE = 0.04
"""The cable never bends more than this [1/m]."""

BEND_LENGTHS = (24.0, 45.0)
"""Shortest and longest bend of the cable [m]."""

SCENE_APPEARANCE = SceneAppearance(
    bottom=Bottom(stones=0.8, algae=0.8),
    skin=Skin(tone=0.6, stains=0.7, cover=0.3, turf=0.05, silt=0.1, bulge=0.05, drift=0.1),
    water=Water(absorption=0.1, scatter=0.1, veil=0.25, flakes=0.3),
    daylight=0.6,
    clutter=0.3,
)
"""An overgrown cable in fairly clear water, with a rope or furrow here and there."""

BURIAL_RAMP = 0.3
"""Way over which the sand rises and falls at the ends of a buried stretch [m]."""

NEAREST_STEPS = 6
"""Steps to the nearest point of the cable."""

RATE_STEP = 1e-3
"""Rates are differences over this time before and after [s]."""


def bent_cable(rng: np.random.Generator) -> Tube:
    """Draw the course of a cable; see `random_course`."""
    return random_course(CURVATURE, BEND_LENGTHS, rng)


def cable_of_seed(seed: int) -> Tube:
    """Return the cable that a seed draws."""
    return bent_cable(np.random.default_rng(Seeds.of(seed).course))


def cable_points(tube: Tube, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points and directions of a cable in the world, each (N, 3), at places (N,) [m]."""
    points, directions = tube.axis(along)
    return from_renderer(points), from_renderer(directions)


def cable_course(seed: int, along: FloatArray) -> FloatArray:
    """Return points of the cable that a seed gives, (N, 3) [m], at places (N,) along it."""
    return cable_points(cable_of_seed(seed), along)[0]


def nearest_along(tube: Tube, point: FloatArray, along: float) -> float:
    """Return the position along a cable nearest to a point (2,), from a guess `along` [m]."""
    for _ in range(NEAREST_STEPS):
        points, directions = cable_points(tube, np.array([along]))
        step = float((point - points[0, :2]) @ directions[0, :2])
        along += step * float(directions[0, 0])
    return along


class CableScene:
    """A cable with all that lies about it, as the camera of a vehicle sees it.

    Parameters
    ----------
    tube : Tube
        The first cable.
    scene_settings : SceneSettings
        Appearance, burial and further cables.
    length : float
        Length of the course, from 0 [m].
    image_size : (int, int)
        Width and height of the pictures [px].
    rngs : (Generator, Generator)
        Draw the clutter, and the surfaces.

    Attributes
    ----------
    camera : Camera
        The vehicle's camera; base_link is at its centre.
    streaks : tuple of Streak
        Ropes, furrows, tracks.
    """

    def __init__(
        self,
        tube: Tube,
        scene_settings: SceneSettings,
        length: float,
        image_size: tuple[int, int],
        rngs: tuple[np.random.Generator, np.random.Generator],
    ) -> None:
        self._tube = tube
        self.camera = dive_camera(image_size)
        scene, cable = make_scene(self.camera, tube, scene_settings, length, rngs)
        assert cable is not None
        self._cable = cable
        self.streaks = scene.streaks
        self._renderer = SceneRenderer(self.camera, scene, scene_settings.appearance, rngs[1])

    def picture(self, state: VehicleState, seconds: float) -> Image:
        """Render the next picture at a time [s]: grey, uint8, shape (H, W)."""
        poses = self._poses(state)
        return self._renderer.render(poses.positions[0], poses.rotations[0], seconds)

    def true_state(self, state: VehicleState) -> CableState | None:
        """Return the true state of the cable in the image [px, rad]; None if none of it is visible.

        Its rates are those at which it moves through the image as the vehicle moves now.
        """
        poses = self._poses(state)
        projected = project_tube(self._tube, self.camera, poses)
        hidden = self.hidden(poses.positions[0], projected.world[0], projected.inside[0])
        if visible_share(projected, 0, hidden) <= 0.0:
            return None
        states = fit_states(projected, self.camera.image_size)
        states[0, POSE_SIZE:] = self._rates(state, states[0, ANGLE])
        return CableState.from_array(states[0])

    def _rates(self, state: VehicleState, angle: float) -> FloatArray:
        """Return the rates of d, alpha, w, beta about a normal angle, shape (4,)."""
        before, after = (
            fit_states(
                project_tube(self._tube, self.camera, self._poses(state.moved(seconds))),
                self.camera.image_size,
            )
            for seconds in (-RATE_STEP, RATE_STEP)
        )
        places = states_in_chart(np.concatenate((before, after)), angle)[:, :POSE_SIZE]
        rates: FloatArray = (places[1] - places[0]) / (2.0 * RATE_STEP)
        return rates

    def hidden(self, position: FloatArray, world: FloatArray, usable: BoolArray) -> BoolArray:
        """Return which border points are covered, shape (2, K); see `SceneRenderer.hidden`."""
        return self._renderer.hidden(self._cable, position, world, usable)

    def _poses(self, state: VehicleState) -> CameraPoses:
        """Return the pose of the camera in the world of the renderer, N = 1."""
        return self.camera.poses(to_renderer(state.position)[None], state.angles[None])
