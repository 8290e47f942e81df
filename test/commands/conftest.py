"""Small recordings for commands."""

from functools import cache
from pathlib import Path

import pytest

from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate

GARBAGE = b"no recording \x00\xff" * 50


@cache
def small_dive(frames: int, clutter: float) -> tuple[Frame, ...]:
    """What `simulate` writes; worked out once, for most tests want it."""
    return tuple(simulate(SimulationSettings(frames, image_size=(64, 48), clutter=clutter)))


@pytest.fixture
def bag(command) -> Path:
    """A small simulated bag with truth."""
    write_bag(Path("dive"), small_dive(8, 0.1))
    return Path("dive")


@pytest.fixture
def unlabelled(bag, command) -> Path:
    """The same dive as pictures without labels."""
    write_sequence(Path("pictures"), small_dive(3, 0.5))
    Path("pictures/sequence.txt").unlink()
    return Path("pictures")
