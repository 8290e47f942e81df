"""Train the network that says where in a picture a cable may be (`cable/measure/map/`).

    python docs/train_cable_map.py cable_map.onnx [--frames FOLDER] [--steps 12000] [--seed 0]
    python docs/train_cable_map.py new.onnx --go-on cable_map.onnx --steps 2400      # further

The log-odds of what is written are sharpened (`SHARPENED`, `RAISED`), and blunted again where a
network is trained further. The one in use was trained in several runs, of which the last four had
5000 steps each: scenes and pairs of cables (`TWINNED`) came with the first of these, soft bands of
light and streaks (`Changes.veiled`, `STREAKED`) with the third, other ground along a side of the
cable and seams (`Changes.banked`, `SEAMED`) with the last, which saw half of the scenes.

Frames of the simulated worlds to tune on, crisp strips, and scenes in three dimensions under lamps
(`lamplit_scenes.py`) are rendered into FOLDER once, and used again; every second frame of a world
shows a cable of a kind that no world has. The worlds to report on, and the scenarios S1 to S6, are
never seen. Needs PyTorch and onnx (the extra `train`) and real ground, as the worlds do. Some 15
minutes of two processors to render, an hour to train.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
import onnx
import torch
from lamplit_scenes import lamplit_frame
from torch import Tensor, nn
from torch.nn import functional

from cable_tracker.arrays import FloatArray, Image, IndexArray, eight_bits
from cable_tracker.cable.measure.map.cable_map import cable_map_of, strip_shares
from cable_tracker.cable.measure.map.map_network import (
    CELL,
    LIGHT_CELLS,
    STRIDE,
    normalised,
    padded,
)
from cable_tracker.cable.measure.picture.dead_margins import without_dead_margins
from cable_tracker.cable.model.geometry import border_offset
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.simulation.dive import SimulatedFrame
from cable_tracker.simulation.worlds.catalogue import WORLDS, simulate_world
from cable_tracker.simulation.worlds.crisp import simulate_strip
from cable_tracker.simulation.worlds.world import Coat, World
from cable_tracker.simulation.worlds.world_dive import WORLD_SIZE

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

ANY_WIDTH, ANY_ANGLE = (4.0, 160.0), (-90.0, 90.0)
"""Widths [px] and angles [deg] of every second cable."""

LEAST_VISIBLE = 0.1
"""Share of the borders below which a frame is left out: it shows nothing of its cable."""

CHANNELS = (8, 24, 48, 96, 128)
"""Number of channels at a half, a quarter, ... of the picture's size."""

DILATIONS = ((), (), (1, 2), (1, 2, 1))
"""Dilations of the blocks at a quarter, an eighth, ... of the picture's size: most lie where all of
a cable is seen at once."""

BATCH = 32
HIGHEST_RATE, GOING_ON_RATE, WARM_UP = 4e-3, 5e-4, 0.15
"""Largest learning rates, of a new network and of one that is trained further, and the share of the
steps until it is reached."""

SHARPENED, RAISED = 1.2, 0.3
"""Factor and constant of the log-odds. A network that has seen every picture changed in many ways
is less sure of a single one than it could be; raised further, it takes more trenches for cables."""

OVERLAP_WEIGHT = 0.3
"""Weight of the overlap in the loss: without it, thin cables count next to nothing."""

PAINTED = 0.4
"""Share of the cables that are painted over with a skin that no world has."""

ADDED = 0.3
"""Share of the pictures without a cable that are given one: the same ground with and without."""

INVERTED, BLURRED, STREAKED = 0.3, 0.4, 0.4
"""Shares of the pictures that are inverted, that are blurred, and of these that are blurred one
way, as by motion. What is inverted is given no shadow: a network that sees bright ones as often as
dark ones cannot tell a shadow from what casts it."""

WITHOUT_CABLE = 0.25
"""Share of the pictures that are drawn among those without a cable."""

LAMPLIT = 0.35
"""Share of the painted cables that a lamp at one side lights, so that the other lies in shadow."""

SHADED, CRISP, SPANNING = 0.5, 0.6, 0.4
"""Share of the cables that cast a shadow to one side, of those shadows that have an end, and of
these that lie apart from the cable, as below a free span."""

TWINNED = 0.3
"""Share of the cables beside which another one lies, of the same look: what is between the two is
no cable. Where there was none, the network took two cables and what is between for a wide one."""

SEAMED = 0.2
"""Share of the cables with a dark seam along one flank or both, where they touch the ground."""

CAPTIONED = 0.15
"""Share of the pictures with text, boxes and thin lines burned in."""

SCENES, SCENE_SHARE = 18_000, 0.3
"""Number of scenes in three dimensions (`lamplit_scenes.py`), and their share of a batch."""

PLAIN = 0.4
"""Share of the pictures without a cable whose ground is made plain before."""


@dataclass(frozen=True, slots=True)
class Changes:
    """Shares of the pictures that are changed, in this order.

    Attributes
    ----------
    rippled, covered : float
        Crossed by ripples; other ground is added.
    banked : float
        Other ground lies along one side of the cable, or along both.
    littered : float
        Plates and blocks lie on the bottom, with their shadows.
    snowed, bent, lit : float
        Behind particles; bent; lit by other lamps.
    pooled, veiled : float
        With pools of light or shade; with soft bands and steps of it.
    """

    rippled: float
    covered: float
    banked: float
    littered: float
    snowed: float
    bent: float
    lit: float
    pooled: float
    veiled: float


OF_FRAMES = Changes(
    rippled=0.3,
    covered=0.5,
    banked=0.35,
    littered=0.3,
    snowed=0.3,
    bent=0.5,
    lit=0.3,
    pooled=0.3,
    veiled=0.3,
)
OF_SCENES = Changes(
    rippled=0.1,
    covered=0.15,
    banked=0.25,
    littered=0.0,
    snowed=0.3,
    bent=0.5,
    lit=0.15,
    pooled=0.15,
    veiled=0.2,
)
"""Fewer: what is added to a scene has no part in its shadows."""


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
    """Return what jobs render, together; it is rendered if there is no such file yet."""
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


def true_map(pose: FloatArray) -> Image:
    """Return which share of each cell is cable, float32, shape (H / 4, W / 4)."""
    width, height = WORLD_SIZE
    nothing = np.zeros((height // CELL, width // CELL), np.float32)
    if np.isnan(pose).any():
        return nothing
    where = cable_map_of(nothing, -0.5 * (width - CELL), 0.5 * (height - CELL), float(CELL))
    return strip_shares(np.concatenate([pose, np.zeros(4)]), where)


def _convolution(
    before: int, after: int, stride: int = 1, size: int = 3, dilation: int = 1
) -> nn.Sequential:
    """Return a convolution with what goes with it."""
    margin = dilation * (size // 2)
    return nn.Sequential(
        nn.Conv2d(before, after, size, stride, margin, dilation, bias=False),
        nn.BatchNorm2d(after),
        nn.ReLU(),
    )


class _Block(nn.Module):
    """Two convolutions beside a shortcut (K. He et al., 2016)."""

    def __init__(self, channels: int, dilation: int) -> None:
        super().__init__()
        self.change = nn.Sequential(
            _convolution(channels, channels, dilation=dilation),
            nn.Conv2d(channels, channels, 3, padding=1, bias=False),
            nn.BatchNorm2d(channels),
        )

    def forward(self, levels: Tensor) -> Tensor:
        """Return levels of the same shape."""
        return functional.relu(levels + self.change(levels))


class MapNetwork(nn.Module):
    """Log-odds of cells of 4x4 px: halved five times, then enlarged and added three times."""

    def __init__(self) -> None:
        super().__init__()
        self.halved = nn.ModuleList([_convolution(len(LIGHT_CELLS), CHANNELS[0], 2, 5)])
        pairs = itertools.pairwise(CHANNELS)
        for (before, after), dilations in zip(pairs, DILATIONS, strict=True):
            blocks = [_Block(after, dilation) for dilation in dilations]
            self.halved.append(nn.Sequential(_convolution(before, after, 2), *blocks))
        upwards = list(itertools.pairwise(CHANNELS[:0:-1]))
        self.narrowed = nn.ModuleList(
            _convolution(below, beside, 1, 1) for below, beside in upwards
        )
        self.joined = nn.ModuleList(_convolution(beside, beside) for _, beside in upwards)
        self.log_odds = nn.Conv2d(CHANNELS[1], 1, 1)

    def forward(self, levels: Tensor) -> Tensor:
        """Return log-odds (B, 1, H / 4, W / 4) of levels (B, 3, H, W), sides multiples of 32."""
        scales = []
        for step in self.halved:
            levels = step(levels)
            scales.append(levels)
        found = scales.pop()
        for narrow, join, beside in zip(self.narrowed, self.joined, scales[:0:-1], strict=True):
            enlarged = functional.interpolate(narrow(found), scale_factor=2.0, mode="nearest")
            found = join(enlarged + beside)
        return self.log_odds(found)


def augmented(image: Image, pose: FloatArray, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return levels float32 (H, W) and the true map, changed as other dives would be."""
    is_inverted = rng.random() < INVERTED
    levels, pose = _with_any_skin(image.astype(np.float32), pose, not is_inverted, rng)
    cells = true_map(pose)
    if not np.isnan(pose).any() and rng.random() < TWINNED:
        levels, cells = _twinned(levels, cells, pose, rng)
    changes = replace(OF_FRAMES, littered=0.0) if is_inverted else OF_FRAMES
    levels, cells = _changed(levels, cells, changes, rng)
    return _recorded(255.0 - levels if is_inverted else levels, rng), cells


def augmented_scene(image: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return levels float32 (H, W) and the map of a scene, changed but for its shadows."""
    levels, shares = image.astype(np.float32), cells.astype(np.float32) / np.float32(255.0)
    levels, shares = _changed(levels, shares, OF_SCENES, rng)
    return _recorded(levels, rng), shares


def _changed(
    levels: Image, cells: Image, changes: Changes, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return a picture and its map with some of the changes, mirrored or not."""
    if rng.random() < changes.rippled:
        levels = _rippled(levels, cells, rng)
    if rng.random() < changes.covered:
        levels = _covered(levels, cells, rng)
    if rng.random() < changes.banked:
        levels = _banked(levels, cells, rng)
    if changes.littered and rng.random() < changes.littered:
        levels = _littered(levels, cells, rng)
    if rng.random() < changes.snowed:
        levels = _snowed(levels, rng)
    if rng.random() < changes.bent:
        levels, cells = _bent(levels, cells, rng)
    if rng.random() < changes.lit:
        levels = _lit(levels, rng)
    if rng.random() < changes.pooled:
        levels = _pooled(levels, rng)
    if rng.random() < changes.veiled:
        levels = _veiled(levels, rng)
    return _mirrored(levels, cells, rng)


def _mirrored(levels: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return a picture and its map, mirrored along none, one or both of their sides."""
    for axis in range(2):
        if rng.random() < 0.5:
            levels, cells = np.flip(levels, axis), np.flip(cells, axis)
    return levels, np.ascontiguousarray(cells)


def _with_any_skin(
    levels: Image, pose: FloatArray, may_be_shaded: bool, rng: np.random.Generator
) -> tuple[Image, FloatArray]:
    """Return a picture, and its pose, with a cable painted over, added or beside its shadow."""
    has_cable = not np.isnan(pose).any()
    if rng.random() < (PAINTED if has_cable else ADDED):
        pose = pose if has_cable else _any_pose(rng)
        levels, has_cable = _painted(levels, pose, may_be_shaded, rng), True
    elif not has_cable and rng.random() < PLAIN:
        levels = levels.mean() + np.float32(rng.random()) * (levels - levels.mean())
    elif has_cable and may_be_shaded and rng.random() < SHADED:
        at = _surface(pose, levels.shape)
        levels = _beside_a_shadow(levels, at, rng.choice((-1.0, 1.0)), rng)
    if has_cable and may_be_shaded and rng.random() < SEAMED:
        levels = _seamed(levels, _surface(pose, levels.shape), rng)
    return levels, pose


def _recorded(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture as a camera and a display record it."""
    levels = 255.0 * np.clip(levels / 255.0, 0.0, 1.0) ** np.float32(math.exp(0.3 * rng.normal()))
    if rng.random() < BLURRED:
        is_streaked = rng.random() < STREAKED
        levels = _streaked(levels, rng) if is_streaked else _defocused(levels, rng)
    noise = np.float32(12.0) * rng.random() ** 3
    levels = levels + noise * rng.standard_normal(levels.shape, np.float32)
    if rng.random() < CAPTIONED:
        levels = _captioned(levels, rng)
    return levels.astype(np.float32)


def _defocused(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture that is blurred alike in all directions."""
    return cv2.GaussianBlur(levels, (0, 0), 0.5 * 6.0 ** rng.random())


def _streaked(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture that is blurred one way, as by motion while the shutter is open."""
    length, turn = 2.0 * 8.0 ** rng.random(), math.pi * rng.random()
    reach = math.ceil(0.5 * length)
    off = np.arange(-reach, reach + 1, dtype=np.float32)
    along = off * math.cos(turn) + off[:, None] * math.sin(turn)
    aside = off[:, None] * math.cos(turn) - off * math.sin(turn)
    within = np.maximum(1.0 - np.abs(aside), 0.0) * (np.abs(along) <= 0.5 * length)
    return cv2.filter2D(levels, -1, within / within.sum(), borderType=cv2.BORDER_REFLECT)


def _any_pose(rng: np.random.Generator) -> FloatArray:
    """Return where a cable may lie, as (d [px], alpha [rad], w [px], beta [rad])."""
    distance = rng.uniform(-0.35, 0.35) * WORLD_SIZE[0]
    is_thin = rng.random() < 0.5
    width = math.exp(rng.uniform(*np.log(ANY_WIDTH))) if is_thin else rng.uniform(*ANY_WIDTH)
    # The wider a cable is, the nearer the camera, and the more it converges.
    skew = math.radians(0.07 * width * rng.normal())
    return np.array([distance, math.radians(rng.uniform(*ANY_ANGLE)), width, skew])


def _lit(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture that is lit unevenly, by lamps here and there."""
    strength = rng.random() * rng.standard_normal((3, 4), np.float32)
    light = cv2.resize(strength, levels.shape[::-1], interpolation=cv2.INTER_CUBIC)
    lit: Image = levels * np.exp(0.5 * light)
    return lit


def _pooled(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with pools and bands of light or shade, on ground and cable alike.

    Round pools may have a sharp rim; what is long fades out, or it could be a cable.
    """
    light = np.zeros_like(levels)
    for _ in range(rng.integers(1, 5)):
        longer, turn = 15.0 * 20.0 ** rng.random(), math.pi * rng.random()
        shorter = longer * rng.uniform(0.08, 1.0)
        along, aside = _about_any_place(levels.shape, turn, rng)
        outside = np.hypot(along / np.float32(longer), aside / np.float32(shorter)) - 1.0
        sharpest = 0.03 if shorter > 0.5 * longer else 0.2
        rim = np.float32(sharpest ** rng.random())
        light += np.float32(rng.uniform(-1.2, 1.2)) / (1.0 + np.exp(np.minimum(outside / rim, 20)))
    lit: Image = levels * np.exp(light).astype(np.float32)
    return lit


def _veiled(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with soft, straight bands and steps of light or shade, on ground and cable.

    Such are the beams of lamps, the edges of the vehicle's own shadow, and what a lens darkens.
    """
    light = np.zeros_like(levels)
    for _ in range(rng.integers(1, 4)):
        turn, half = math.pi * rng.random(), 25.0 * 6.0 ** rng.random()
        _, aside = _about_any_place(levels.shape, turn, rng)
        # Softer than the border of any cable that is as wide, however it is blurred.
        rim = np.float32(half * rng.uniform(0.2, 0.6))
        light += np.float32(0.4 * rng.normal()) * _logistic((half - np.abs(aside)) / rim)
    lit: Image = levels * np.exp(light).astype(np.float32)
    return lit


def _about_any_place(
    shape: tuple[int, ...], turn: float, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return how far pixels lie from a place along a direction, and aside of it [px]."""
    height, width = shape
    across = np.arange(width, dtype=np.float32) - np.float32(rng.uniform(0, width))
    down = np.arange(height, dtype=np.float32)[:, None] - np.float32(rng.uniform(0, height))
    return (
        across * math.cos(turn) + down * math.sin(turn),
        down * math.cos(turn) - across * math.sin(turn),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Surface:
    """Where pixels lie on a cable, each float32 (H, W).

    Attributes
    ----------
    across : Image
        From -1 at the left border to 1 at the right one.
    along : Image
        Along the centre line [px].
    outside : Image
        Distance outwards of the nearer border, below 0 inside [px].
    width : float
        Width w of the cable [px].
    """

    across: Image
    along: Image
    outside: Image
    width: float


def _surface(pose: FloatArray, shape: tuple[int, ...]) -> _Surface:
    distance, angle, width, skew = pose
    height, columns = shape
    x = np.arange(columns, dtype=np.float32) - np.float32(0.5 * (columns - 1))
    y = np.float32(0.5 * (height - 1)) - np.arange(height, dtype=np.float32)[:, None]
    inwards = []
    for side in (-1.0, 1.0):
        normal = angle + side * skew
        offset = border_offset(distance, width, skew, side)
        inwards.append(side * (offset - x * math.cos(normal) - y * math.sin(normal)))
    left, right = inwards
    across = (left - right) / np.maximum(np.abs(left) + np.abs(right), 1.0)
    along = y * math.cos(angle) - x * math.sin(angle)
    return _Surface(
        across.astype(np.float32), along.astype(np.float32), -np.minimum(left, right), float(width)
    )


def _painted(
    levels: Image, pose: FloatArray, may_be_shaded: bool, rng: np.random.Generator
) -> Image:
    """Return a picture whose cable has a skin of any kind: shaded, striped, wound, patched.

    Some cast a shadow to one side, if they may; of one in three the ground covers a part.
    """
    at, deviation = _surface(pose, levels.shape), float(levels.std()) + 3.0
    skin = _bands(at, rng) + _shading(at, rng)
    grain = _seen_aslant(GROUNDS[rng.integers(len(GROUNDS))](rng), levels.shape, rng)
    skin += np.float32(0.6 * rng.random() ** 2 / max(float(grain.std()), 0.3)) * grain
    contrast = np.float32(math.exp(rng.uniform(-1.0, 1.2)) * rng.choice((-1.0, 1.0)))
    rough = cv2.resize(rng.standard_normal((40, 53), np.float32), levels.shape[::-1])
    outside = at.outside + np.float32(0.15 * at.width * rng.random() ** 2) * rough
    share = 1.0 / (1.0 + np.exp(np.clip(outside / np.float32(rng.uniform(0.3, 1.5)), -20, 20)))
    if rng.random() < 1.0 / 3.0:
        cover = _seen_aslant(_waves(rng), levels.shape, rng)
        shown = (cover < np.quantile(cover, rng.uniform(0.5, 1.0))).astype(np.float32)
        share *= cv2.GaussianBlur(shown, (0, 0), rng.uniform(0.3, 3.0))
    side = rng.choice((-1.0, 1.0))
    if may_be_shaded and rng.random() < SHADED:
        levels = _beside_a_shadow(levels, at, side, rng)
    beside = levels[(at.outside > 0.0) & (at.outside < max(at.width, 10.0))]
    around = float(beside.mean()) if len(beside) else float(levels.mean())
    painted = around + np.float32(deviation) * (contrast + np.float32(rng.uniform(0.3, 1.5)) * skin)
    if may_be_shaded and rng.random() < LAMPLIT:
        levels, painted = _lamplit(levels, painted, at, side, rng)
    mixed: Image = levels + share.astype(np.float32) * (painted - levels)
    return mixed


def _beside_a_shadow(levels: Image, at: _Surface, side: float, rng: np.random.Generator) -> Image:
    """Return ground on which a cable casts a shadow to one side.

    It fades out, or it has an end; then the ground in it shows through, and it may lie apart from
    the cable, as below a free span that rises along the way.
    """
    outside = np.maximum(at.outside, 0.0)
    on_its_side = side * at.across > 0.0
    if rng.random() >= CRISP:
        fading = np.exp(-outside / np.float32(at.width * rng.uniform(0.1, 0.8))) * on_its_side
        depth = np.float32(1.5 * rng.random() * (float(levels.std()) + 3.0))
        return np.asarray(levels - depth * fading, np.float32)
    begin = np.zeros_like(outside)
    if rng.random() < SPANNING:
        rise = rng.uniform(-0.3, 0.3) * at.along
        begin = np.maximum(at.width * rng.uniform(0.0, 2.0) + rise, 0.0).astype(np.float32)
    end = begin + np.float32(at.width * rng.uniform(0.1, 1.3))
    soft = np.float32(rng.uniform(0.4, 1.0 + 0.1 * at.width))
    # Where it begins at the cable there is no ramp, but the cable's border.
    begun = np.where(begin > 0.0, _logistic((outside - begin) / soft), 1.0)
    within = begun * _logistic((end - outside) / soft) * (on_its_side & (at.outside > 0.0))
    return np.asarray(levels * (1.0 - rng.uniform(0.1, 0.9) * within), np.float32)


def _logistic(values: Image) -> Image:
    """Return a ramp from 0 to 1 about 0."""
    ramp: Image = 1.0 / (1.0 + np.exp(np.clip(-values, -20.0, 20.0)))
    return ramp


def _captioned(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with what a display burns in: text, some of it in boxes, and thin lines."""
    height, width = levels.shape
    written = np.clip(levels, 0.0, 255.0).astype(np.uint8)
    for _ in range(rng.integers(1, 7)):
        place = (int(rng.integers(-20, width)), int(rng.integers(10, height)))
        length = int(rng.integers(2, 30))
        text = "".join(chr(each) for each in rng.integers(32, 127, length))
        font, size = int(rng.integers(0, 8)), rng.uniform(0.3, 0.9)
        level = abs(float(rng.choice((0.0, 255.0))) - 40.0 * rng.random() ** 2)
        thickness = int(rng.integers(1, 3))
        (long, tall), below = cv2.getTextSize(text, font, size, thickness)
        if rng.random() < 0.4:
            corner, opposite = (
                (place[0] - 3, place[1] + below),
                (place[0] + long + 3, place[1] - tall - 3),
            )
            cv2.rectangle(written, corner, opposite, 255.0 - level, cv2.FILLED)
        cv2.putText(written, text, place, font, size, level, thickness, cv2.LINE_AA)
    for _ in range(rng.integers(0, 4)):
        first, second = ((int(rng.integers(width)), int(rng.integers(height))) for _ in range(2))
        # Level or upright, as the lines of displays are.
        second = (second[0], first[1]) if rng.random() < 0.5 else (first[0], second[1])
        cv2.line(written, first, second, float(rng.choice((0.0, 255.0))), int(rng.integers(1, 3)))
    return np.asarray(written, np.float32)


def _lamplit(
    levels: Image, painted: Image, at: _Surface, side: float, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return ground and cable under a lamp at one side: the other lies in the body's shadow.

    Both are as dark there, so that no border is left between them.
    """
    from_above = math.radians(rng.uniform(20.0, 85.0))
    slope = np.arcsin(np.clip(at.across, -1.0, 1.0))
    body = np.maximum(np.cos(slope + side * from_above), 0.0)
    dark = np.float32(rng.uniform(0.1, 0.6))
    soft = np.float32(rng.uniform(1.0, 1.0 + 0.15 * at.width))
    end = np.float32(at.width * 0.15 * (4.0 / 0.15) ** rng.random())
    behind = (side * at.across > 0.0) / (
        1.0 + np.exp(np.clip((at.outside - end) / soft, -20.0, 20.0))
    )
    return (
        levels * (1.0 - (1.0 - dark) * behind).astype(np.float32),
        painted * (dark + (1.0 - dark) * body).astype(np.float32),
    )


def _shading(at: _Surface, rng: np.random.Generator) -> Image:
    """Return the shading of a round body under some light, of any kind but smooth across it."""
    slope, bulge, rim = rng.normal(0.0, 0.5, 3)
    depth = np.sqrt(np.maximum(1.0 - at.across**2, 0.0))
    shading = slope * at.across + bulge * depth + rim * (np.abs(at.across) > rng.uniform(0.5, 1.0))
    return np.asarray(shading, np.float32)


def _bands(at: _Surface, rng: np.random.Generator) -> Image:
    """Return bands around a cable, straight or wound, none to two kinds of them."""
    found = np.zeros_like(at.across)
    turn = np.arcsin(np.clip(at.across, -1.0, 1.0)) / math.pi
    for _ in range(rng.integers(0, 3)):
        period = max(at.width * 0.1 * 80.0 ** rng.random(), 4.0)
        wound = rng.uniform(-2.0, 2.0) if rng.random() < 0.5 else 0.0
        phase = (at.along / np.float32(period) + np.float32(wound) * turn + rng.random()) % 1.0
        found += np.float32(rng.normal()) * (phase < rng.uniform(0.1, 0.9))
    return cv2.GaussianBlur(found, (0, 0), rng.uniform(0.5, 1.5))


def _rippled(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture whose bottom has ripples: bands as straight and clear as a cable.

    In one of five pictures they go over the cable, too, fainter.
    """
    height, width = levels.shape
    x = np.arange(width, dtype=np.float32) - 0.5 * width
    y = np.arange(height, dtype=np.float32)[:, None] - 0.5 * height
    direction, length, phase = math.pi * rng.random(), 8.0 * 12.0 ** rng.random(), rng.random()
    across = x * math.cos(direction) + y * math.sin(direction)
    along = y * math.cos(direction) - x * math.sin(direction)
    warp = 1.5 * rng.random() * np.sin(along / rng.uniform(20.0, 100.0) + 10.0 * phase)
    warp += rng.random() * np.sin(across / rng.uniform(40.0, 120.0))
    wave = np.sin(2.0 * math.pi * (across / length + phase) + warp)
    wave = np.sign(wave) * np.abs(wave) ** math.exp(rng.uniform(-1.5, 1.5))
    cable = cv2.resize(cells, (width, height), interpolation=cv2.INTER_LINEAR)
    over_cable = rng.uniform(0.0, 0.6) if rng.random() < 0.2 else 0.0
    share = 1.0 - cable * (1.0 - over_cable)
    return levels + np.float32(30.0 * rng.random() ** 2) * wave.astype(np.float32) * share


def _covered(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture with other ground added, of one kind or two."""
    height, width = levels.shape
    cable = cv2.resize(cells, (width, height), interpolation=cv2.INTER_LINEAR)
    for kind in rng.choice(len(GROUNDS), rng.integers(1, 3), replace=False):
        ground = _seen_aslant(GROUNDS[kind](rng), levels.shape, rng)
        ground *= np.float32(30.0 * rng.random() ** 2 / max(float(ground.std()), 0.3))
        levels = levels + ground * (1.0 - cable)
    return levels


def _banked(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture with other ground along one side of the cable, or along both.

    Dumped rock, gravel, weed, or sand of another tone: it lies closest at the cable. Where there is
    none, it lies along any line: what has one border is no cable.
    """
    cable = cv2.resize(cells, levels.shape[::-1], interpolation=cv2.INTER_LINEAR)
    outside, side = _sides(cells, levels.shape, rng)
    sides = (-1.0, 1.0) if rng.random() < 0.3 else (rng.choice((-1.0, 1.0)),)
    for each in sides:
        reach = 8.0 * 60.0 ** rng.random()
        # Single stones lie on the border; none lies farther in.
        is_beside = (each * side > 0.0) & (outside > -2.0)
        beside = np.where(is_beside, np.maximum(outside, 0.0) / np.float32(reach), np.inf)
        if rng.random() < 0.5:
            levels = _dumped(levels, beside, rng)
        else:
            levels = _other_ground(levels, beside, 1.0 - cable, rng)
    return levels


def _sides(cells: Image, shape: tuple[int, ...], rng: np.random.Generator) -> tuple[Image, Image]:
    """Return how far pixels lie outside the cable, below 0 inside, and aside of its axis [px].

    Without a cable they are those of any line.
    """
    rows, columns = np.nonzero(cells > 0.5)
    if len(rows) < 2:
        _, aside = _about_any_place(shape, math.pi * rng.random(), rng)
        return np.abs(aside), aside
    is_cable = (cells > 0.5).astype(np.uint8)
    off, deep = (
        cv2.distanceTransform(each, cv2.DIST_L2, cv2.DIST_MASK_5)
        for each in (1 - is_cable, is_cable)
    )
    outside = cv2.resize(CELL * (off - deep), shape[::-1], interpolation=cv2.INTER_LINEAR)
    middle = np.array([columns.mean(), rows.mean()])
    _, directions = np.linalg.eigh(np.cov(columns, rows))
    across = directions[:, 0]
    x = np.arange(shape[1], dtype=np.float32) - CELL * (middle[0] + 0.5)
    y = np.arange(shape[0], dtype=np.float32)[:, None] - CELL * (middle[1] + 0.5)
    return outside, (x * across[0] + y * across[1]).astype(np.float32)


def _dumped(levels: Image, beside: Image, rng: np.random.Generator) -> Image:
    """Return a picture with stones, lit from one side, fewer the farther from the cable.

    `beside`: distance from it in units of that over which they become fewer, infinite elsewhere.
    """
    rows, columns = levels.shape
    dumped = levels.astype(np.float32)
    largest, light = 1.5 * 8.0 ** rng.random(), rng.normal(0.0, 0.7, 2)
    tone = dumped.mean() + (float(levels.std()) + 5.0) * 1.5 * rng.normal()
    spread, depth = 15.0 * rng.random(), rng.uniform(0.2, 0.9)
    number = round(
        min(2.5 * levels.size / (math.pi * largest**2) * 3.0 ** rng.uniform(-2, 1), 2500)
    )
    places = rng.random((number, 2)) * (columns, rows)
    far = beside[places[:, 1].astype(int), places[:, 0].astype(int)]
    for middle in places[rng.random(number) < np.exp(-far)]:
        radius = largest * rng.uniform(0.4, 1.0)
        axes, turn = np.array([1.0, rng.uniform(0.5, 1.0)]) * radius, 360.0 * rng.random()
        level = tone + spread * rng.normal()
        _draw_stone(
            dumped, middle + -0.4 * radius * light, 1.05 * axes, turn, level * (1.0 - depth)
        )
        _draw_stone(dumped, middle, 0.95 * axes, turn, level)
        _draw_stone(
            dumped, middle + 0.3 * radius * light, np.full(2, 0.5 * radius), 0.0, level + 8.0
        )
    return cv2.GaussianBlur(dumped, (3, 3), rng.uniform(0.3, 0.8))


def _draw_stone(
    picture: Image, middle: FloatArray, axes: FloatArray, turn: float, level: float
) -> None:
    """Draw a filled ellipse to an eighth of a pixel: half-axes [px] and turn [deg]."""
    centre, lengths = (
        tuple(int(each) for each in np.round(8.0 * values)) for values in (middle, axes)
    )
    ends = (turn, 0.0, 360.0)
    cv2.ellipse(picture, centre, lengths, *ends, float(level), cv2.FILLED, cv2.LINE_8, 3)


def _other_ground(
    levels: Image, beside: Image, ground_share: Image, rng: np.random.Generator
) -> Image:
    """Return a picture with ground of another tone and grain beside the cable, ragged at its end.

    `beside` is that of `_dumped`; `ground_share`: share of each pixel that is no cable.
    """
    rough = _seen_aslant(_waves(rng), levels.shape, rng)
    rough *= np.float32(rng.uniform(0.0, 0.5) / max(float(rough.std()), 0.3))
    soft = np.float32(0.03 * 15.0 ** rng.random())
    shown = _logistic((1.0 - np.minimum(beside, 20.0) + rough) / soft) * (beside < np.inf)
    deviation = float(levels.std()) + 3.0
    ground = _seen_aslant(GROUNDS[rng.integers(len(GROUNDS))](rng), levels.shape, rng)
    ground *= np.float32(1.5 * rng.random() * deviation / max(float(ground.std()), 0.3))
    level = np.float32(levels.mean() + deviation * rng.normal())
    kept = np.float32(rng.random())
    other = level + ground + kept * (levels - np.float32(levels.mean()))
    return np.asarray(levels + shown * ground_share * (other - levels), np.float32)


def _seamed(levels: Image, at: _Surface, rng: np.random.Generator) -> Image:
    """Return a picture with a dark seam along one flank of a cable, or along both."""
    dark = np.zeros_like(levels)
    for side in (-1.0, 1.0) if rng.random() < 0.3 else (rng.choice((-1.0, 1.0)),):
        half = np.float32(0.5 * min(2.0 + 7.0 * rng.random(), 0.35 * at.width))
        off = np.abs(at.outside - half * rng.uniform(-1.0, 1.0))
        ragged = cv2.resize(rng.standard_normal((30, 40), np.float32), levels.shape[::-1])
        ragged *= np.float32(0.4 * rng.random())
        soft = np.float32(0.3 * 6.0 ** rng.random())
        seam = _logistic((half * (1.0 + ragged) - off) / soft) * (side * at.across > 0.0)
        dark = np.maximum(dark, np.float32(rng.uniform(0.1, 0.8)) * seam)
    return np.asarray(levels * (1.0 - dark), np.float32)


def _twinned(
    levels: Image, cells: Image, pose: FloatArray, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return a picture, and its map, with a second cable beside the first, wider or narrower."""
    distance, angle, width, _ = pose
    height, columns = levels.shape
    foot = (
        0.5 * (columns - 1) + distance * math.cos(angle),
        0.5 * (height - 1) - distance * math.sin(angle),
    )
    zoom, gap = rng.uniform(0.5, 1.6), width * 0.25 * 16.0 ** rng.random()
    apart = rng.choice((-1.0, 1.0)) * (0.5 * (1.0 + zoom) * width + gap)
    moved = cv2.getRotationMatrix2D(foot, 3.0 * rng.normal(), zoom)
    moved[:, 2] += apart * math.cos(angle), -apart * math.sin(angle)
    at = _surface(pose, levels.shape)
    share = _logistic(-at.outside / np.float32(0.7)).astype(np.float32)
    size = (columns, height)
    share = cv2.warpAffine(share, moved, size) * (at.outside > 0.0)
    other = cv2.warpAffine(levels.astype(np.float32), moved, size, borderMode=cv2.BORDER_REFLECT)
    both = np.maximum(cells, cv2.resize(share, cells.shape[::-1], interpolation=cv2.INTER_AREA))
    return np.asarray(levels + share * (other - levels), np.float32), both


def _littered(levels: Image, cells: Image, rng: np.random.Generator) -> Image:
    """Return a picture with plates and blocks beside the cable, which cast their shadows one way.

    Their borders are as straight as those of a cable, and shorter.
    """
    height, width = levels.shape
    cable = cv2.resize(cells, (width, height), interpolation=cv2.INTER_LINEAR)
    deviation = np.float32(levels.std() + 5.0)
    light, littered = 2.0 * math.pi * rng.random(), levels
    for _ in range(rng.integers(1, 9)):
        angles = np.sort(2.0 * math.pi * rng.random(rng.integers(3, 9)))
        radius = 6.0 * 15.0 ** rng.random()
        lengths = radius * rng.uniform(0.6, 1.0, len(angles))
        corners = np.column_stack([np.cos(angles), rng.uniform(0.5, 1.0) * np.sin(angles)])
        corners = lengths[:, None] * corners + rng.random(2) * (width, height)
        thrown = radius * rng.uniform(0.0, 0.8) * np.array([math.cos(light), math.sin(light)])
        soft = rng.uniform(0.3, 1.5)
        shadow = _filled(np.vstack([corners, corners + thrown]), levels.shape, soft)
        littered = littered * (1.0 - np.float32(rng.uniform(0.2, 0.9)) * shadow)
        ground = _seen_aslant(GROUNDS[rng.integers(len(GROUNDS))](rng), levels.shape, rng)
        block = littered.mean() + deviation * np.float32(1.5 * rng.normal())
        block = block + np.float32(rng.random() ** 2 / max(ground.std(), 0.3)) * deviation * ground
        littered = littered + _filled(corners, levels.shape, soft) * (block - littered)
    return np.asarray(littered + cable * (levels - littered), np.float32)


def _filled(corners: FloatArray, shape: tuple[int, ...], soft: float) -> Image:
    """Return the share of each pixel within the convex hull of some points (N, 2), (x, y) [px]."""
    filled = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(filled, cv2.convexHull(np.round(corners).astype(np.int32)), 255)
    return cv2.GaussianBlur(filled.astype(np.float32) / np.float32(255.0), (0, 0), soft)


def _snowed(levels: Image, rng: np.random.Generator) -> Image:
    """Return a picture with particles in the water before it, bright and out of focus."""
    height, width = levels.shape
    snow = np.zeros_like(levels)
    largest = rng.uniform(1.0, 4.0)
    for _ in range(round(5.0 * 20.0 ** rng.random())):
        middle = (int(rng.integers(width)), int(rng.integers(height)))
        cv2.circle(snow, middle, round(largest * rng.random()), rng.random(), cv2.FILLED)
    snow = cv2.GaussianBlur(snow, (0, 0), rng.uniform(0.5, 1.5))
    if rng.random() < STREAKED:
        snow = _streaked(snow, rng)
    return levels + np.float32(100.0 * rng.random()) * snow


def _seen_aslant(ground: Image, shape: tuple[int, ...], rng: np.random.Generator) -> Image:
    """Return ground (H, W) as a camera sees it that is turned, and tilted more or less."""
    height, width = shape
    side, angle, far = len(ground), 2.0 * math.pi * rng.random(), rng.uniform(0.3, 1.0)
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [far, 1.0], [-far, 1.0]]) * rng.uniform(0.4, 0.7)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    source = (0.5 + 0.5 * corners @ turn) * side
    target = np.array([[0, height], [width, height], [width, 0], [0, 0]], np.float32)
    view = cv2.getPerspectiveTransform(source.astype(np.float32), target)
    return cv2.warpPerspective(ground, view, (width, height), borderMode=cv2.BORDER_REFLECT)


GROUND_SIDE = 400
"""Side of the ground that is made [px]."""


def _waves(rng: np.random.Generator) -> Image:
    """Return noise of some wavelengths, longer one way."""
    ground = np.zeros((GROUND_SIDE, GROUND_SIDE), np.float32)
    stretch = math.exp(0.7 * rng.normal())
    for length in (2.0, 5.0, 12.0, 30.0):
        coarse = (
            max(round(GROUND_SIDE / (stretch * length)), 4),
            max(round(GROUND_SIDE * stretch / length), 4),
        )
        noise = rng.standard_normal(coarse, np.float32)
        ground += np.float32(rng.random()) * cv2.resize(noise, ground.shape)
    return ground


def _cobbles(rng: np.random.Generator) -> Image:
    """Return stones side by side, each of one grey level and lit from one side, dark between."""
    count = round(40.0 * 100.0 ** rng.random())
    apart = np.ones((GROUND_SIDE, GROUND_SIDE), np.uint8)
    middles = rng.integers(0, GROUND_SIDE, (count, 2))
    apart[middles[:, 1], middles[:, 0]] = 0
    off, stone = cv2.distanceTransformWithLabels(
        apart, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    levels = rng.standard_normal(int(stone.max()) + 1, np.float32)
    size = np.float32(GROUND_SIDE / math.sqrt(count))
    lit = np.gradient(off)[int(rng.integers(2))] * off / size
    seams = np.minimum(off / (np.float32(rng.uniform(0.3, 1.0)) * size), 1.0) ** 2
    return np.asarray(
        rng.random() * levels[stone] + rng.normal() * lit - 2.0 * rng.random() * seams, np.float32
    )


def _stones(rng: np.random.Generator) -> Image:
    """Return single stones, weed and shells: spots, longer or shorter, of any grey level."""
    ground = np.zeros((GROUND_SIDE, GROUND_SIDE), np.float32)
    longest = rng.uniform(3.0, 30.0)
    for _ in range(round(20.0 * 15.0 ** rng.random())):
        middle = tuple(int(each) for each in rng.integers(0, GROUND_SIDE, 2))
        length = longest * rng.random()
        axes = (round(length), round(length * rng.uniform(0.1, 1.0)))
        level = float(rng.normal())
        cv2.ellipse(ground, middle, axes, 360.0 * rng.random(), 0.0, 360.0, level, cv2.FILLED)
    return cv2.GaussianBlur(ground, (0, 0), rng.uniform(0.5, 2.0))


def _tracks(rng: np.random.Generator) -> Image:
    """Return crooked lines of any width, each with a side that is darker than the other."""
    ground = np.zeros((GROUND_SIDE, GROUND_SIDE), np.float32)
    for _ in range(rng.integers(2, 30)):
        steps = np.cumsum(rng.normal(0.0, 0.5, 12)) + 2.0 * math.pi * rng.random()
        path = np.cumsum(np.column_stack([np.cos(steps), np.sin(steps)]), axis=0)
        path = GROUND_SIDE * rng.random(2) + rng.uniform(4.0, 25.0) * path
        width, level = int(rng.integers(1, 8)), float(rng.normal())
        for shift, sign in ((0.0, 1.0), (float(width), -rng.random())):
            points = np.round(path + shift).astype(np.int32)[:, None]
            cv2.polylines(ground, [points], False, sign * level, width, cv2.LINE_AA)
    return cv2.GaussianBlur(ground, (0, 0), rng.uniform(0.5, 2.0))


def _boulders(rng: np.random.Generator) -> Image:
    """Return round stones, lit from one side, with shadows."""
    ground = np.zeros((GROUND_SIDE, GROUND_SIDE), np.float32)
    largest, light = rng.uniform(8.0, 60.0), rng.normal(0.0, 0.5, 2)
    for _ in range(rng.integers(3, 40)):
        middle, radius, level = GROUND_SIDE * rng.random(2), largest * rng.random(), rng.normal()
        axes = np.array([1.0, rng.uniform(0.5, 1.0)]) * radius
        turn, shadow = 360.0 * rng.random(), float(rng.uniform(-2.0, 0.0))
        for shift, size, lit in ((-0.5, 1.0, shadow), (0.0, 1.0, level), (0.3, 0.6, level + 0.5)):
            centre = tuple(int(each) for each in middle + shift * radius * light)
            lengths = tuple(round(size * each) for each in axes)
            cv2.ellipse(ground, centre, lengths, turn, 0.0, 360.0, float(lit), cv2.FILLED)
    return cv2.GaussianBlur(ground, (0, 0), rng.uniform(0.5, 3.0))


def _beds(rng: np.random.Generator) -> Image:
    """Return beds of mussels, weed or gravel: patches of one ground in nothing."""
    kinds = (_waves, _cobbles, _stones)
    ground = kinds[rng.integers(len(kinds))](rng)
    coarse = rng.standard_normal((int(rng.integers(4, 16)),) * 2, np.float32)
    patches = cv2.resize(coarse, ground.shape, interpolation=cv2.INTER_CUBIC)
    within = patches > np.quantile(patches, rng.uniform(0.3, 0.9))
    scale = np.float32(rng.uniform(0.3, 1.5) / max(float(ground.std()), 0.3))
    return np.asarray(within * (scale * ground + np.float32(rng.normal())), np.float32)


def _step(rng: np.random.Generator) -> Image:
    """Return ground that is darker beyond one straight border: a shadow, a plate, a step."""
    across = np.arange(GROUND_SIDE, dtype=np.float32) / GROUND_SIDE - rng.uniform(0.2, 0.8)
    level = 1.0 / (1.0 + np.exp(np.clip(-across * math.exp(rng.uniform(3.0, 6.5)), -20, 20)))
    return np.tile(level.astype(np.float32), (GROUND_SIDE, 1))


GROUNDS = (_waves, _cobbles, _stones, _tracks, _boulders, _beds, _step)


def _bent(levels: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return a picture, and its map, turned, enlarged or made smaller, and bent."""
    height, width = levels.shape
    angle, zoom = 0.25 * rng.normal(), math.exp(rng.uniform(-0.15, 0.5))
    cos, sin = math.cos(angle) / zoom, math.sin(angle) / zoom
    x = np.arange(width, dtype=np.float32) - 0.5 * (width - 1)
    y = np.arange(height, dtype=np.float32)[:, None] - 0.5 * (height - 1)
    bends = 8.0 * rng.random() * rng.standard_normal((2, 3, 4), np.float32)
    across, down = (
        cv2.resize(each, (width, height), interpolation=cv2.INTER_CUBIC) for each in bends
    )
    across = across + np.float32(cos) * x - np.float32(sin) * y + np.float32(0.5 * (width - 1))
    down = down + np.float32(sin) * x + np.float32(cos) * y + np.float32(0.5 * (height - 1))
    moved = cv2.remap(levels, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    shares = cv2.resize(cells, (width, height), interpolation=cv2.INTER_LINEAR)
    shares = cv2.remap(shares, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    return moved, cv2.resize(shares, cells.shape[::-1], interpolation=cv2.INTER_AREA)


def batch(
    frames: LabelledFrames, scenes: LabelledScenes, rng: np.random.Generator
) -> tuple[Tensor, Tensor]:
    """Return pictures as the network takes them, and their true maps, padded alike."""
    from_scenes = rng.binomial(BATCH, SCENE_SHARE)
    changed = [
        augmented(frames.images[index], frames.poses[index], rng)
        for index in _drawn(frames.poses, BATCH - from_scenes, rng)
    ] + [
        augmented_scene(scenes.images[index], scenes.cells[index], rng)
        for index in rng.choice(len(scenes.images), from_scenes, replace=False)
    ]
    pictures, maps = [], []
    for image, cells in changed:
        picture, (left, above) = padded(normalised(image))
        pictures.append(picture)
        maps.append(_padded_map(cells, picture.shape[1:], (left, above)))
    return torch.from_numpy(np.stack(pictures)), torch.from_numpy(np.stack(maps))


def _drawn(poses: FloatArray, number: int, rng: np.random.Generator) -> IndexArray:
    """Return which frames a batch has, as many without a cable as `WITHOUT_CABLE` says."""
    without = np.isnan(poses).any(1)
    count = rng.binomial(number, WITHOUT_CABLE)
    return np.concatenate(
        [
            rng.choice(np.flatnonzero(without), count, replace=False),
            rng.choice(np.flatnonzero(~without), number - count, replace=False),
        ]
    )


def _padded_map(cells: Image, shape: tuple[int, ...], before: tuple[int, int]) -> Image:
    """Return the true map with its margins repeated as those of the picture are."""
    left, above = (each // CELL for each in before)
    height, width = (side // CELL for side in shape)
    below, right = height - above - cells.shape[0], width - left - cells.shape[1]
    return cv2.copyMakeBorder(cells, above, below, left, right, cv2.BORDER_REPLICATE)


def loss_of(log_odds: Tensor, shares: Tensor) -> Tensor:
    """Return the cross-entropy of the cells, and how little found and true cables overlap."""
    entropy = functional.binary_cross_entropy_with_logits(log_odds, shares)
    found = torch.sigmoid(log_odds)
    both, true = (found * shares).sum((1, 2)), shares.sum((1, 2))
    overlap = (2.0 * both + 1.0) / (found.sum((1, 2)) + true + 1.0)
    return entropy + OVERLAP_WEIGHT * ((1.0 - overlap) * (true > 0.0)).mean()


def load(network: MapNetwork, path: Path, pictures: Tensor) -> None:
    """Take the weights of a file that `export` wrote, to train them further.

    The file has the normalisations worked into the convolutions; they are taken out again, with the
    statistics of some pictures. What the network finds stays as it was.
    """
    graph = onnx.load(path).graph
    weights = {each.name: onnx.numpy_helper.to_array(each) for each in graph.initializer}
    folded = {
        node.name: [torch.tensor(weights[name]) for name in node.input[1:]]
        for node in graph.node
        if node.op_type == "Conv"
    }
    normalised_by = {}
    for name, (weight, bias) in folded.items():
        module = _module_name(name)
        convolution = network.get_submodule(module)
        convolution.weight.data = weight
        if convolution.bias is not None:
            convolution.bias.data = bias
            continue
        parent, _, place = module.rpartition(".")
        after = network.get_submodule(f"{parent}.{int(place) + 1}")
        normalised_by[after] = bias
    _take_statistics(network, normalised_by, pictures)


def _module_name(node: str) -> str:
    """Return the name of a module by that of its node: `/a.0/a.0.1/Conv` is `a.0.1`."""
    parts: list[str] = []
    for part in node.removesuffix("/Conv").strip("/").split("/"):
        if parts and part.startswith(f"{parts[-1]}."):
            parts.pop()
        parts.append(part)
    return ".".join(parts)


def _take_statistics(
    network: MapNetwork, biases: dict[nn.BatchNorm2d, Tensor], pictures: Tensor
) -> None:
    """Give each normalisation what it normalises, and what undoes it but for a bias."""
    inputs: dict[nn.BatchNorm2d, Tensor] = {}
    with ExitStack() as hooks:
        for layer, bias in biases.items():
            layer.weight.data.fill_(math.sqrt(1.0 + layer.eps))
            layer.bias.data = bias
            hooks.enter_context(
                layer.register_forward_pre_hook(
                    lambda which, given: inputs.update({which: given[0]})
                )
            )
        with torch.no_grad():
            network.eval()(pictures)
    for layer, bias in biases.items():
        layer.running_mean = inputs[layer].mean((0, 2, 3))
        layer.running_var = inputs[layer].var((0, 2, 3))
        layer.weight.data = torch.sqrt(layer.running_var + layer.eps)
        layer.bias.data = bias + layer.running_mean
    network.train()


def train(
    frames: LabelledFrames, scenes: LabelledScenes, steps: int, seed: int, start: Path | None
) -> MapNetwork:
    """Return a network after some steps, each with a batch of frames.

    `start` is a file with the network that it goes on from; None: it begins anew.
    """
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    network = MapNetwork().to(memory_format=torch.channels_last)
    if start is not None:
        load(network, start, batch(frames, scenes, rng)[0])
        blunt(network)
    optimiser = torch.optim.AdamW(network.parameters(), weight_decay=1e-3)
    rates = torch.optim.lr_scheduler.OneCycleLR(
        optimiser,
        HIGHEST_RATE if start is None else GOING_ON_RATE,
        total_steps=steps,
        pct_start=WARM_UP,
    )
    capabilities = torch.cpu.get_capabilities()
    has_bfloat16 = bool(capabilities.get("avx512_bf16") or capabilities.get("amx_bf16"))
    mean = math.nan
    with ThreadPoolExecutor(1) as aside:
        following = aside.submit(batch, frames, scenes, rng)
        for step in range(steps):
            pictures, shares = following.result()
            if step + 1 < steps:
                following = aside.submit(batch, frames, scenes, rng)
            # Twice as fast where the processor has instructions for this type, else much slower.
            with torch.autocast("cpu", torch.bfloat16, enabled=has_bfloat16):
                log_odds = network(pictures.to(memory_format=torch.channels_last))[:, 0]
            loss = loss_of(log_odds.float(), shares)
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            rates.step()
            mean = loss.item() if step == 0 else 0.98 * mean + 0.02 * loss.item()
            if step % 100 == 0:
                print(f"step {step}: loss {mean:.4f}", flush=True)
    return network.eval()


def export(network: MapNetwork, path: Path) -> None:
    """Write the network as OpenCV reads it, for pictures of any size."""
    sides = {2: "height", 3: "width"}
    torch.onnx.export(
        network,
        (torch.zeros(1, len(LIGHT_CELLS), STRIDE, STRIDE),),
        str(path),
        input_names=["picture"],
        output_names=["log_odds"],
        dynamic_axes={"picture": sides, "log_odds": sides},
        opset_version=11,
        dynamo=False,
    )


def sharpen(network: MapNetwork) -> None:
    """Sharpen the log-odds of a network that has been trained."""
    last = network.log_odds
    last.weight.data = SHARPENED * last.weight.data
    last.bias.data = SHARPENED * last.bias.data + RAISED


def blunt(network: MapNetwork) -> None:
    """Undo `sharpen`, to train a network further."""
    last = network.log_odds
    last.weight.data = last.weight.data / SHARPENED
    last.bias.data = (last.bias.data - RAISED) / SHARPENED


def main() -> None:
    """Render, train, and write the network."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("--frames", type=Path, default=Path("frames_to_train_on"))
    parser.add_argument("--steps", type=int, default=12000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--go-on", type=Path, metavar="NETWORK")
    chosen = parser.parse_args()
    frames, scenes = labelled_frames(chosen.frames), labelled_scenes(chosen.frames)
    network = train(frames, scenes, chosen.steps, chosen.seed, chosen.go_on)
    sharpen(network)
    export(network, chosen.output)


if __name__ == "__main__":
    main()
