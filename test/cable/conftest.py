from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.cable.model.geometry import project_borders
from cable_tracker.cable.model.state import CableState
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.simulation.scenario import SimulationSettings, simulate


def strip_picture(
    state: CableState, size: tuple[int, int] = (320, 240), *, strip=200.0, ground=60.0, blur=1.0
) -> Image:
    """Draw an ideal strip between two soft straight borders; uint8."""
    width, height = size
    x = (np.arange(width) - (width - 1) / 2)[None, :]
    y = ((height - 1) / 2 - np.arange(height))[:, None]
    borders = project_borders(state.to_array()[None, :])
    (left, right), (low, high) = borders.angles[0], borders.offsets[0]
    inside = 1.0
    for angle, offset, sign in ((left, low, 1.0), (right, high, -1.0)):
        across = sign * (x * np.cos(angle) + y * np.sin(angle) - offset)
        inside = inside * (1 + np.tanh(across / blur)) / 2
    return np.rint(ground + (strip - ground) * inside).astype(np.uint8)


@cache
def simulated_dive(size: tuple[int, int], frames: int, clutter: float, seed: int):
    settings = SimulationSettings(
        frame_count=frames, image_size=size, clutter=clutter, seed=seed, noise=2.0
    )
    return tuple(
        (decode_grey(frame.image), frame.stamp, frame.truth) for frame in simulate(settings)
    )


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(4711)


@pytest.fixture
def draw_strip() -> Callable[..., Image]:
    return strip_picture


@pytest.fixture
def dive() -> Callable[..., tuple]:
    """Simulate (grey picture, stamp, truth) of each frame."""

    def make(size=(160, 120), frames=40, clutter=0.1, seed=3):
        return simulated_dive(size, frames, clutter, seed)

    return make


@pytest.fixture
def noise_picture() -> Callable[..., Image]:
    """Make a picture of smooth grey noise without any cable."""

    def make(seed: int, size: tuple[int, int] = (160, 120), sigma: float = 8.0) -> Image:
        values = np.random.default_rng(seed).normal(110.0, sigma, size[::-1])
        return np.clip(np.rint(values), 0, 255).astype(np.uint8)

    return make
