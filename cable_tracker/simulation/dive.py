"""One dive: camera poses along a cable, rendered frames, and the true state of the cable."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.state import ANGLE, DISTANCE_RATE, POSE_SIZE, SKEW_RATE, CableState
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.simulation.borders import (
    ProjectedBorders,
    fit_states,
    project_tube,
    steer,
    visible_share,
)
from cable_tracker.simulation.rendering.appearance import SceneAppearance, Skin
from cable_tracker.simulation.rendering.camera import (
    NO_DISTORTION,
    Camera,
    CameraPoses,
    Distortion,
)
from cable_tracker.simulation.rendering.clutter import random_companions, random_streaks
from cable_tracker.simulation.rendering.laid_cable import (
    BuriedStretch,
    LaidCable,
    Tube,
    random_bends,
    random_gaps,
)
from cable_tracker.simulation.rendering.photographs import make_photographed_bed
from cable_tracker.simulation.rendering.renderer import Scene, SceneRenderer
from cable_tracker.simulation.rendering.seabed import make_bed, make_cable
from cable_tracker.simulation.rendering.texture import TiledTexture
from cable_tracker.simulation.trajectory import Trajectory
from cable_tracker.stamps import stamp_of_frame
from cable_tracker.tracking.parameter_table import pixel_scale

FOCAL = 280.0
"""Focal length of all cameras [px at a width of 320]."""

MOUNTING = math.radians(20.0)
"""Usual forward tilt of a camera on the vehicle [rad]."""

CABLE_RADIUS = 0.08
"""Radius of the cable [m]."""

BATCH = 32
"""Number of frames whose geometry is computed at once, whatever the length of the dive: arrays of
one shape give the same numbers, bit for bit."""

VIEW_LENGTH = 7.0
"""Length over which clutter is drawn beyond both ends of the dive [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedFrame:
    """A frame, and the visible share of the cable in it.

    Attributes
    ----------
    frame : Frame
        A mono8 `RawImage` with its true `CableState`; no truth where no cable is visible.
    visibility : float
        Share of the two borders inside the image that nothing hides, 0 to 1; 0 without any.
    """

    frame: Frame
    visibility: float


@dataclass(frozen=True, slots=True, eq=False)
class FrameGeometry:
    """Camera poses, borders and true states of N frames.

    Attributes
    ----------
    times : FloatArray
        Shape (N,) [s].
    poses : CameraPoses
        Poses of the camera.
    projected : ProjectedBorders
        Borders of the cable in the images.
    states : FloatArray
        Exact d, alpha, w, beta and their rates, shape (N, 8), columns of `CableState`; NaN where
        no border is inside the image.
    """

    times: FloatArray
    poses: CameraPoses
    projected: ProjectedBorders
    states: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Dive:
    """A camera that is carried along a cable.

    Attributes
    ----------
    camera : Camera
        The camera.
    tube : Tube
        The cable's course.
    trajectory : Trajectory
        Motion of the cable through the image.
    """

    camera: Camera
    tube: Tube
    trajectory: Trajectory

    def geometry(self, times: FloatArray) -> FrameGeometry:
        """Return camera poses, borders and true states at times (N,) [s]."""
        wanted = self.trajectory.states(times, self.camera.image_size[0])
        roll, travel = self.trajectory.roll.values(times), self.trajectory.travel(times)
        poses = steer(self.tube, self.camera, wanted, roll, travel)
        projected = project_tube(self.tube, self.camera, poses)
        states = fit_states(projected, self.camera.image_size)
        # Where the line is written the other way round, so is the sense of its distance and skew.
        states[:, POSE_SIZE:] = wanted[:, POSE_SIZE:]
        angles = wanted[:, ANGLE]
        turned = np.abs(wrap_states(wanted)[:, ANGLE] - angles) > np.pi / 2
        states[turned, DISTANCE_RATE] *= -1
        states[turned, SKEW_RATE] *= -1
        states[~projected.in_view()] = np.nan
        return FrameGeometry(times, poses, projected, states)


@dataclass(frozen=True, slots=True, eq=False)
class SceneSettings:
    """Settings of a scene: all but the course of the first cable.

    Attributes
    ----------
    appearance : SceneAppearance
        Appearance of bottom, cable and water.
    has_cable : bool
        Whether the cable is there.
    stretches : tuple of BuriedStretch
        Buried stretches of the cable.
    others : tuple of (Tube, Skin)
        Further cables, on top of it.
    photographs : Path or None
        A folder of pictures that the bottom is made of.
    """

    appearance: SceneAppearance
    has_cable: bool = True
    stretches: tuple[BuriedStretch, ...] = ()
    others: tuple[tuple[Tube, Skin], ...] = ()
    photographs: Path | None = None


@dataclass(frozen=True, slots=True)
class Seeds:
    """One source of randomness for each part, so that changing one leaves the others alone."""

    route: np.random.SeedSequence
    course: np.random.SeedSequence
    clutter: np.random.SeedSequence
    picture: np.random.SeedSequence

    @classmethod
    def of(cls, seed: int) -> Seeds:
        """Derive all from one number."""
        return cls(*np.random.SeedSequence(seed).spawn(4))


def dive_camera(
    image_size: tuple[int, int],
    mounting: float = MOUNTING,
    distortion: Distortion = NO_DISTORTION,
) -> Camera:
    """Return the camera of a dive; see `Camera`. A wider picture shows the same view."""
    return Camera(image_size, FOCAL * pixel_scale(image_size[0]), mounting, distortion)


def random_course(curvature: float, lengths: tuple[float, float], rng: np.random.Generator) -> Tube:
    """Draw the course of a cable along x, which wanders about it; see `random_bends`."""
    return Tube(CABLE_RADIUS, random_bends(curvature, lengths, rng))


def frame_times(start: int, rate: float) -> FloatArray:
    """Return the times of a batch of frames, shape (BATCH,) [s]."""
    return np.arange(start, start + BATCH, dtype=np.float64) / rate


def render_dive(
    dive: Dive, scene_settings: SceneSettings, frame_count: int, rate: float, seeds: Seeds
) -> Iterator[SimulatedFrame]:
    """Render the frames of a dive, with their truths."""
    length = float(dive.trajectory.travel(np.array([(frame_count - 1) / rate]))[0])
    clutter_rng = np.random.default_rng(seeds.clutter)
    picture_rng = np.random.default_rng(seeds.picture)
    scene, cable = make_scene(
        dive.camera, dive.tube, scene_settings, length, (clutter_rng, picture_rng)
    )
    renderer = SceneRenderer(dive.camera, scene, scene_settings.appearance, picture_rng)
    for start in range(0, frame_count, BATCH):
        geometry = dive.geometry(frame_times(start, rate))
        for place in range(min(BATCH, frame_count - start)):
            position, rotation = geometry.poses.positions[place], geometry.poses.rotations[place]
            image = renderer.render(position, rotation, float(geometry.times[place]))
            visibility = 0.0
            if cable is not None:
                projected = geometry.projected
                hidden = renderer.hidden(
                    cable, position, projected.world[place], projected.inside[place]
                )
                visibility = visible_share(projected, place, hidden)
            truth = CableState.from_array(geometry.states[place]) if visibility > 0 else None
            yield SimulatedFrame(make_frame(start + place, rate, image, truth), visibility)


def make_scene(
    camera: Camera,
    tube: Tube,
    scene_settings: SceneSettings,
    length: float,
    rngs: tuple[np.random.Generator, np.random.Generator],
) -> tuple[Scene, LaidCable | None]:
    """Make the bottom, the cables and the clutter along a course.

    Parameters
    ----------
    camera : Camera
        Its resolution is that of the surfaces.
    tube : Tube
        The first cable.
    scene_settings : SceneSettings
        Appearance, burial and further cables.
    length : float
        Length of the course, from 0 [m].
    rngs : (Generator, Generator)
        Draw the clutter, and the surfaces.

    Returns
    -------
    (Scene, LaidCable or None)
        The scene, and its first cable if there is one.
    """
    clutter_rng, picture_rng = rngs
    appearance, radius = scene_settings.appearance, tube.radius
    streaks = random_streaks(
        -VIEW_LENGTH / radius, (length + VIEW_LENGTH) / radius, appearance.clutter, clutter_rng
    )
    gaps = random_gaps(-VIEW_LENGTH, length + VIEW_LENGTH, radius, appearance.skin, clutter_rng)
    streaks += random_companions(
        tube,
        -VIEW_LENGTH / radius,
        (length + VIEW_LENGTH) / radius,
        appearance.companions,
        clutter_rng,
    )
    scale = pixel_scale(camera.image_size[0])
    resolution = int(np.clip(round(5 * scale), 2, 10)) * 4
    bed = _make_bed(scene_settings, resolution, picture_rng)
    own = LaidCable(
        tube,
        make_cable(resolution, appearance.skin, picture_rng),
        gaps + scene_settings.stretches,
        appearance.skin.shade,
    )
    others = tuple(
        LaidCable(tube, make_cable(resolution, skin, picture_rng), shade=skin.shade)
        for tube, skin in scene_settings.others
    )
    cable = own if scene_settings.has_cable else None
    cables = others if cable is None else (cable, *others)
    return Scene(bed, cables, streaks, radius), cable


def _make_bed(
    scene_settings: SceneSettings, resolution: int, rng: np.random.Generator
) -> TiledTexture:
    bottom = scene_settings.appearance.bottom
    if scene_settings.photographs is not None:
        return make_photographed_bed(scene_settings.photographs, resolution, bottom.tone, rng)
    return make_bed(resolution, bottom, rng)


def make_frame(index: int, rate: float, image: Image, truth: CableState | None) -> Frame:
    """Wrap a picture, uint8 of shape (H, W), as a frame of a dive at a rate [1/s]."""
    height, width = image.shape
    raw = RawImage("mono8", height, width, width, False, memoryview(image.tobytes()))
    return Frame(index, stamp_of_frame(index, rate), raw, truth=truth)
