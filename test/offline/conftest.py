from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate


class Recording:
    """An open source that holds its frames in memory, and may break off after them."""

    compressed = False
    note = ""

    def __init__(self, path, frames, damage=None) -> None:
        self.path = path
        self.frame_count = len(frames)
        self.has_truth = any(frame.truth is not None for frame in frames)
        self._frames = frames
        self._damage = damage

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def frames(self, start=0):
        yield from self._frames[start:]
        if self._damage is not None:
            raise self._damage


@pytest.fixture(scope="session")
def dive() -> tuple[Frame, ...]:
    """Twelve small frames of a clear dive, with truth."""
    settings = SimulationSettings(frame_count=12, image_size=(64, 48), clutter=0.1, seed=3)
    return tuple(simulate(settings))


@pytest.fixture
def make_recording(tmp_path, dive) -> Callable[..., Recording]:
    def make(frames=None, damage=None) -> Recording:
        return Recording(tmp_path / "dive", dive if frames is None else frames, damage)

    return make


@pytest.fixture
def undecodable() -> Callable[[Frame], Frame]:
    """Make the same frame with too few bytes."""

    def spoil(frame: Frame) -> Frame:
        image = frame.image
        assert isinstance(image, RawImage)
        return replace(frame, image=replace(image, data=image.data[:10]))

    return spoil
