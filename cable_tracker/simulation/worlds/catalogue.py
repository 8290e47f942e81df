"""The built-in worlds, by name: each kind once to tune on and once to report on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType

from cable_tracker.simulation.dive import SimulatedFrame
from cable_tracker.simulation.worlds.motion import MotionKind
from cable_tracker.simulation.worlds.world import Coat, Cover, Disturbance, Optics, Split, World
from cable_tracker.simulation.worlds.world_dive import WORLD_SIZE, WorldDive
from cable_tracker.tracking.parameter_table import named

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


def simulate_world(
    world: str | World, seed: int = 0, image_size: tuple[int, int] = WORLD_SIZE
) -> Iterator[SimulatedFrame]:
    """Yield the frames of a dive through a world at 25 frames per second, always the same.

    Parameters
    ----------
    world : str or World
        One of `WORLDS`, or one's own.
    seed : int
        Not negative; each is another dive.
    image_size : (int, int)
        Width and height [px].

    Raises
    ------
    ParameterError
        There is no world of that name, the seed is negative, or images cannot have that size.
    RecordingError
        The world needs photographs, and there are none.
    """
    if isinstance(world, str):
        world = named("world", world, WORLDS)
    return WorldDive(world, seed, image_size).frames()
