"""Worlds: coat and cover of the cable, disturbances and optics; and the built-in ones.

Each built-in kind is there once to tune on and once to report on.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from types import MappingProxyType

from cable_tracker.simulation.worlds.motion import MotionKind

Range = tuple[float, float]
"""Lowest and highest value, between which a dive draws its own."""

NONE: Range = (0.0, 0.0)


class Split(str, Enum):
    """Purpose of a world. The worlds of the two splits share nothing."""

    TUNE = "tune"
    """Constants and tables are chosen on it."""

    REPORT = "report"
    """Nothing is chosen on it: figures in reports come from it."""

    @property
    def number(self) -> int:
        """Entropy of the split in the seeds of its dives."""
        return 1 if self is Split.TUNE else 2


@dataclass(frozen=True, slots=True)
class Cover:
    """Cover that hides a cable.

    Attributes
    ----------
    growth : Range
        Share of the cable that growth that resembles the bottom covers, 0 to 1; it also stands
        out over the borders.
    drift : Range
        Share of the cable's length along which sand lies over one of its borders, 0 to 1.
    drift_lengths : Range
        Length of such a stretch [radii].
    silt : Range
        Share of the cable's contrast that a film takes away in some places, 0 to 1.
    """

    growth: Range = NONE
    drift: Range = NONE
    drift_lengths: Range = (4.0, 14.0)
    silt: Range = NONE


@dataclass(frozen=True, slots=True)
class Coat:
    """Surface of a cable where nothing covers it.

    Attributes
    ----------
    roughness : Range
        Standard deviation of its own texture over that of the bottom.
    roundness : Range
        How much more contrast the middle has than the borders, as a share of the step.
    limbs : Range
        How much darker than the line that faces the lamp it gets where it bends away [standard
        deviations of the bottom].
    lamp : Range
        Where that line lies [radii from the axis].
    armour : Range
        Contrast of wires around it (to tune on) or of collars on it (to report on) [standard
        deviations of the bottom].
    raggedness : Range
        Standard deviation of its borders from straight lines [radii].
    """

    roughness: Range = (0.15, 0.6)
    roundness: Range = (0.0, 0.4)
    limbs: Range = NONE
    lamp: Range = NONE
    armour: Range = NONE
    raggedness: Range = NONE


@dataclass(frozen=True, slots=True)
class Disturbance:
    """Disturbances in the picture besides the cable.

    Attributes
    ----------
    shadow : float
        Probability that the cable casts a shadow as dark as a dark cable beside it, 0 to 1.
    lines : float
        Ropes, furrows, tracks and rocks in view on average.
    pairs : float
        Trenches and pairs of lines in view on average.
    bars : float
        Probability of black bars above and below or on both sides, 0 to 1.
    caption : float
        Probability of written figures in a corner.
    vehicle_part : float
        Probability of a part of the vehicle in view.
    crosshair : float
        Probability of a crosshair that a survey display draws across the picture.
    """

    shadow: float = 0.0
    lines: float = 0.0
    pairs: float = 0.0
    bars: float = 0.0
    caption: float = 0.0
    vehicle_part: float = 0.0
    crosshair: float = 0.0


@dataclass(frozen=True, slots=True)
class Optics:
    """Effects of light, water and camera on the picture.

    Attributes
    ----------
    lamps : Range
        Unevenness of the light of the vehicle's lamps, 0 (even) to 1.
    sway : Range
        How far the light of the lamps sways over the picture, as the vehicle heaves and pitches [px
        at 320 px].
    vignette : Range
        Darkening of the corners, 0 to 1.
    haze : Range
        Loss of contrast at the far end of the view, 0 to 1.
    blur : Range
        Standard deviation of the blur [px at 320 px].
    noise : Range
        Standard deviation of the sensor's noise [grey levels].
    quality : Range or None
        Quality of the compression, 1 to 100; None: not compressed. Half of the dives are compressed
        picture by picture, half as differences from the picture before.
    """

    lamps: Range = (0.0, 0.6)
    sway: Range = NONE
    vignette: Range = (0.0, 0.5)
    haze: Range = (0.0, 0.4)
    blur: Range = (0.4, 1.2)
    noise: Range = (1.5, 4.0)
    quality: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class World:
    """A kind of dive. Each seed draws one.

    Attributes
    ----------
    name : str
        Begins with the name of its split.
    description : str
        Difficulty of the world, in a few words.
    split : Split
        Split: the splits have no texture, no seed and no kind of clutter in common.
    photographed : bool
        Whether the bottom is made of photographs.
    motions : tuple of MotionKind
        One of them is drawn.
    widths : Range or None
        See `random_motion`.
    angles : Range
        Mean angle, if `widths` are given [deg].
    contrast : Range
        Step at the borders over the standard deviation of the bottom, drawn uniformly in its
        logarithm; half of the cables are dark.
    turning : float
        Probability that the cable is bright in places and dark in others.
    bands : Range or None
        Length of the bright and dark bands of the cable [radii]; None: it has none.
    coat : Coat
        Of the cable.
    cover : Cover
        On the cable.
    disturbance : Disturbance
        Around it.
    optics : Optics
        Before it.
    has_cable : bool
        Whether there is any.
    frame_count : int
        At `WORLD_RATE`.
    """

    name: str
    description: str
    split: Split
    photographed: bool = False
    motions: tuple[MotionKind, ...] = (MotionKind.INSPECTION, MotionKind.LIVELY)
    widths: Range | None = (10.0, 110.0)
    angles: Range = (-35.0, 35.0)
    contrast: Range = (1.8, 5.0)
    turning: float = 0.0
    bands: Range | None = None
    coat: Coat = Coat()
    cover: Cover = Cover()
    disturbance: Disturbance = Disturbance()
    optics: Optics = Optics()
    has_cable: bool = True
    frame_count: int = 250


_FAINT = (0.7, 3.2)
_CLEAR = (2.5, 5.5)
_INSPECTED = (MotionKind.INSPECTION,)


_kind = partial(World, split=Split.TUNE)

_KINDS = (
    _kind(
        "clear",
        "clear cables, little around them",
        contrast=_CLEAR,
        disturbance=Disturbance(lines=0.3),
    ),
    _kind(
        "faint",
        "faint, overgrown cables, some bright here and dark there",
        contrast=_FAINT,
        turning=0.3,
        cover=Cover(growth=(0.0, 0.4), drift=(0.0, 0.3), silt=(0.0, 0.5)),
        disturbance=Disturbance(lines=0.7),
    ),
    _kind(
        "inspection",
        "clear pipes over real sea bed, seen as inspections by ROV see them",
        photographed=True,
        motions=_INSPECTED,
        widths=None,
        contrast=_CLEAR,
    ),
    _kind(
        "inspection_hard",
        "pipes over real sea bed with growth, sand and shadows",
        photographed=True,
        motions=_INSPECTED,
        widths=None,
        contrast=(1.2, 3.5),
        turning=0.2,
        cover=Cover(growth=(0.1, 0.45), drift=(0.0, 0.4), silt=(0.0, 0.4)),
        disturbance=Disturbance(shadow=0.7, lines=0.5),
    ),
    _kind(
        "shadows",
        "shadows as dark as a dark cable beside the cable, uneven lamps that sway",
        contrast=(1.5, 4.0),
        disturbance=Disturbance(shadow=1.0, lines=0.4),
        optics=Optics(lamps=(0.3, 0.9), sway=(0.0, 30.0), vignette=(0.2, 0.7)),
    ),
    _kind(
        "sand",
        "sand over one border for a long way",
        contrast=(1.5, 4.0),
        cover=Cover(drift=(0.4, 0.8), drift_lengths=(8.0, 40.0)),
        disturbance=Disturbance(lines=0.3),
    ),
    _kind(
        "round",
        "a lit middle and dark limbs, armour, rough and ragged cables, thin ones too",
        widths=(5.0, 110.0),
        angles=(-90.0, 90.0),
        contrast=(1.5, 4.5),
        coat=Coat(
            roughness=(0.3, 1.5),
            limbs=(0.0, 4.0),
            lamp=(-0.8, 0.8),
            armour=(0.0, 1.5),
            raggedness=(0.0, 0.1),
        ),
        cover=Cover(growth=(0.0, 0.2)),
        disturbance=Disturbance(lines=0.3),
    ),
    _kind(
        "bars",
        "black bars, captions, a part of the vehicle in view",
        contrast=(1.8, 4.5),
        disturbance=Disturbance(lines=0.3, bars=1.0, caption=0.5, vehicle_part=0.4),
    ),
    _kind(
        "compressed",
        "strong compression, picture by picture or as a video",
        contrast=(1.5, 4.0),
        disturbance=Disturbance(lines=0.3),
        optics=Optics(quality=(12, 45)),
    ),
    _kind(
        "empty",
        "no cable: real sea bed alone",
        photographed=True,
        has_cable=False,
    ),
    _kind(
        "decoys",
        "no cable, but single and double lines, trenches, glaring rocks",
        has_cable=False,
        disturbance=Disturbance(lines=1.5, pairs=1.5, bars=0.2),
    ),
    _kind(
        "display",
        "a survey display's crosshair through the picture, captions",
        contrast=(1.5, 4.0),
        disturbance=Disturbance(lines=0.3, crosshair=1.0, caption=0.7),
        optics=Optics(quality=(50, 90)),
    ),
    _kind(
        "display_empty",
        "no cable, but a survey display's crosshair through the picture, captions",
        has_cable=False,
        disturbance=Disturbance(crosshair=1.0, caption=0.7),
        optics=Optics(quality=(50, 90)),
    ),
    _kind(
        "banded",
        "cables painted in bright and dark bands",
        contrast=(1.8, 5.0),
        bands=(3.0, 9.0),
        cover=Cover(growth=(0.0, 0.2)),
        disturbance=Disturbance(lines=0.3),
    ),
)
"""Worlds of each kind; `_all` makes one of each split of them."""


def _all() -> Iterator[World]:
    for split in Split:
        for kind in _KINDS:
            yield replace(kind, name=f"{split.value}_{kind.name}", split=split)


WORLDS: Mapping[str, World] = MappingProxyType({world.name: world for world in _all()})
"""All worlds by name; names begin with the purpose of the world, `tune_` or `report_`."""


def worlds_of(split: Split) -> tuple[World, ...]:
    """Return the worlds of a split."""
    return tuple(world for world in WORLDS.values() if world.split is split)
