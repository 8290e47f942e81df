"""Cables on the sea bed: tubes along a course, rays that pass them, their surface, sand on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.simulation.rendering.appearance import Skin
from cable_tracker.simulation.rendering.seabed import CABLE_REACH, CHANNELS, burial_cover
from cable_tracker.simulation.rendering.texture import TiledTexture, smooth_step

SETTLED = 0.7
"""Height of a cable's axis above the bottom [radii]: it has sunk in a little."""

LEAST_DISTANCE = 0.05
"""Smallest distance from the eye at which a line of sight passes a tube [m]."""

BENDS = 2
"""Number of waves that a random course is the sum of."""

SAND_DEPTH = 9.0
"""Height that a buried stretch adds to the level of the sand."""

GAP_SPACING = 160.0
"""Mean distance between two gaps at full cover [radii]."""


@dataclass(frozen=True, slots=True)
class Bend:
    """One sinusoid of a centreline.

    Attributes
    ----------
    amplitude : float
        [m].
    wavenumber : float
        [rad/m].
    phase : float
        [rad].
    """

    amplitude: float
    wavenumber: float
    phase: float


@dataclass(frozen=True, slots=True)
class Tube:
    """A cable of constant radius whose centreline wanders gently about a straight course.

    Its own coordinates are a (across the course, to the right), s (along the course) and the
    height, all in metres. The axis is at a = sum of the bends at s.

    Attributes
    ----------
    radius : float
        [m].
    bends : tuple of Bend
        None for a straight cable.
    origin : (float, float)
        Start of the course in the world, x and y [m].
    heading : float
        Direction of the course, to the left of the world's y [rad].
    """

    radius: float
    bends: tuple[Bend, ...] = ()
    origin: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0

    @property
    def height(self) -> float:
        """Height of the axis above the bottom [m]."""
        return SETTLED * self.radius

    def axis(self, along: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the points of the axis and its directions in the world, each (..., 3)."""
        offset, slope = np.zeros_like(along), np.zeros_like(along)
        for bend in self.bends:
            phase = bend.wavenumber * along + bend.phase
            offset += bend.amplitude * np.sin(phase)
            slope += bend.amplitude * bend.wavenumber * np.cos(phase)
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        x = self.origin[0] + offset * cos - along * sin
        y = self.origin[1] + offset * sin + along * cos
        points = np.stack((x, y, np.full_like(x, self.height)), axis=-1)
        length = np.sqrt(1 + slope * slope)
        directions = np.stack(
            ((slope * cos - sin) / length, (slope * sin + cos) / length, np.zeros_like(x)), axis=-1
        )
        return points, directions

    def silhouette(self, eyes: FloatArray, along: FloatArray) -> FloatArray:
        """Return the points at which lines of sight touch the tube.

        Parameters
        ----------
        eyes : FloatArray
            Positions of the camera in the world, shape (N, 3) [m].
        along : FloatArray
            Position along the course, shape (N, K) [m].

        Returns
        -------
        FloatArray
            World points of the left and the right border, shape (N, 2, K, 3) [m].
        """
        centres, directions = self.axis(along)
        towards = eyes[:, None, :] - centres
        towards -= np.sum(towards * directions, axis=-1, keepdims=True) * directions
        distance = np.linalg.norm(towards, axis=-1, keepdims=True)
        towards = towards / distance
        aside = np.cross(directions, towards)
        share = np.minimum(self.radius / distance, 1.0)
        lift, reach = self.radius * share * towards, self.radius * np.sqrt(1 - share**2) * aside
        return np.stack((centres + lift - reach, centres + lift + reach), axis=1)

    def closest_approach(self, eye: FloatArray, rays: Image) -> ClosestApproach:
        """Return the closest approach of lines of sight to the tube's axis.

        Parameters
        ----------
        eye : FloatArray
            Position of the camera in the world, shape (3,) [m].
        rays : Image
            Directions in the world, shape (3, ...), all downwards.
        """
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        x, y = eye[0] - self.origin[0], eye[1] - self.origin[1]
        eye_across, eye_along = x * cos + y * sin, y * cos - x * sin
        ray_x, ray_y, ray_z = rays
        if self.heading != 0.0:
            kind = rays.dtype.type
            ray_x, ray_y = (
                ray_x * kind(cos) + ray_y * kind(sin),
                ray_y * kind(cos) - ray_x * kind(sin),
            )
        drop = float(self.height - eye[2])
        reach = drop / ray_z
        across, along = reach * ray_x, reach * ray_y
        offset, slope = self._wander(along, eye_across, eye_along)
        # One step along the normal of the centreline leads close enough to the foot point.
        along = along + slope * (across - offset) / (1 + slope * slope)
        offset, slope = self._wander(along, eye_across, eye_along)
        length = np.sqrt(1 + slope * slope)
        u_x, u_y = slope / length, 1 / length
        # The common normal of ray and axis is ray x axis; its dot product with the way from the
        # axis to the eye is their distance.
        m_x, m_y, m_z = -ray_z * u_y, ray_z * u_x, ray_x * u_y - ray_y * u_x
        norm = np.sqrt(m_x * m_x + m_y * m_y + m_z * m_z)
        passing = -(offset * m_x + along * m_y + drop * m_z) / norm
        square = ray_x * ray_x + ray_y * ray_y + ray_z * ray_z
        parallel = ray_x * u_x + ray_y * u_y
        ray_eye = -(ray_x * offset + ray_y * along + ray_z * drop)
        axis_eye = -(u_x * offset + u_y * along)
        forward = (square * axis_eye - parallel * ray_eye) / (norm * norm)
        distance = (parallel * axis_eye - ray_eye) / (norm * norm) * np.sqrt(square)
        p = passing / self.radius
        front = self.radius * np.sqrt(np.maximum(1 - p * p, 0)) / norm
        q = (along + (forward - front * parallel) * u_y) / self.radius
        # Towards the horizon the tangent is extended so far that it may come past the eye.
        distance = np.maximum(distance, rays.dtype.type(LEAST_DISTANCE))
        return ClosestApproach(p, q, eye_along / self.radius, distance)

    def _wander(self, along: Image, eye_across: float, eye_along: float) -> tuple[Image, Image]:
        """Return offset of the axis from the eye, and slope, at places relative to the eye."""
        kind = along.dtype.type
        offset = np.full_like(along, -eye_across)
        slope = np.zeros_like(along)
        for bend in self.bends:
            start = kind((bend.wavenumber * eye_along + bend.phase) % (2 * np.pi))
            phase = along * kind(bend.wavenumber) + start
            offset += kind(bend.amplitude) * np.sin(phase)
            slope += kind(bend.amplitude * bend.wavenumber) * np.cos(phase)
        return offset, slope


@dataclass(frozen=True, slots=True, eq=False)
class ClosestApproach:
    """Where lines of sight are nearest to the axis of a tube; arrays of one shape.

    Attributes
    ----------
    p : Image
        Distance between line of sight and axis, to the right positive [radii]: the tube is hit
        where it is between -1 and 1.
    q : Image
        Position along the course, from `start` [radii].
    start : float
        The course's coordinate of the eye [radii], which may be large.
    distance : Image
        Distance from the eye to where the line of sight is nearest to the axis [m].
    """

    p: Image
    q: Image
    start: float
    distance: Image


def random_bends(
    curvature: float, lengths: tuple[float, float], rng: np.random.Generator
) -> tuple[Bend, ...]:
    """Draw bends whose sum never curves more than `curvature` [1/m].

    `lengths` are the shortest and the longest wavelength [m].
    """
    wavenumbers = 2 * np.pi / rng.uniform(*lengths, BENDS)
    phases = rng.uniform(0.0, 2 * np.pi, BENDS)
    return tuple(
        Bend(float(curvature / BENDS / k**2), float(k), float(phase))
        for k, phase in zip(wavenumbers, phases, strict=True)
    )


@dataclass(frozen=True, slots=True)
class Stretch:
    """Stretch along the course of a cable: its start and end [m]."""

    start: float
    end: float

    def holds(self, along: FloatArray) -> BoolArray:
        """Return which places along the course [m] are within it, a mask of the same shape."""
        return np.asarray((along >= self.start) & (along <= self.end))


@dataclass(frozen=True, slots=True)
class BuriedStretch(Stretch):
    """A stretch of a cable that the sand hides altogether, or where it is missing.

    Attributes
    ----------
    ramp : float
        Way over which the sand rises before and falls after that [m].
    """

    ramp: float

    def level(self, along: Image) -> Image:
        """Return the summand of the sand level at places [m], of the same shape."""
        rising = smooth_step(along, self.start - self.ramp, self.start)
        return SAND_DEPTH * (rising - smooth_step(along, self.end, self.end + self.ramp))


@dataclass(frozen=True, slots=True, eq=False)
class CableSkin:
    """Surface of a cable where lines of sight meet it; arrays of one shape, 0 to 1.

    Attributes
    ----------
    surface, growth, growth_tone : Image
        Reflected light of the bare cable, cover and reflected light of what grows there.
    burial : Image
        Cover of sand.
    turf : Image
        Cover of growth and sediment that look like the bottom.
    outline : Image
        Distance of the visible border outside that of the bare cable [radii].
    shade : float
        Strength of the shadows beside the cable.
    """

    surface: Image
    growth: Image
    growth_tone: Image
    burial: Image
    turf: Image
    outline: Image
    shade: float

    def is_covered(self) -> BoolArray:
        """Return where growth, turf or sand cover the cable, a mask of the arrays' shape."""
        return np.asarray(np.maximum(np.maximum(self.growth, self.turf), self.burial) > 0.5)


@dataclass(frozen=True, slots=True, eq=False)
class LaidCable:
    """A cable with its surface.

    Attributes
    ----------
    tube : Tube
        Course of the cable.
    texture : TiledTexture
        See `seabed.make_cable`.
    stretches : tuple of BuriedStretch
        Buried stretches besides the patches of sand in the texture.
    shade : float
        Strength of the shadows beside it, 0 to 1.
    """

    tube: Tube
    texture: TiledTexture
    stretches: tuple[BuriedStretch, ...] = ()
    shade: float = 1.0

    def skin(self, approach: ClosestApproach, footprint: Image) -> CableSkin:
        """Return the surface where lines of sight meet it, sampled from the texture.

        Parameters
        ----------
        approach : ClosestApproach
            Of lines of sight to the axis, float32, shape (H, W).
        footprint : Image
            Extent of one pixel, of the same shape [radii].
        """
        across = np.clip(approach.p, 0.01 - CABLE_REACH, CABLE_REACH - 0.01) + np.float32(
            CABLE_REACH
        )
        texels = self.texture.sample(across, approach.q, approach.start, footprint)
        extra = np.zeros_like(approach.q)
        along = approach.q * np.float32(self.tube.radius)
        eye = float(approach.start * self.tube.radius)
        first, last = float(along.min()) + eye, float(along.max()) + eye
        for stretch in self.stretches:
            if stretch.start - stretch.ramp < last and stretch.end + stretch.ramp > first:
                here = BuriedStretch(stretch.start - eye, stretch.end - eye, stretch.ramp)
                extra += here.level(along)
        return CableSkin(
            surface=texels[..., CHANNELS.surface],
            # Where stretches overlap, their levels add up to more than hides everything.
            growth=texels[..., CHANNELS.growth]
            * (1 - np.minimum(extra, np.float32(SAND_DEPTH)) * np.float32(1 / SAND_DEPTH)),
            growth_tone=texels[..., CHANNELS.growth_tone],
            burial=burial_cover(texels[..., CHANNELS.sand] + extra),
            turf=texels[..., CHANNELS.turf],
            outline=texels[..., CHANNELS.outline],
            shade=self.shade,
        )


def random_gaps(
    start: float, end: float, radius: float, skin: Skin, rng: np.random.Generator
) -> tuple[BuriedStretch, ...]:
    """Draw short gaps in a cable between `start` and `end` [m]."""
    length = max(end - start, 0.0)
    count = int(rng.poisson(length / radius / GAP_SPACING * skin.cover))
    return tuple(
        BuriedStretch(float(place), float(place + extent), 0.2 * radius)
        for place, extent in zip(
            np.sort(rng.uniform(start, end, count)),
            radius * rng.uniform(*skin.gap_lengths, count),
            strict=True,
        )
    )
