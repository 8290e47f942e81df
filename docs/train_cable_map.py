"""Train the network that says where in a picture a cable may be (`cable/measure/map_network.py`).

    python docs/train_cable_map.py cable_map.onnx [--frames FOLDER] [--steps 4000] [--seed 0]

Frames of the simulated worlds to tune on are rendered into FOLDER once, and used again. The worlds
to report on, and the scenarios S1 to S6, are never seen. Needs PyTorch and onnx (the extra `train`)
and real ground, as the worlds do. Some 3 minutes of two processors to render, half an hour of
one to train.
"""

from __future__ import annotations

import argparse
import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.cable_map import CableMap, strip_shares
from cable_tracker.cable.measure.dead_margins import without_dead_margins
from cable_tracker.cable.measure.map_network import CELL, STRIDE, normalised, padded
from cable_tracker.evaluation.evaluation_sequences import simulated_sequences
from cable_tracker.simulation.worlds.world_dive import WORLD_SIZE

DIVES = {
    "tune_clear": 600,
    "tune_faint": 3000,
    "tune_inspection": 800,
    "tune_inspection_hard": 3000,
    "tune_shadows": 1500,
    "tune_sand": 1000,
    "tune_bars": 1000,
    "tune_compressed": 800,
    "tune_empty": 1000,
    "tune_decoys": 2000,
}
"""Number of dives through each world; of each the second frame is used."""

FIRST_SEED = 10_000
"""Seed of the first dive: far from those that the filter is tuned on."""

DIVES_AT_ONCE = 100

LEAST_VISIBLE = 0.1
"""Share of the borders below which a frame is left out: it shows nothing of its cable."""

CHANNELS = (8, 16, 24, 32, 48)
"""Number of channels at a half, a quarter, ... of the picture's size."""

BATCH = 32
HIGHEST_RATE, WARM_UP = 4e-3, 0.15
"""Largest learning rate, and share of the steps until it is reached."""

OVERLAP_WEIGHT = 0.3
"""Weight of the overlap in the loss: without it, thin cables count next to nothing."""

INVERTED, BLURRED, RIPPLED = 0.4, 0.3, 0.35
"""Shares of the pictures that are inverted, blurred, and crossed by ripples."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledFrames:
    """Frames with the cable in them: levels uint8 (N, H, W), poses (N, 4), NaN without a cable."""

    images: Image
    poses: FloatArray


def render(job: tuple[str, int, int]) -> LabelledFrames:
    """Render dives of a world: name, first seed, seed after the last."""
    name, first, stop = job
    images, poses = [], []
    (sequence,) = simulated_sequences([name], 2)
    for seed in range(first, stop):
        *_, frame = sequence.frames(seed)
        if frame.truth is not None and frame.visibility < LEAST_VISIBLE:
            continue
        images.append(without_dead_margins(frame.image))
        poses.append(np.full(4, np.nan) if frame.truth is None else frame.truth.to_array()[:4])
    return LabelledFrames(np.stack(images), np.stack(poses))


def labelled_frames(folder: Path) -> LabelledFrames:
    """Return the frames to train on; they are rendered if the folder does not hold them."""
    path = folder / "frames.npz"
    if not path.is_file():
        jobs = [
            (name, FIRST_SEED + first, FIRST_SEED + min(first + DIVES_AT_ONCE, count))
            for name, count in DIVES.items()
            for first in range(0, count, DIVES_AT_ONCE)
        ]
        with ProcessPoolExecutor(initializer=cv2.setNumThreads, initargs=(1,)) as pool:
            parts = list(pool.map(render, jobs))
        folder.mkdir(parents=True, exist_ok=True)
        np.savez(
            path,
            images=np.concatenate([part.images for part in parts]),
            poses=np.concatenate([part.poses for part in parts]),
        )
    with np.load(path) as kept:
        return LabelledFrames(kept["images"], kept["poses"])


def true_map(pose: FloatArray) -> Image:
    """Return which share of each cell is cable, float32, shape (H / 4, W / 4)."""
    width, height = WORLD_SIZE
    nothing = np.zeros((height // CELL, width // CELL), np.float32)
    if np.isnan(pose).any():
        return nothing
    where = CableMap(nothing, 0.0, -0.5 * (width - CELL), 0.5 * (height - CELL), float(CELL))
    return strip_shares(np.concatenate([pose, np.zeros(4)]), where)


def _convolution(before: int, after: int, stride: int = 1, size: int = 3) -> nn.Sequential:
    """Return a convolution with what goes with it."""
    return nn.Sequential(
        nn.Conv2d(before, after, size, stride, size // 2, bias=False),
        nn.BatchNorm2d(after),
        nn.ReLU(),
    )


class MapNetwork(nn.Module):
    """Log-odds of cells of 4x4 px: halved five times, then enlarged and joined three times."""

    def __init__(self) -> None:
        super().__init__()
        first, *deeper = CHANNELS
        self.halved = nn.ModuleList([_convolution(1, first, 2, 5)])
        for before, after in zip(CHANNELS, deeper, strict=False):
            self.halved.append(
                nn.Sequential(_convolution(before, after, 2), _convolution(after, after))
            )
        deepest = CHANNELS[-1]
        self.halved[-1].append(_convolution(deepest, deepest))
        self.joined = nn.ModuleList(
            _convolution(below + beside, beside)
            for below, beside in zip(CHANNELS[:1:-1], CHANNELS[-2:0:-1], strict=True)
        )
        self.log_odds = nn.Conv2d(CHANNELS[1], 1, 1)

    def forward(self, levels: Tensor) -> Tensor:
        """Return log-odds (B, 1, H / 4, W / 4) of levels (B, 1, H, W), sides multiples of 32."""
        scales = []
        for step in self.halved:
            levels = step(levels)
            scales.append(levels)
        found = scales.pop()
        for step, beside in zip(self.joined, scales[:0:-1], strict=True):
            enlarged = functional.interpolate(found, scale_factor=2.0, mode="nearest")
            found = step(torch.cat([enlarged, beside], 1))
        return self.log_odds(found)


def augmented(image: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return levels float32 (H, W) and the true map, changed as other dives would be."""
    levels = image.astype(np.float32)
    if rng.random() < RIPPLED:
        levels = _rippled(levels, cells, rng)
    for axis in range(2):
        if rng.random() < 0.5:
            levels, cells = np.flip(levels, axis), np.flip(cells, axis)
    if rng.random() < INVERTED:
        levels = 255.0 - levels
    levels = 255.0 * np.clip(levels / 255.0, 0.0, 1.0) ** np.float32(math.exp(0.3 * rng.normal()))
    if rng.random() < BLURRED:
        levels = cv2.blur(levels, (3, 3))
    noise = np.float32(12.0) * rng.random() ** 3
    levels = levels + noise * rng.standard_normal(levels.shape, np.float32)
    return levels.astype(np.float32), np.ascontiguousarray(cells)


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


def batch(frames: LabelledFrames, rng: np.random.Generator) -> tuple[Tensor, Tensor]:
    """Return pictures as the network takes them, and their true maps, padded alike."""
    pictures, maps = [], []
    for index in rng.choice(len(frames.images), BATCH, replace=False):
        image, cells = augmented(frames.images[index], true_map(frames.poses[index]), rng)
        picture, (left, above) = padded(normalised(image))
        pictures.append(picture)
        maps.append(_padded_map(cells, picture.shape, (left, above)))
    return torch.from_numpy(np.stack(pictures)[:, None]), torch.from_numpy(np.stack(maps))


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


def train(frames: LabelledFrames, steps: int, seed: int) -> MapNetwork:
    """Return a network after some steps, each with a batch of frames."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    network = MapNetwork().to(memory_format=torch.channels_last)
    optimiser = torch.optim.AdamW(network.parameters(), weight_decay=1e-3)
    rates = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, HIGHEST_RATE, total_steps=steps, pct_start=WARM_UP
    )
    mean = math.nan
    for step in range(steps):
        pictures, shares = batch(frames, rng)
        loss = loss_of(network(pictures.to(memory_format=torch.channels_last))[:, 0], shares)
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
        (torch.zeros(1, 1, STRIDE, STRIDE),),
        str(path),
        input_names=["picture"],
        output_names=["log_odds"],
        dynamic_axes={"picture": sides, "log_odds": sides},
        opset_version=11,
        dynamo=False,
    )


def main() -> None:
    """Render, train, and write the network."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("--frames", type=Path, default=Path("frames_to_train_on"))
    parser.add_argument("--steps", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    export(train(labelled_frames(chosen.frames), chosen.steps, chosen.seed), chosen.output)


if __name__ == "__main__":
    main()
