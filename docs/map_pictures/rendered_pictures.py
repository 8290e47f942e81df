"""The training pictures of the map's network, rendered once into files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, eight_bits
from cable_tracker.cable.measure.map.map_network import CELL
from cable_tracker.cable.measure.picture.overlays import without_dead_margins
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.simulation.dive import SimulatedFrame
from cable_tracker.simulation.worlds.catalogue import WORLDS, Coat, World
from cable_tracker.simulation.worlds.strip import simulate_strip
from cable_tracker.simulation.worlds.world_dive import WORLD_SIZE, simulate_world
from map_pictures.lamplit_scenes import lamplit_frame
from map_pictures.surface import ANY_ANGLE, ANY_WIDTH

STRIPS = "strips"
"""Crisp strips on a plain ground."""

DIVES = {
    "tune_clear": 600,
    "tune_faint": 5000,
    "tune_inspection": 1200,
    "tune_inspection_hard": 5000,
    "tune_shadows": 2000,
    "tune_sand": 1000,
    "tune_round": 2500,
    "tune_bars": 1200,
    "tune_compressed": 800,
    "tune_empty": 1000,
    "tune_decoys": 2000,
    "tune_banded": 2000,
    "tune_display": 600,
    STRIPS: 2500,
}
"""Number of dives through each world; of each the second frame is used."""

FIRST_SEED = 10_000
"""Seed of the first dive: far from those that the filter is tuned on."""

DIVES_AT_ONCE = 100

ANY_COAT = Coat(
    roughness=(0.1, 2.0),
    roundness=(0.0, 0.4),
    limbs=(-1.0, 4.0),
    lamp=(-1.0, 1.0),
    armour=(-0.5, 2.0),
    raggedness=(-0.05, 0.12),
)
"""Coats of every second cable; below 0 is none."""

LEAST_VISIBLE = 0.1
"""Share of the borders below which a frame is left out: it shows nothing of its cable."""

SCENES = 18_000
"""Number of scenes in three dimensions (`lamplit_scenes.py`)."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledFrames:
    """Frames with the cable in them: levels uint8 (N, H, W), poses (N, 4), NaN without a cable."""

    images: Image
    poses: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class LabelledScenes:
    """Scenes: levels (N, H, W) and shares of cells that are cable (N, H / 4, W / 4), uint8."""

    images: Image
    cells: Image


def render_scenes(seeds: range) -> LabelledScenes:
    """Render the scenes of some seeds."""
    images, cells = zip(*(lamplit_frame(seed) for seed in seeds), strict=True)
    width, height = WORLD_SIZE
    small = (width // CELL, height // CELL)
    reduced = [cv2.resize(each, small, interpolation=cv2.INTER_AREA) for each in cells]
    return LabelledScenes(np.stack(images), np.stack(reduced))


def labelled_scenes(folder: Path) -> LabelledScenes:
    """Return the scenes to train on."""
    seeds = range(FIRST_SEED, FIRST_SEED + SCENES)
    jobs = [seeds[first : first + DIVES_AT_ONCE] for first in range(0, SCENES, DIVES_AT_ONCE)]
    return rendered_once(folder / "scenes.npz", LabelledScenes, render_scenes, jobs)


def render(job: tuple[str, int, int]) -> LabelledFrames:
    """Render dives of a world: name, first seed, seed after the last."""
    name, first, stop = job
    images, poses = [], []
    for seed in range(first, stop):
        seen = _strip(seed) if name == STRIPS else _frame_of_world(WORLDS[name], seed)
        truth = seen.frame.truth
        # What is NaN is hardly visible, too.
        if truth is not None and not seen.visibility >= LEAST_VISIBLE:
            continue
        image = without_dead_margins(eight_bits(decode_grey(seen.frame.image)))
        pose = np.full(4, np.nan) if truth is None else truth.to_array()[:4]
        pose[[0, 2]] *= WORLD_SIZE[0] / image.shape[1]
        images.append(cv2.resize(image, WORLD_SIZE, interpolation=cv2.INTER_AREA))
        poses.append(pose)
    return LabelledFrames(np.stack(images), np.stack(poses))


def _frame_of_world(world: World, seed: int) -> SimulatedFrame:
    """Return the second frame of a dive; of every second dive one with a cable of any kind."""
    if world.has_cable and seed % 2:
        world = replace(world, coat=ANY_COAT, widths=ANY_WIDTH, angles=ANY_ANGLE)
    _, seen, *_ = simulate_world(replace(world, frame_count=2), seed)
    return seen


def _strip(seed: int) -> SimulatedFrame:
    """Return a crisp strip."""
    (seen,) = simulate_strip(seed, 1)
    return seen


def labelled_frames(folder: Path) -> LabelledFrames:
    """Return the frames to train on."""
    jobs = [
        (name, FIRST_SEED + first, FIRST_SEED + min(first + DIVES_AT_ONCE, count))
        for name, count in DIVES.items()
        for first in range(0, count, DIVES_AT_ONCE)
    ]
    return rendered_once(folder / "frames.npz", LabelledFrames, render, jobs)


Labelled = TypeVar("Labelled", LabelledFrames, LabelledScenes)

Job = TypeVar("Job")


def rendered_once(
    path: Path, kind: type[Labelled], render_job: Callable[[Job], Labelled], jobs: Sequence[Job]
) -> Labelled:
    """Return the joined results of rendering jobs, from a file if there is one."""
    names = [field.name for field in fields(kind)]
    if not path.is_file():
        with ProcessPoolExecutor(initializer=cv2.setNumThreads, initargs=(1,)) as pool:
            parts = list(pool.map(render_job, jobs))
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(
            path,
            **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names},
        )
    with np.load(path) as kept:
        return kind(**{name: kept[name] for name in names})
