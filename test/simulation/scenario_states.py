"""The geometry of a scenario without its pictures."""

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import STATE_SIZE
from cable_tracker.simulation.dive import BATCH, frame_times
from cable_tracker.simulation.scenario_dive import SCENARIO_SIZE, scenario_dive
from cable_tracker.simulation.scenarios import SCENARIO_RATE, find_scenario


def scenario_states(
    name: str, seed: int = 0, image_size: tuple[int, int] = SCENARIO_SIZE
) -> FloatArray:
    """Return exact states, shape (N, 8); NaN where no border of the cable is inside the image."""
    dive, scenario = scenario_dive(name, seed, image_size), find_scenario(name)
    if not scenario.has_cable:
        return np.full((scenario.frame_count, STATE_SIZE), np.nan)
    starts = range(0, scenario.frame_count, BATCH)
    batches = [dive.geometry(frame_times(start, SCENARIO_RATE)).states for start in starts]
    return np.concatenate(batches)[: scenario.frame_count]
