"""A simulated dive along a cable, frame by frame, with exact ground truth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.simulation.clutter import random_streaks
from cable_tracker.simulation.renderer import SeabedRenderer
from cable_tracker.simulation.trajectory import Trajectory

FIRST_STAMP = 1_000_000_000
"""Stamp of the first frame [ns]; not 0, which ROS takes for "no time"."""

NANOSECONDS = 1_000_000_000

SMALLEST_SIDE = 32
LARGEST_SIDE = 4096
VIEW_LENGTH = 80.0
"""No frame looks farther than this along the cable [radii]."""


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """What to simulate.

    Attributes
    ----------
    frame_count : int
        Number of frames, at least 1.
    rate : float
        Frames per second, above 0. The motion is one of time: a lower rate gives larger steps.
    image_size : (int, int)
        Width and height [px], each 32 to 4096.
    clutter : float
        How hard the scene is, 0 to 1: overgrowth and burial (at 0.5 about a fifth of the borders is
        hidden), ropes and furrows, haze, blur, marine snow.
    noise : float
        Standard deviation of the sensor's noise [grey levels], 0 to 64.
    seed : int
        Not negative. The same settings give the same frames, bit for bit.

    Raises
    ------
    ParameterError
        A value is out of its range.
    """

    frame_count: int = 300
    rate: float = 25.0
    image_size: tuple[int, int] = (320, 240)
    clutter: float = 0.5
    noise: float = 3.0
    seed: int = 0

    def __post_init__(self) -> None:
        if self.frame_count < 1:
            raise ParameterError(f"frame_count is {self.frame_count}: simulate at least 1 frame")
        if not (math.isfinite(self.rate) and 1e-3 <= self.rate <= 1e6):
            raise ParameterError(f"rate is {self.rate}: give 0.001 to 1000000 frames per second")
        if not all(SMALLEST_SIDE <= side <= LARGEST_SIDE for side in self.image_size):
            raise ParameterError(
                f"image_size is {self.image_size[0]}x{self.image_size[1]}: "
                f"give a width and height of {SMALLEST_SIDE} to {LARGEST_SIDE} px"
            )
        if not 0.0 <= self.clutter <= 1.0:
            raise ParameterError(f"clutter is {self.clutter}: give a value from 0 to 1")
        if not 0.0 <= self.noise <= 64.0:
            raise ParameterError(f"noise is {self.noise}: give 0 to 64 grey levels")
        if self.seed < 0:
            raise ParameterError(f"seed is {self.seed}: give a number that is not negative")


def simulate(settings: SimulationSettings) -> Iterator[Frame]:
    """Yield the frames of a dive, each a mono8 `RawImage` with its true `CableState`.

    Stamps start at 1 s and follow the rate; the frame_id is "camera".
    """
    route_rng, clutter_rng, picture_rng = (
        np.random.default_rng(seed) for seed in np.random.SeedSequence(settings.seed).spawn(3)
    )
    trajectory = Trajectory.random(settings.image_size, route_rng)
    end = trajectory.travel((settings.frame_count - 1) / settings.rate)
    streaks = random_streaks(-VIEW_LENGTH, end + VIEW_LENGTH, settings.clutter, clutter_rng)
    renderer = SeabedRenderer(
        settings.image_size, settings.clutter, settings.noise, streaks, picture_rng
    )
    for index in range(settings.frame_count):
        time = index / settings.rate
        state = trajectory.state(time)
        image = renderer.render(state, trajectory.travel(time))
        stamp = FIRST_STAMP + round(index * NANOSECONDS / settings.rate)
        yield _make_frame(index, stamp, image, state)


def _make_frame(index: int, stamp: int, image: Image, truth: CableState) -> Frame:
    height, width = image.shape
    raw = RawImage(
        encoding="mono8",
        height=height,
        width=width,
        step=width,
        is_bigendian=False,
        data=memoryview(image.tobytes()),
    )
    return Frame(index=index, stamp=stamp, image=raw, truth=truth)
