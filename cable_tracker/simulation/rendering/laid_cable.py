"""A cable on the sea bed: a tube with a surface, growth, and sand over part of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.simulation.rendering.appearance import Skin
from cable_tracker.simulation.rendering.seabed import CABLE_REACH, CHANNELS, burial_cover
from cable_tracker.simulation.rendering.texture import TiledTexture, smooth_step
from cable_tracker.simulation.rendering.tube import ClosestApproach, Tube

SAND_DEPTH = 9.0
"""Height that a buried stretch adds to the level of the sand."""

GAP_SPACING = 160.0
"""Mean distance between two gaps at full cover [radii]."""


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
