from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate


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
