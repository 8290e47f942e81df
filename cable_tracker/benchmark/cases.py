"""What is timed: steps of the filters, whole frames, rivals, copies; and accuracy of methods."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.benchmark.footage import FRAME_STEP, SEED, Footage, FrameLoop, rendered_frames
from cable_tracker.benchmark.library_filters import LIBRARY_LOOPS, LibraryMethod, is_installed
from cable_tracker.benchmark.round_robin import BenchmarkCase, CaseLabel, Step
from cable_tracker.benchmark.yardstick import Yardstick
from cable_tracker.cable.filter_interface import BeliefSummary
from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.picture.working_image import WorkingImage, working_image_for
from cable_tracker.cable.model.geometry import Borders, points_on_lines, project_borders
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.cable.model.statistics import cable_mean_and_covariance
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.border_response_model import BorderResponseModel
from cable_tracker.cable.thesis.movement import LimitedMovement
from cable_tracker.evaluation.methods import BASELINES, METHODS, ConfiguredFilter, Method
from cable_tracker.evaluation.runs import MethodRun, Start, run_together
from cable_tracker.particle_filter.particles import RESAMPLING_SCHEMES, Particles
from cable_tracker.stamps import FIRST_STAMP
from cable_tracker.trackers import CableTracker, make_proposer
from cable_tracker.tracking.parameter_table import pixel_scale

TIMED_PRESETS = ("default", "thesis")
"""Presets that are timed; the others differ from `default` in limits and variances only."""

REFERENCE_PARTICLES = 500
SPACINGS = (5.0, 10.0, 20.0, 40.0)
"""Distances between sample points whose cost is compared [px at the reference width]."""

FRAMES_BEFORE_STEPS = 4
"""Frames that a filter has processed when its steps are timed."""

DT = FRAME_STEP * 1e-9


def _identity(step: Step) -> Step:
    return step


def _loop(make: Callable[[], Method], shown: Footage) -> Step:
    return FrameLoop(make(), shown)


def yardstick_case(yardstick: Yardstick) -> BenchmarkCase:
    """Return the yardstick as a case of its own."""
    size = yardstick.pixels.shape[1], yardstick.pixels.shape[0]
    label = CaseLabel("yardstick", "literal observation", size, len(yardstick.states))
    return BenchmarkCase(label, functools.partial(_identity, yardstick))


def copy_cases(yardstick: Yardstick, footages: Sequence[Footage]) -> list[BenchmarkCase]:
    """Return plain copies of each size of frame, and of as many pixels as the yardstick reads."""
    named = [("frame, uint8", shown.size, shown.images[0]) for shown in footages]
    touched = np.ones(yardstick.pixels_touched(), np.float32)
    named.append(("pixels that the yardstick reads, float32", footages[0].size, touched))
    cases = []
    for name, size, source in named:
        step = functools.partial(np.copyto, np.empty_like(source), source)
        label = CaseLabel("copy", name, size, amount=float(source.nbytes))
        cases.append(BenchmarkCase(label, functools.partial(_identity, step)))
    return cases


def frame_cases(footages: Sequence[Footage], particles: Sequence[int]) -> list[BenchmarkCase]:
    """Return `default` and `thesis` on whole frames, the fewest particles first."""
    return [
        filter_case("frame", name, count, shown)
        for shown in footages
        for name in TIMED_PRESETS
        for count in sorted(particles)
    ]


def spacing_cases(shown: Footage) -> list[BenchmarkCase]:
    """Return `default` and `thesis` with several distances between the sample points."""
    return [
        filter_case("spacing", name, REFERENCE_PARTICLES, shown, spacing)
        for name in TIMED_PRESETS
        for spacing in SPACINGS
    ]


def filter_case(
    section: str,
    name: str,
    count: int,
    shown: Footage,
    spacing: float | None = None,
) -> BenchmarkCase:
    """Return a preset on whole frames, perhaps with another distance between sample points."""
    values: dict[str, object] = {"particle_count": count}
    amount = 0.0
    if spacing is not None:
        values["sample_spacing"] = spacing
        amount = count * points_of_a_cable(shown, spacing)
    chosen = ConfiguredFilter(name, preset(name).replaced(values))
    label = CaseLabel(section, name, shown.size, count, amount)
    return BenchmarkCase(label, functools.partial(_loop, functools.partial(chosen.make, 0), shown))


def points_of_a_cable(shown: Footage, spacing: float) -> float:
    """Return the number of sample points on both borders inside the image, as a mean over truths.

    `spacing` is in px at the reference width.
    """
    borders = project_borders(np.array([truth.to_array() for truth in shown.truths]))
    width = shown.size[0]
    _, inside = sample_points(borders, spacing * pixel_scale(width), shown.size)
    return float(inside.sum(axis=(1, 2)).mean())


def sample_points(
    borders: Borders, spacing: float, image_size: tuple[int, int]
) -> tuple[FloatArray, BoolArray]:
    """Place points along each border, at equal distances from the border's own foot point.

    Parameters
    ----------
    borders : Borders
        N pairs of borders.
    spacing : float
        Distance between neighbours [px].
    image_size : (int, int)
        Width and height of the image [px].

    Returns
    -------
    points : FloatArray
        x, y in the image frame [px], shape (N, 2, M, 2); M is odd and the same for all borders.
    inside : BoolArray
        Whether the point lies inside the image, shape (N, 2, M).
    """
    width, height = image_size
    reach = int(np.hypot(width, height) / 2 / spacing)
    along = np.arange(-reach, reach + 1, dtype=np.float64) * spacing
    points = points_on_lines(borders.angles, borders.offsets, along)
    inside = (np.abs(points[..., 0]) <= (width - 1) / 2) & (
        np.abs(points[..., 1]) <= (height - 1) / 2
    )
    return points, inside


def rival_cases(shown: Footage) -> list[BenchmarkCase]:
    """Return the baselines of the evaluation, and the filter of the thesis on libraries."""
    cases = [
        BenchmarkCase(
            CaseLabel("method", name, shown.size),
            functools.partial(_loop, functools.partial(METHODS[name].make, 0), shown),
        )
        for name in BASELINES
    ]
    for name in LIBRARY_LOOPS:
        if is_installed(name):
            make = functools.partial(LibraryMethod, name, REFERENCE_PARTICLES)
            label = CaseLabel("library", name, shown.size, REFERENCE_PARTICLES)
            cases.append(BenchmarkCase(label, functools.partial(_loop, make, shown)))
    return cases


def step_cases(shown: Footage) -> list[BenchmarkCase]:
    """Return the steps of `default` and `thesis` that can be called alone."""
    cases = []
    for name in TIMED_PRESETS:
        parameters = preset(name).replaced({"particle_count": REFERENCE_PARTICLES})
        for step_name, step in FilterSteps(parameters, shown).steps().items():
            label = CaseLabel("step", f"{name}: {step_name}", shown.size, REFERENCE_PARTICLES)
            cases.append(BenchmarkCase(label, functools.partial(_identity, step)))
    return cases


@dataclass(frozen=True, slots=True, eq=False)
class FilterSnapshot:
    """Particles and picture of a filter after some frames of a dive.

    Attributes
    ----------
    particles : Particles
        Particles before the step.
    frame : Image
        Last frame, grey levels, uint8, shape (H, W).
    image : WorkingImage
        The same frame, with all results of its preprocessing.
    """

    particles: Particles
    frame: Image
    image: WorkingImage


class _SnapshotTracker(CableTracker):
    """A tracker that keeps the last working image of its filter."""

    last_image: WorkingImage

    def _step_filter(
        self, image: WorkingImage, dt: float, motion: MotionAid | None
    ) -> BeliefSummary:
        self.last_image = image
        return super()._step_filter(image, dt, motion)


def snapshot_after(parameters: TrackerParameters, shown: Footage, frames: int) -> FilterSnapshot:
    """Track some frames, and return the state of the filter."""
    tracker = _SnapshotTracker(parameters)
    # Beside a known cable no detector would be asked: a guess is known after a while only.
    tracker.initialise(GivenState.around(shown.truths[0], is_guess=True))
    for number in range(frames):
        frame = shown.images[shown.index_at(number)]
        tracker.process(frame, FIRST_STAMP + number * FRAME_STEP)
    assert tracker.particles is not None
    return FilterSnapshot(tracker.particles, frame, tracker.last_image)


class FilterSteps:
    """The steps of a filter that can be called alone, on one frame and its particles.

    Parameters
    ----------
    parameters : TrackerParameters
        Parameters of the filter.
    shown : Footage
        Its first frames are tracked before.
    """

    def __init__(self, parameters: TrackerParameters, shown: Footage) -> None:
        self._parameters = parameters
        self._rng = np.random.default_rng(parameters.seed)
        self._width = shown.size[0]
        self._snapshot = snapshot_after(parameters, shown, FRAMES_BEFORE_STEPS)
        self._movement = LimitedMovement(parameters, self._width)

    def steps(self) -> dict[str, Step]:
        """Return the steps by name, in their order within a frame."""
        frame, particles = self._snapshot.frame, self._snapshot.particles
        scheme = RESAMPLING_SCHEMES[self._parameters.resampling]
        measuring = (
            self._thesis_steps()
            if self._parameters.observation == "responses"
            else self._default_steps()
        )
        return {
            "working image": lambda: working_image_for(frame, self._parameters),
            **self.preprocessing_steps(),
            "resample": lambda: scheme(particles.weights, particles.count, self._rng),
            "predict": lambda: self._movement.propagate(particles.states, DT, self._rng),
            **measuring,
        }

    def preprocessing_steps(self) -> dict[str, Step]:
        """Return the steps of preprocessing that the filter used, each from the bare picture."""
        image = self._snapshot.image
        names = [
            name
            for name, member in vars(type(image)).items()
            if isinstance(member, functools.cached_property) and vars(image).get(name) is not None
        ]
        return {
            f"picture: {name}": functools.partial(_computed_anew, image, name) for name in names
        }

    def _thesis_steps(self) -> dict[str, Step]:
        image = self._snapshot.image
        observation = BorderResponseModel(self._parameters)
        states, weights = self._snapshot.particles.states, self._snapshot.particles.weights
        mean, _ = cable_mean_and_covariance(states, weights)
        return {
            "measure": lambda: observation.log_likelihoods(states, image),
            "estimate": lambda: cable_mean_and_covariance(states, weights),
            "evidence": lambda: observation.evidence(mean, image),
        }

    def _default_steps(self) -> dict[str, Step]:
        image = self._snapshot.image
        observation = BorderLikelihoodRatio(self._parameters)
        states = self._snapshot.particles.states
        proposer = make_proposer(self._parameters)
        detecting: dict[str, Step] = {}
        if proposer is not None:
            detecting = {
                "detector": lambda: proposer.propose(image, is_searching=False),
                "detector, searching": lambda: proposer.propose(image, is_searching=True),
            }
        return {
            **detecting,
            "measure": lambda: observation.measure(states, image),
        }


def _computed_anew(image: WorkingImage, name: str) -> object:
    # A replaced working image has no cached results yet.
    return getattr(replace(image), name)


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Accuracy of a method on the frames of the benchmark, started from the truth.

    Attributes
    ----------
    name : str
        Name of the method or library.
    lost : float
        Share of the frames in which the estimate is beside the cable [%].
    rmse_d, rmse_alpha : float
        Root mean square error of d [px] and alpha [deg].
    """

    name: str
    lost: float
    rmse_d: float
    rmse_alpha: float


def measure_accuracy(frame_count: int) -> list[Accuracy]:
    """Track the frames at 320x240 with every method and every installed library."""
    makers: dict[str, Callable[[int], Method]] = {name: spec.make for name, spec in METHODS.items()}
    for name in filter(is_installed, LIBRARY_LOOPS):
        makers[name] = functools.partial(LibraryMethod, name, REFERENCE_PARTICLES)
    runs = [MethodRun(name, make, SEED, Start.TRUTH) for name, make in makers.items()]
    results = run_together(runs, rendered_frames(frame_count), "benchmark")
    return [
        Accuracy(
            result.method,
            *(result.metrics[m] for m in ("lost", "rmse_d", "rmse_alpha")),
        )
        for result in results
    ]
