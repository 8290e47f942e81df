"""The bootstrap filter with the observation `responses`, compiled.

It keeps its particles in columns and its room from frame to frame, and leaves as little as it can
to Python. `NumpyBootstrapFilter` with the same parameters gives the same numbers, to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image, IndexArray
from cable_tracker.cable.compiled.bootstrap_filter import (
    look_at_points,
    predict,
    scan_frame,
    weigh_along_scan_lines,
)
from cable_tracker.cable.compiled.movement import BLOCK as MOVED_AT_ONCE
from cable_tracker.cable.compiled.movement import NOTHING
from cable_tracker.cable.compiled.scan_lines import project
from cable_tracker.cable.compiled.statistics import BLOCK
from cable_tracker.cable.measure.scan_lines import ScanPlan, scan_plan, table_step
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.geometry import image_to_pixel
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.movement import (
    CableMovement,
    effective_time,
    rate_damping_over,
    state_limits,
)
from cable_tracker.cable.model.state import PLACES, STATE_SIZE
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.cable.thesis.bootstrap_filter import Sight
from cable_tracker.cable.thesis.observation import scaled_filter, scattered_lines
from cable_tracker.particle_filter.compiled.resampling import invert_cumulative_weights
from cable_tracker.particle_filter.normal import uniform_rows
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import POSITIONS, RESAMPLING_SCHEMES
from cable_tracker.particle_filter.student_t import student_t_stretches


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """What movement over a certain time needs: numbers, and room for the random ones."""

    dt: float
    time: float
    damping: float
    sigmas: FloatArray
    uniforms: FloatArray
    normals: Image


class _Cloud:
    """Particles in columns, twice, so that the one can be made of the other."""

    def __init__(self, states: FloatArray, weights: FloatArray, moving: BoolArray) -> None:
        count = len(states)
        self.count = count
        self.now = np.ascontiguousarray(states.T, dtype=np.float64)
        self.next = np.zeros_like(self.now)
        self.weights = np.array(weights, dtype=np.float64)
        # A rate that is zero and does not change is left out everywhere.
        rates = self.now[PLACES:]
        self.still = (~moving[PLACES:] & (rates == 0.0).all(axis=1)).astype(np.float64)
        self.ancestors = np.empty(count, np.int64)
        self.cumulative = np.empty(count)
        self.lying = np.empty(2 * count, np.bool_)
        self.borders = np.empty((5, 2 * count), np.float32)
        self.deviations = np.zeros((STATE_SIZE + 1, BLOCK))

    def swap(self) -> None:
        """Make the new states the present ones."""
        self.now, self.next = self.next, self.now


@dataclass(frozen=True, slots=True, eq=False)
class _ScanRoom:
    """What looking along scan lines needs for frames of one size."""

    plan: ScanPlan
    heights: Image
    places: Image
    half: Image
    room: Image
    along_rows: Image
    along_columns: Image
    scattered: Image


@dataclass(frozen=True, slots=True, eq=False)
class _PointRoom:
    """What looking at points of their own needs for frames of one size."""

    spacing: float
    half: Image
    lines: FloatArray
    scattered: Image


class CompiledBootstrapFilter:
    """See `NumpyBootstrapFilter` for the meaning of the parameters; the observation is fixed."""

    def __init__(
        self,
        particles: Particles,
        parameters: TrackerParameters,
        image_width: int,
        rng: np.random.Generator,
    ) -> None:
        self._parameters = parameters
        self._rng = rng
        self._movement = CableMovement(parameters, image_width)
        self._limits = state_limits(parameters, image_width)
        self._reflects = parameters.limit_handling == "reflect"
        self._moving = self._movement.diffusion_sigmas(1.0) > 0.0
        self._step: _Step | None = None
        self._sizes: tuple[tuple[int, int], tuple[int, int]] | None = None
        self._room: _ScanRoom | _PointRoom | None = None
        self._cloud = _Cloud(particles.states, particles.weights, self._moving)
        weights = self._cloud.weights
        self._effective_size = float(weights.sum() ** 2 / (weights**2).sum())

    @property
    def particles(self) -> Particles:
        """The present belief, copied."""
        return Particles(self._cloud.now.T.copy(), np.log(self._cloud.weights))

    def resample(self, count: int) -> None:
        """Replace the particles by `count` equally weighted ones drawn from them."""
        scheme = RESAMPLING_SCHEMES[self._parameters.resampling]
        indices = scheme(self._cloud.weights, count, self._rng)
        states = self._cloud.now.T[indices]
        self._cloud = _Cloud(states, np.full(count, 1.0 / count), self._moving)
        self._effective_size = float(count)
        self._step = None

    def predict(self, dt: float, motion: MotionAid | None = None) -> None:
        """Resample if needed, and move every particle `dt` seconds ahead, as odometry says."""
        cloud = self._cloud
        ancestors = NOTHING
        if self._effective_size < self._parameters.resampling_threshold * cloud.count:
            ancestors = self._draw_ancestors()
        if motion is not None:
            self._predict_aided(ancestors, dt, motion)
            return
        step = self._step
        if step is None or step.dt != dt:
            step = self._step = self._make_step(dt)
        self._rng.random(out=step.uniforms)
        predict(
            cloud.now,
            ancestors,
            cloud.still,
            step.time,
            step.damping,
            step.uniforms,
            step.normals,
            student_t_stretches(self._rng, 2, cloud.count, self._movement.degrees_of_freedom),
            step.sigmas,
            self._limits.lower,
            self._limits.upper,
            self._reflects,
            cloud.next,
        )
        cloud.swap()

    def _predict_aided(self, ancestors: IndexArray, dt: float, motion: MotionAid) -> None:
        """Move the particles with the twin in NumPy: rates that stood still may move now."""
        cloud = self._cloud
        states = cloud.now.T if ancestors is NOTHING else cloud.now.T[ancestors]
        self._movement.aid_by(motion)
        moved = self._movement.propagate(np.ascontiguousarray(states), dt, self._rng)
        self._movement.aid_by(None)
        self._cloud = _Cloud(moved, cloud.weights, self._moving)
        self._step = None

    def look(self, image: WorkingImage) -> Sight:
        """Weigh every particle by a frame, and estimate."""
        if self._sizes != (image.frame_size, image.size):
            self._room = self._make_room(image)
            self._sizes = (image.frame_size, image.size)
        mean, covariance = np.empty(STATE_SIZE), np.empty((STATE_SIZE, STATE_SIZE))
        if isinstance(self._room, _ScanRoom):
            self._effective_size, evidence = self._look_along_lines(
                image, self._room, mean, covariance
            )
        else:
            assert self._room is not None
            self._effective_size, evidence = self._look_at_points(
                image, self._room, mean, covariance
            )
        return Sight(mean, covariance, self._effective_size, evidence)

    def _look_along_lines(
        self, image: WorkingImage, room: _ScanRoom, mean: FloatArray, covariance: FloatArray
    ) -> tuple[float, float]:
        cloud, plan, size = self._cloud, room.plan, image.size
        lying_count = project(cloud.now, size, image.reduction, cloud.lying, cloud.borders)
        scan_frame(
            _read_only(image.frame),
            size,
            plan.rows,
            plan.columns if lying_count else NOTHING,
            plan.grid,
            room.half,
            room.room,
            room.along_rows,
            room.along_columns,
            room.scattered,
        )
        return weigh_along_scan_lines(
            size,
            image.reduction,
            room.along_rows,
            room.heights,
            room.along_columns,
            room.places,
            table_step(image.scale),
            room.scattered,
            cloud.now,
            cloud.still,
            lying_count,
            cloud.lying,
            cloud.borders,
            self._parameters.epsilon,
            cloud.weights,
            cloud.deviations,
            mean,
            covariance,
        )

    def _look_at_points(
        self, image: WorkingImage, room: _PointRoom, mean: FloatArray, covariance: FloatArray
    ) -> tuple[float, float]:
        cloud = self._cloud
        return look_at_points(
            _read_only(image.pixels),
            image.frame_size,
            room.spacing,
            room.half,
            room.lines,
            room.scattered,
            cloud.now,
            cloud.still,
            cloud.borders,
            self._parameters.epsilon,
            cloud.weights,
            cloud.deviations,
            mean,
            covariance,
        )

    def _draw_ancestors(self) -> IndexArray:
        cloud, scheme = self._cloud, self._parameters.resampling
        if scheme in POSITIONS:
            positions = POSITIONS[scheme](cloud.count, self._rng)
            invert_cumulative_weights(cloud.weights, positions, cloud.cumulative, cloud.ancestors)
            ancestors = cloud.ancestors
        else:
            ancestors = RESAMPLING_SCHEMES[scheme](cloud.weights, cloud.count, self._rng)
        cloud.weights.fill(1.0 / cloud.count)
        return ancestors

    def _make_step(self, dt: float) -> _Step:
        sigmas = self._movement.diffusion_sigmas(dt)
        pairs = uniform_rows(int(np.count_nonzero(sigmas)))
        return _Step(
            dt=dt,
            time=effective_time(self._parameters, dt),
            damping=rate_damping_over(self._parameters, dt),
            sigmas=sigmas,
            uniforms=np.empty((pairs, self._cloud.count)),
            normals=np.empty((2 * pairs, MOVED_AT_ONCE), np.float32),
        )

    def _make_room(self, image: WorkingImage) -> _ScanRoom | _PointRoom:
        taps = scaled_filter(self._parameters, image.scale)
        half = taps[len(taps) // 2 + 1 :].astype(np.float32)
        if self._parameters.response_sampling == "scan_lines":
            return _make_scan_room(image, self._parameters.sample_spacing, half)
        points, angles = scattered_lines(image.frame_size)
        pixels = image_to_pixel(image.to_working(points), image.size)
        return _PointRoom(
            spacing=self._parameters.sample_spacing * image.frame_size[0] / REFERENCE_WIDTH,
            half=half,
            lines=np.column_stack((pixels, np.cos(angles), np.sin(angles))),
            scattered=np.empty(len(points), np.float32),
        )


def _make_scan_room(image: WorkingImage, sample_spacing: float, half: Image) -> _ScanRoom:
    plan = scan_plan(image.size, sample_spacing)
    width, height = image.size
    padded = max(width, height) + 2 * len(half)
    return _ScanRoom(
        plan=plan,
        heights=plan.heights.astype(np.float32),
        places=plan.places.astype(np.float32),
        half=half,
        room=np.empty(padded + max(image.frame_size), np.float32),
        along_rows=np.zeros((len(plan.rows), width + 1), np.float32),
        along_columns=np.zeros((len(plan.columns), height + 1), np.float32),
        scattered=np.empty(len(plan.grid), np.float32),
    )


def _read_only(frame: Image) -> Image:
    """Return a frame as one piece of memory that cannot be written to.

    Numba compiles anew for frames that can, and for such with gaps between their rows.
    """
    view = np.ascontiguousarray(frame).view()
    view.setflags(write=False)
    return view
