"""Train the network that says where in a picture a cable may be (`cable/measure/map/`).

    python docs/train_cable_map.py cable_map.onnx [--frames FOLDER] [--steps 12000] [--seed 0]
    python docs/train_cable_map.py new.onnx --go-on cable_map.onnx --steps 2400      # further
    python docs/train_cable_map.py mean.onnx --blend before.onnx new.onnx 0.5        # mean of both

The log-odds of what is written are sharpened (`SHARPENED`), and blunted again where a network is
trained further. The one in use was trained on 24 700 frames of as many dives, in which the cables
and the ground are changed (`map_pictures/changes.py`), then for some 36 000 steps more in several
runs, in which these came in, one after the other:

* pools and bands of light on ground and cable; lamps at one side; shadows that end, or lie apart
  from the cable; text, boxes and thin lines of displays; plates and blocks and their shadows; more
  pictures without a cable, on plain ground, too;
* with the first of four runs of 5000 steps, 18 000 scenes in three dimensions, for painted shadows
  fit what casts them only roughly, and pairs of cables (`TWINNED`). On scenes that it was not
  trained on the overlap with the true map rose from 0.65 to 0.81, on two simulators that were
  written apart from this project wrong claims fell from 6.6 to 3.6 %;
* with the third, soft, straight bands and steps of light, as lamps and the shadow of the vehicle
  throw them, and streaks (`add_light_bands`, `STREAKED`);
* with the fourth, other ground along one side of a cable or along both, single stones or another
  tone and grain (`add_banks`), and dark seams (`SEAMED`): without them the network took dumped
  rock, or the plain ground on the other side, for a wide cable;
* with 5000 steps more and 3500 in which there were more of them (half of the scenes in both, and in
  the fourth), trenches, strakes, overgrown cables, nets of light, animals, slack ropes, ledges of
  rock and soft bands as narrow as cables. Its weights are means of those before these 8500 steps
  and those after (`--blend`): what was new is known, and what was known is less forgotten;
* with 4800 steps more, crisp shadows of the vehicle's frame in which the ground shows
  (`add_frame_shadows`), scars of trawls (`add_grooves`), other ground that begins apart from the
  cable, so that the ground between has two borders (`APART`), and cables buried over whole
  stretches or from one side on, a quarter or more left to see (`BURIED`). Its weights are again
  means, chosen by the worlds to tune on among shares of a half, three quarters and all of the
  further trained one.

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
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import cv2
import numpy as np
import onnx
import torch
from map_pictures.changes import augmented, augmented_scene
from map_pictures.rendered_pictures import (
    LabelledFrames,
    LabelledScenes,
    labelled_frames,
    labelled_scenes,
)
from torch import Tensor, nn
from torch.nn import functional

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.map.map_network import (
    CELL,
    LIGHT_CELLS,
    STRIDE,
    normalised,
    padded,
)

CHANNELS = (8, 24, 48, 96, 128)
"""Number of channels at a half, a quarter, ... of the picture's size."""

DILATIONS = ((), (), (1, 2), (1, 2, 1))
"""Dilations of the blocks at a quarter, an eighth, ... of the picture's size: most lie where all of
a cable is seen at once."""

BATCH = 32

HIGHEST_RATE, GOING_ON_RATE, WARM_UP = 4e-3, 5e-4, 0.15
"""Largest learning rates, of a new network and of one that is trained further, and the share of the
steps until it is reached."""

SHARPENED = 1.2
"""Factor of the log-odds. A network that has seen every picture changed in many ways is less sure
of a single one than it could be. Chosen for an earlier state of the network in use."""

OVERLAP_WEIGHT = 0.3
"""Weight of the overlap in the loss: without it, thin cables count next to nothing."""

WITHOUT_CABLE = 0.25
"""Share of the pictures that are drawn among those without a cable."""

SCENE_SHARE = 0.3
"""Share of the scenes in a batch."""


def _convolution(
    before: int, after: int, stride: int = 1, size: int = 3, dilation: int = 1
) -> nn.Sequential:
    """Return a convolution with its normalisation and activation."""
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
    """Draw the indices of a batch's frames, a share `WITHOUT_CABLE` of them without a cable."""
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
    """Return the loss: cross-entropy of the cells, and one less their overlap with the truth."""
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


def blend(first: Path, second: Path, share: float, path: Path) -> None:
    """Write the network whose weights are means of those of two, `share` of the second.

    Of one network and what it became when it was trained further, such a mean does better on
    pictures unlike those of either training (M. Wortsman et al., 2022).
    """
    model, other = onnx.load(first), onnx.load(second)
    weights = {each.name: onnx.numpy_helper.to_array(each) for each in other.graph.initializer}
    for each in model.graph.initializer:
        own = onnx.numpy_helper.to_array(each)
        if own.dtype == np.float32:
            mean = own + np.float32(share) * (weights[each.name] - own)
            each.CopyFrom(onnx.numpy_helper.from_array(mean, each.name))
    onnx.save(model, path)


def sharpen(network: MapNetwork) -> None:
    """Sharpen the log-odds of a network that has been trained."""
    last = network.log_odds
    last.weight.data = SHARPENED * last.weight.data
    last.bias.data = SHARPENED * last.bias.data


def blunt(network: MapNetwork) -> None:
    """Undo `sharpen`, to train a network further."""
    last = network.log_odds
    last.weight.data = last.weight.data / SHARPENED
    last.bias.data = last.bias.data / SHARPENED


def main() -> None:
    """Render, train, and write the network."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("--frames", type=Path, default=Path("frames_to_train_on"))
    parser.add_argument("--steps", type=int, default=12000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--go-on", type=Path, metavar="NETWORK")
    parser.add_argument("--blend", nargs=3, metavar=("NETWORK", "NETWORK", "SHARE"))
    chosen = parser.parse_args()
    if chosen.blend is not None:
        first, second, share = chosen.blend
        blend(Path(first), Path(second), float(share), chosen.output)
        return
    frames, scenes = labelled_frames(chosen.frames), labelled_scenes(chosen.frames)
    network = train(frames, scenes, chosen.steps, chosen.seed, chosen.go_on)
    sharpen(network)
    export(network, chosen.output)


if __name__ == "__main__":
    main()
