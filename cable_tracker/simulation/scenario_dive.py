"""Dives of the plain simulation and of scenarios: random motion, and frames with exact truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.errors import ParameterError
from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.dive import (
    Dive,
    SceneSettings,
    Seeds,
    SimulatedFrame,
    dive_camera,
    random_course,
    render_dive,
)
from cable_tracker.simulation.rendering.appearance import SceneAppearance
from cable_tracker.simulation.rendering.camera import NO_DISTORTION, Distortion
from cable_tracker.simulation.rendering.laid_cable import BuriedStretch, Tube
from cable_tracker.simulation.scenarios import (
    SCENARIO_RATE,
    ComponentMotion,
    Crossing,
    Scenario,
    find_scenario,
)
from cable_tracker.simulation.settings import (
    check_frames,
    check_seed,
    check_size,
)
from cable_tracker.simulation.trajectory import (
    Bands,
    Harmonics,
    Pause,
    Signal,
    Trajectory,
)

SCENARIO_SIZE = (320, 240)
"""Width and height of the frames of the scenarios [px]."""

CURVATURE = 0.012
"""The cable of `simulate` never bends more than this [1/m]."""

BEND_LENGTHS = (12.0, 24.0)
"""Shortest and longest bend of a cable [m]."""

DISTANCE_LIMIT = 70.0
"""Largest |d| of the plain simulation [px at the reference width]."""

ANGLE_LIMIT = float(np.deg2rad(25.0))
"""Largest |alpha| [rad]."""

WIDTH_LIMITS = (24.0, 48.0)
"""Smallest and largest w [px at the reference width]."""

SKEW_LIMITS = (float(np.deg2rad(1.0)), float(np.deg2rad(3.2)))
"""Smallest and largest beta [rad]; the borders meet outside a 4:3 image."""

SPEED_LIMITS = (0.2, 0.36)
"""Forward speed [m/s]."""

ROLL_LIMIT = float(np.deg2rad(2.5))
"""Largest roll of the vehicle [rad]."""

SURGE_LIMIT = 0.06
"""Largest distance of the vehicle before or behind its steady motion [m]."""

SHARES = (0.3, 0.4, 0.2, 0.1)
"""Shares of the limit that the sinusoids take: slow wandering first, then faster and smaller."""

SWAY_BANDS: Bands = ((0.008, 0.03), (0.12, 0.2), (0.25, 0.45), (0.5, 0.75))
"""Frequencies of the sinusoids of d and alpha [Hz]."""

DRIFT_BANDS: Bands = ((0.008, 0.02), (0.03, 0.06), (0.07, 0.12), (0.15, 0.2))
"""Frequencies of the sinusoids of altitude and tilt [Hz]."""

ROLL_BANDS: Bands = ((0.1, 0.15), (0.25, 0.35), (0.5, 0.7))
"""Frequencies of the sinusoids of the roll [Hz]."""

BRAKING_TIME = 1.0
"""Time in which a vehicle stops, or gets under way again [s]."""

ATTEMPTS = 40
"""Number of draws of a motion before one that exceeds its limits is given up."""


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """Settings of a simulated dive.

    Attributes
    ----------
    frame_count : int
        Number of frames, at least 1.
    rate : float
        Frames per second, 0.001 to 1e6. The motion is one of time: a lower rate gives larger steps.
    image_size : (int, int)
        Width and height [px], each 32 to 4096.
    clutter : float
        Difficulty of the scene, 0 to 1: overgrowth and burial (at 0.5 about a fifth of the borders
        is hidden), ropes and furrows, haze, blur, marine snow.
    noise : float
        Standard deviation of the sensor's noise [grey levels].
    distortion : tuple of 5 float
        k1, k2, p1, p2, k3 of the lens ("plumb_bob"); all 0 is none.
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
    distortion: Distortion = NO_DISTORTION
    seed: int = 0

    def __post_init__(self) -> None:
        check_frames(self.frame_count, self.rate)
        check_size(self.image_size)
        if not dive_camera(self.image_size, distortion=self.distortion).sees_all_pixels():
            given = ", ".join(f"{each:g}" for each in self.distortion)
            raise ParameterError(
                f"distortion is {given}: such a lens does not show the whole picture; give"
                " smaller values, for instance -0.15, 0.02, 0, 0, 0"
            )
        if not 0.0 <= self.clutter <= 1.0:
            raise ParameterError(f"clutter is {self.clutter}: give a value from 0 to 1")
        check_seed(self.seed)


def simulate(settings: SimulationSettings) -> Iterator[Frame]:
    """Yield the frames of a dive, each a mono8 `RawImage` with its true `CableState`.

    Stamps start at 1 s and follow the rate; the frame_id is "camera".
    """
    seeds, dive = Seeds.of(settings.seed), simulated_dive(settings)
    scene_settings = SceneSettings(SceneAppearance.for_clutter(settings.clutter, settings.noise))
    for simulated in render_dive(dive, scene_settings, settings.frame_count, settings.rate, seeds):
        yield simulated.frame


def simulated_dive(settings: SimulationSettings) -> Dive:
    """Return camera, cable and motion of `simulate`."""
    seeds = Seeds.of(settings.seed)
    return Dive(
        camera=dive_camera(settings.image_size, distortion=settings.distortion),
        tube=random_course(CURVATURE, BEND_LENGTHS, np.random.default_rng(seeds.course)),
        trajectory=random_trajectory(np.random.default_rng(seeds.route)),
    )


def simulate_scenario(
    scenario: str | Scenario,
    seed: int = 0,
    image_size: tuple[int, int] = SCENARIO_SIZE,
    *,
    photographs: Path | None = None,
) -> Iterator[SimulatedFrame]:
    """Yield the frames of a scenario at 25 frames per second, bit for bit the same each time.

    Parameters
    ----------
    scenario : str or Scenario
        One of `SCENARIOS`, or one's own.
    seed : int
        Not negative: draws motion, course, surfaces and noise.
    image_size : (int, int)
        Width and height [px], each 32 to 4096; lengths scale with the width.
    photographs : Path or None
        A folder of photographs of a sea bed that the bottom is made of; None: made of noise.

    Raises
    ------
    ParameterError
        A scenario of that name is unknown, a value is out of its range, or no cable is in view
        where it is to be buried or crossed.
    RecordingError
        There are no photographs in the folder.
    """
    chosen = find_scenario(scenario) if isinstance(scenario, str) else scenario
    dive = scenario_dive(chosen, seed, image_size)
    scene_settings = SceneSettings(
        chosen.appearance,
        chosen.has_cable,
        () if chosen.buried is None else (_bury(dive, chosen.buried),),
        () if chosen.crossing is None else ((_cross(dive, chosen.crossing), chosen.crossing.skin),),
        photographs,
    )
    return render_dive(dive, scene_settings, chosen.frame_count, SCENARIO_RATE, Seeds.of(seed))


def scenario_dive(
    scenario: str | Scenario, seed: int = 0, image_size: tuple[int, int] = SCENARIO_SIZE
) -> Dive:
    """Return the camera, the cable and the motion of a scenario.

    Raises
    ------
    ParameterError
        As `simulate_scenario`.
    """
    if isinstance(scenario, str):
        scenario = find_scenario(scenario)
    check_size(image_size)
    check_seed(seed)
    seeds = Seeds.of(seed)
    return Dive(
        camera=dive_camera(image_size, float(np.deg2rad(scenario.mounting))),
        tube=random_course(scenario.curvature, BEND_LENGTHS, np.random.default_rng(seeds.course)),
        trajectory=scenario_trajectory(scenario, np.random.default_rng(seeds.route)),
    )


def _places_in_view(dive: Dive, frames: IndexArray) -> FloatArray:
    """Return the positions along the cable in view in any of some frames, shape (K,) [m]."""
    projected = dive.geometry(frames / SCENARIO_RATE).projected
    in_view: FloatArray = projected.along[projected.inside.any(axis=1)]
    if not in_view.size:
        raise ParameterError(
            f"no cable is in view in the frames {frames[0]} to {frames[-1]}: choose others in which"
            " it is buried or crossed"
        )
    return in_view


def _bury(dive: Dive, frames: tuple[int, int]) -> BuriedStretch:
    """Return the stretch that hides the cable from all of the frames from first to last."""
    in_view = _places_in_view(dive, np.arange(frames[0], frames[1] + 1))
    margin = 0.5 * dive.tube.radius
    return BuriedStretch(float(in_view.min()) - margin, float(in_view.max()) + margin, 0.1)


def _cross(dive: Dive, crossing: Crossing) -> Tube:
    """Return the cable that crosses the other one in the middle of the view of a frame."""
    along = _places_in_view(dive, np.array([crossing.frame]))
    middle, _ = dive.tube.axis(np.array([np.median(along)]))
    origin = (float(middle[0, 0]), float(middle[0, 1]))
    return Tube(crossing.radius, (), origin, float(np.deg2rad(crossing.angle)))


def random_trajectory(rng: np.random.Generator) -> Trajectory:
    """Draw the trajectory of the plain simulation: wandering, within limits, for ever."""
    narrowest, widest = WIDTH_LIMITS
    low, high = SKEW_LIMITS
    return Trajectory(
        distance=_wander(0.0, DISTANCE_LIMIT, SWAY_BANDS, rng),
        angle=_wander(0.0, ANGLE_LIMIT, SWAY_BANDS, rng),
        width=_wander((widest + narrowest) / 2, (widest - narrowest) / 2, DRIFT_BANDS, rng),
        skew=_wander((high + low) / 2, (high - low) / 2, DRIFT_BANDS, rng),
        roll=_random_roll(rng),
        surge=_wander(0.0, SURGE_LIMIT, DRIFT_BANDS, rng),
        speed=float(rng.uniform(*SPEED_LIMITS)),
    )


def _wander(mean: float, limit: float, bands: Bands, rng: np.random.Generator) -> Signal:
    return Signal(mean, Harmonics.random(limit, bands, rng, SHARES))


def _random_roll(rng: np.random.Generator) -> Signal:
    return Signal(0.0, Harmonics.random(ROLL_LIMIT, ROLL_BANDS, rng))


def scenario_trajectory(scenario: Scenario, rng: np.random.Generator) -> Trajectory:
    """Draw the trajectory of a scenario, with the frame-to-frame variances that it asks for."""
    motion = scenario.motion
    times = np.arange(scenario.frame_count) / SCENARIO_RATE
    radian = float(np.deg2rad(1.0))
    pause = None
    if motion.stop is not None:
        first, last = (frame / SCENARIO_RATE for frame in motion.stop)
        pause = Pause(first, last, BRAKING_TIME)
    return Trajectory(
        distance=_random_signal(motion.distance, 1.0, times, rng),
        angle=_random_signal(motion.angle, radian, times, rng),
        width=_random_signal(motion.width, 1.0, times, rng),
        skew=_random_signal(motion.skew, radian, times, rng),
        roll=_random_roll(rng),
        surge=Signal(0.0, Harmonics.random(0.0, DRIFT_BANDS, rng)),
        speed=motion.speed,
        pause=pause,
    )


def _random_signal(
    motion: ComponentMotion, unit: float, times: FloatArray, rng: np.random.Generator
) -> Signal:
    """Draw a signal until its oscillation keeps within its limit; the calmest of many otherwise."""
    best, smallest = None, np.inf
    for _ in range(ATTEMPTS):
        signal = Signal(
            unit * motion.mean,
            Harmonics.random(unit * motion.limit, motion.bands, rng),
            tuple(replace(move, amount=unit * move.amount) for move in motion.moves),
            motion.strength,
        )
        if motion.variance is None:
            return signal
        signal = signal.with_increment_variance(unit**2 * motion.variance, times)
        reach = float(np.abs(signal.oscillation(times)).max())
        if reach < smallest:
            best, smallest = signal, reach
        if reach <= unit * motion.limit:
            break
    assert best is not None
    return best
