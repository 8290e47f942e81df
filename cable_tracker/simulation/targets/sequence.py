"""Frames of a scenario, with the exact mask of the visible part of the target."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, Image
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.targets.background import TargetBackground, random_background
from cable_tracker.simulation.targets.bodies import ImagePose, paint
from cable_tracker.simulation.targets.scenarios import TARGET_SCENARIOS, ScenarioRun, TargetScenario
from cable_tracker.stamps import stamp_of_frame
from cable_tracker.tracking.image_frame import Window, bounding_box
from cable_tracker.tracking.parameter_table import named, pixel_scale

LEAST_SHARE = 0.25
"""Smallest visible share of a target that counts as in view."""

LEAST_AREA = 40
"""Smallest visible area of a target that counts as in view, at an image width of 320 [px²]."""

HAZE = np.array([140.0, 118.0, 58.0], np.float32)
"""Colour of the water between target and camera: blue, green, red."""

DRIFT = 70.0
"""Largest offset of the view on the panorama, at an image width of 320 [px]."""

STALK = np.array([52.0, 74.0, 58.0], np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class TargetFrame:
    """A frame and the truth about the target.

    Attributes
    ----------
    image : Image
        uint8, blue-green-red, shape (H, W, 3).
    stamp : int
        Time [ns].
    mask : BoolArray
        Visible pixels of the target, shape (H, W); empty while it is out of view.
    twin_mask : BoolArray
        Visible pixels of the twin, shape (H, W).
    size : float
        Length of the body's unit [px]; 0 while it is out of view.
    """

    image: Image
    stamp: int
    mask: BoolArray
    twin_mask: BoolArray
    size: float

    @property
    def box(self) -> Window | None:
        """Left, top, right, bottom of the mask, from the top left corner; None if out of view."""
        return bounding_box(self.mask)

    @property
    def twin_box(self) -> Window | None:
        """Left, top, right, bottom of the twin's mask; None if the twin is out of view."""
        return bounding_box(self.twin_mask)


def find_target_scenario(name: str) -> TargetScenario:
    """Return a scenario by its name.

    Raises
    ------
    ParameterError
        There is none.
    """
    return named("scenario", name, TARGET_SCENARIOS)


def labelled_frames(
    simulated: Iterable[TargetFrame],
) -> Iterator[tuple[Frame, Window | None]]:
    """Yield the frames of a run as camera frames, each with its true box."""
    for index, each in enumerate(simulated):
        yield Frame(index, each.stamp, raw_from_array(each.image, "bgr8")), each.box


def simulate_target(
    name: str,
    seed: int,
    frame_count: int = 150,
    *,
    rate: float = 25.0,
    size: tuple[int, int] = (320, 240),
) -> Iterator[TargetFrame]:
    """Yield the frames of one run of a scenario.

    Parameters
    ----------
    name : str
        Name of the scenario, one of `TARGET_SCENARIOS`.
    seed : int
        The same arguments give the same frames, bit for bit.
    frame_count : int
        Number of frames; it changes the duration of the run, and with it the trajectory.
    rate : float
        Frames per second.
    size : (int, int)
        Width and height [px].

    Raises
    ------
    ParameterError
        There is no such scenario.
    """
    scenario = find_target_scenario(name)
    rng = np.random.default_rng([seed, sorted(TARGET_SCENARIOS).index(name)])
    zoom = pixel_scale(size[0])
    background = random_background(size, rng, margin=DRIFT * zoom, surface=scenario.surface)
    duration = frame_count / rate
    run = scenario.draw_run(320.0, size[1] / zoom, duration, rng)
    drift = rng.uniform(-DRIFT, DRIFT, 2), rng.uniform(0.3, 1.1, 2), rng.uniform(0.0, 6.0, 2)
    for index in range(frame_count):
        time = index / rate
        offset = drift[0] * zoom * np.sin(drift[1] * time + drift[2])
        picture = background.view(size, (float(offset[0]), float(offset[1])), time)
        stamp = stamp_of_frame(index, rate)
        yield _frame(scenario, run, background, picture, time, stamp, zoom, rng)


def _frame(  # noqa: PLR0917
    scenario: TargetScenario,
    run: ScenarioRun,
    background: TargetBackground,
    picture: Image,
    time: float,
    stamp: int,
    zoom: float,
    rng: np.random.Generator,
) -> TargetFrame:
    if scenario.surface is not None:
        _mirror(scenario, run, picture, time, zoom)
    pose, twin_pose = run.trajectory(time), run.twin(time) if run.twin else None
    own = _painted(scenario, pose, picture, zoom)
    twin = _painted(scenario, twin_pose, picture, zoom)
    for colours, coverage in (own, twin) if run.twin_in_front else (twin, own):
        picture *= (1.0 - coverage)[..., None]
        picture += colours
    hidden = _stalks(run, picture, time, zoom)
    own_hidden = np.maximum(hidden, twin[1]) if run.twin_in_front else hidden
    twin_hidden = hidden if run.twin_in_front else np.maximum(hidden, own[1])
    mask = _visible(own[1], own_hidden, pose, zoom)
    return TargetFrame(
        image=background.recorded(picture, time, rng),
        stamp=stamp,
        mask=mask,
        twin_mask=_visible(twin[1], twin_hidden, twin_pose, zoom),
        size=pose.size * zoom if pose is not None and mask.any() else 0.0,
    )


def _painted(
    scenario: TargetScenario, pose: ImagePose | None, picture: Image, zoom: float
) -> tuple[Image, Image]:
    height, width = picture.shape[:2]
    if pose is None:
        return np.zeros_like(picture), np.zeros((height, width), np.float32)
    scaled = replace(pose, x=pose.x * zoom, y=pose.y * zoom, size=pose.size * zoom)
    colours, coverage = paint(scenario.body(pose.phase), scaled, (width, height))
    # What is small is far, and its colour fades into that of the water.
    clear = scenario.clearness * min(1.0, 0.55 + pose.size / 90.0)
    return clear * colours + (1.0 - clear) * HAZE * coverage[..., None], coverage


def _mirror(
    scenario: TargetScenario, run: ScenarioRun, picture: Image, time: float, zoom: float
) -> None:
    """Paint the target's wavering image in the under side of the surface."""
    assert scenario.surface is not None
    pose = run.trajectory(time)
    if pose is None:
        return
    height, width = picture.shape[:2]
    colours, coverage = _painted(scenario, pose, picture, zoom)
    line = height * (1.0 - scenario.surface)
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    across = columns + 3.0 * zoom * np.sin(0.35 * rows / zoom + 6.0 * time)
    below = 2.0 * line - rows + 2.0 * zoom * np.sin(0.2 * columns / zoom + 4.0 * time)
    flipped = [
        cv2.remap(each, across.astype(np.float32), below.astype(np.float32), cv2.INTER_LINEAR)
        for each in (colours, coverage)
    ]
    flipped[0][rows > line] = 0.0
    flipped[1][rows > line] = 0.0
    picture *= (1.0 - 0.6 * flipped[1])[..., None]
    picture += 0.6 * flipped[0]


def _stalks(run: ScenarioRun, picture: Image, time: float, zoom: float) -> Image:
    """Paint the stalks before everything; return their coverage."""
    height, width = picture.shape[:2]
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    coverage = np.zeros((height, width), np.float32)
    for middle, half in run.stalks:
        bend = 4.0 * zoom * np.sin(rows / (40.0 * zoom) + 0.8 * time)
        inside = half * zoom - np.abs(columns - middle * zoom - bend)
        np.maximum(coverage, np.clip(inside + 0.5, 0.0, 1.0), out=coverage)
    picture *= (1.0 - coverage)[..., None]
    picture += coverage[..., None] * STALK
    return coverage


def _visible(coverage: Image, hidden: Image, pose: ImagePose | None, zoom: float) -> BoolArray:
    """Return the visible pixels of a body, (H, W); none if it does not count as in view."""
    mask: BoolArray = (coverage > 0.5) & (hidden < 0.5)
    visible = int(mask.sum())
    whole = _whole_area(coverage, pose, zoom)
    if visible < max(LEAST_AREA * zoom**2, LEAST_SHARE * whole):
        mask[:] = False
    return mask


def _whole_area(coverage: Image, pose: ImagePose | None, zoom: float) -> float:
    """Return the approximate area of the body, also beyond the border of the picture [px²]."""
    if pose is None:
        return 0.0
    return max(float(coverage.sum()), 0.3 * (pose.size * zoom) ** 2 * abs(pose.foreshortening))
