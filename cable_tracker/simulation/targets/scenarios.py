"""The scenarios of targets: body, trajectory in the image, and obstacles."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from cable_tracker.simulation.targets.bodies import (
    ImagePose,
    Patch,
    box_vehicle,
    buoy,
    diver,
    vehicle,
)

ImageTrajectory = Callable[[float], ImagePose | None]
"""Gives the pose at a time [s]; None while there is no target."""

Body = Callable[[float], list[Patch]]


@dataclass(frozen=True, slots=True, eq=False)
class ScenarioRun:
    """Targets and obstacles in one run of a scenario.

    Attributes
    ----------
    trajectory : ImageTrajectory
        Trajectory of the target.
    twin : ImageTrajectory or None
        Trajectory of another target that looks like the first; None: there is none.
    twin_in_front : bool
        Whether the twin hides the target.
    stalks : tuple of (float, float)
        Upright stalks before everything: middle and half width [px].
    """

    trajectory: ImageTrajectory
    twin: ImageTrajectory | None = None
    twin_in_front: bool = False
    stalks: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class TargetScenario:
    """One scenario; its runs differ by their seeds.

    Attributes
    ----------
    name : str
        Displayed name.
    body : Body
        Body of the target.
    draw_run : callable
        Draws a run, from width and height of the pictures [px], duration [s] and a generator.
    clearness : float
        Share of its own colour that a near target shows; the rest is that of the water.
    surface : float or None
        Height of the surface, as a share of the picture.
    """

    name: str
    body: Body
    draw_run: Callable[[float, float, float, np.random.Generator], ScenarioRun]
    clearness: float = 0.9
    surface: float | None = None


def _sway(rng: np.random.Generator, amplitude: float) -> Callable[[float], float]:
    """Return a smooth random function of time [s] about zero."""
    rates, phases = rng.uniform(0.5, 2.4, 3), rng.uniform(0.0, 2.0 * math.pi, 3)
    return lambda time: float(amplitude * np.sin(rates * time + phases).sum() / 2.0)


def _buoy_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    x, y = width * rng.uniform(0.3, 0.7), height * rng.uniform(0.35, 0.6)
    near, far = rng.uniform(60.0, 85.0), rng.uniform(16.0, 24.0)
    across, up, tilt = _sway(rng, 45.0), _sway(rng, 24.0), _sway(rng, 0.15)
    approaches = rng.random() < 0.5

    def trajectory(time: float) -> ImagePose:
        share = time / duration if approaches else 1.0 - time / duration
        size = far * (near / far) ** share
        return ImagePose(x + across(time), y + up(time), size, tilt(time))

    return ScenarioRun(trajectory)


def _swimming_trajectory(
    width: float, height: float, duration: float, rng: np.random.Generator, size: float
) -> ImageTrajectory:
    """Return a trajectory to and fro across the picture, turning towards the camera at its ends."""
    heading = rng.choice((-1.0, 1.0))
    reach, period = width * rng.uniform(0.25, 0.33), duration * rng.uniform(0.7, 1.1)
    y, phase = height * rng.uniform(0.35, 0.6), rng.uniform(-0.7, 0.7)
    up, tilt, nearness = _sway(rng, 22.0), _sway(rng, 0.22), _sway(rng, 0.28)

    def trajectory(time: float) -> ImagePose:
        turn = 2.0 * math.pi * time / period + phase
        facing = heading * math.cos(turn)
        foreshortening = math.copysign(max(abs(facing), 0.35), facing)
        x = width / 2 + heading * reach * math.sin(turn)
        return ImagePose(
            x, y + up(time), size * math.exp(nearness(time)), tilt(time), foreshortening, 7.0 * time
        )

    return trajectory


def _vehicle_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    return ScenarioRun(_swimming_trajectory(width, height, duration, rng, rng.uniform(60.0, 85.0)))


def _diver_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    return ScenarioRun(_swimming_trajectory(width, height, duration, rng, rng.uniform(95.0, 125.0)))


def _hazy_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    trajectory = _swimming_trajectory(width, height, duration, rng, rng.uniform(55.0, 75.0))
    return ScenarioRun(lambda time: replace(_required(trajectory(time)), foreshortening=1.0))


def _required(pose: ImagePose | None) -> ImagePose:
    assert pose is not None
    return pose


def _leaving_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    """Out over one side for about a third of the time, and back over the same."""
    side, size = rng.choice((-1.0, 1.0)), rng.uniform(34.0, 46.0)
    y, up = height * rng.uniform(0.35, 0.6), _sway(rng, 16.0)
    back_lower = rng.uniform(-30.0, 30.0)
    reach = width * 0.5 + size * rng.uniform(1.6, 2.2)

    def trajectory(time: float) -> ImagePose:
        out = math.sin(math.pi * time / duration) ** 2
        x = width / 2 + side * (reach * 1.25 * out - width * 0.15)
        lower = back_lower if time > duration / 2 else 0.0
        return ImagePose(x, y + lower + up(time), size)

    return ScenarioRun(trajectory)


def _occlusion_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    size, side = rng.uniform(30.0, 40.0), rng.choice((-1.0, 1.0))
    y, up = height * rng.uniform(0.35, 0.6), _sway(rng, 14.0)

    def trajectory(time: float) -> ImagePose:
        x = width * (0.5 + side * (0.36 - 0.72 * time / duration))
        return ImagePose(x, y + up(time), size)

    stalks = tuple(
        (width * (0.5 + side * place), half)
        for place, half in ((0.14, 0.3 * size), (-0.12, size * rng.uniform(0.55, 0.8)))
    )
    return ScenarioRun(trajectory, stalks=stalks)


def _crossing_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    size, side = rng.uniform(30.0, 40.0), rng.choice((-1.0, 1.0))
    y, up, twin_up = height * rng.uniform(0.4, 0.55), _sway(rng, 12.0), _sway(rng, 12.0)
    apart = rng.uniform(-8.0, 8.0)

    def trajectory(time: float) -> ImagePose:
        return ImagePose(width * (0.5 + side * (0.35 - 0.7 * time / duration)), y + up(time), size)

    def twin(time: float) -> ImagePose:
        x = width * (0.5 - side * (0.33 - 0.66 * time / duration))
        return ImagePose(x, y + apart + twin_up(time), size)

    return ScenarioRun(trajectory, twin, twin_in_front=bool(rng.random() < 0.5))


def _surface_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    size, x, y = rng.uniform(34.0, 48.0), width * rng.uniform(0.35, 0.65), height * 0.58
    across, up, nearness = _sway(rng, 60.0), _sway(rng, 14.0), _sway(rng, 0.2)
    return ScenarioRun(
        lambda time: ImagePose(x + across(time), y + up(time), size * math.exp(nearness(time)))
    )


def _vanishing_run(
    width: float, height: float, duration: float, rng: np.random.Generator
) -> ScenarioRun:
    """Leaves within the first fifth of the time, for good."""
    side, size = rng.choice((-1.0, 1.0)), rng.uniform(34.0, 46.0)
    y = height * rng.uniform(0.35, 0.6)

    def trajectory(time: float) -> ImagePose | None:
        x = width / 2 + side * (0.5 * width + size) * time / (0.2 * duration)
        return ImagePose(x, y, size) if time < 0.25 * duration else None

    return ScenarioRun(trajectory)


def _empty_run(
    _width: float, _height: float, _duration: float, _rng: np.random.Generator
) -> ScenarioRun:
    return ScenarioRun(lambda _time: None)


TARGET_SCENARIOS: Mapping[str, TargetScenario] = MappingProxyType(
    {
        scenario.name: scenario
        for scenario in (
            # From far to near, or back.
            TargetScenario("buoy", buoy, _buoy_run),
            # Turns about.
            TargetScenario("vehicle", vehicle, _vehicle_run),
            # Its outline changes in every frame.
            TargetScenario("diver", diver, _diver_run),
            # A grey vehicle in haze.
            TargetScenario("low_contrast", box_vehicle, _hazy_run, 0.6),
            # Out of the picture and back.
            TargetScenario("leaving", buoy, _leaving_run),
            # Hidden by stalks, twice.
            TargetScenario("occlusion", buoy, _occlusion_run),
            # Two of one kind cross.
            TargetScenario("crossing", buoy, _crossing_run),
            # Its mirror above it.
            TargetScenario("near_surface", buoy, _surface_run, surface=0.68),
            # Soon gone, for good.
            TargetScenario("vanishing", buoy, _vanishing_run),
            # Never any target.
            TargetScenario("nothing", buoy, _empty_run),
        )
    }
)
"""All scenarios of targets by name."""
