"""How much a cable moves from frame to frame: the noise of the movement model.

Tables 4.2 and 4.3 of the thesis list these variances for its sequences.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.geometry import wrap_states
from cable_tracker.cable.state import STATE_SIZE
from cable_tracker.errors import ParameterError
from cable_tracker.simulation.scenario import scenario_states
from cable_tracker.simulation.scenarios import SCENARIOS, Scenario

UNITS = np.array((1.0, np.rad2deg(1.0) ** 2, 1.0, np.rad2deg(1.0) ** 2))
"""Turns px² and rad² of d, alpha, w, beta into px² and deg²."""


@dataclass(frozen=True, slots=True, eq=False)
class VarianceRow:
    """Frame-to-frame variances of one simulated sequence.

    Attributes
    ----------
    scenario : str
        Name of the scenario.
    seed : int
        What it was drawn from.
    measured : FloatArray
        Of d, alpha, w, beta, shape (4,) [px², deg²].
    wanted : FloatArray
        What the scenario asks for, shape (4,); NaN where it asks for nothing.
    """

    scenario: str
    seed: int
    measured: FloatArray
    wanted: FloatArray


def increment_variances(states: FloatArray) -> FloatArray:
    """Return the sample variances of the differences between consecutive states.

    Parameters
    ----------
    states : FloatArray
        d, alpha, w, beta in the first columns, shape (N, 4) or (N, 8) [px, rad]. Rows with NaN are
        frames without a label; the steps to and from them do not count. An angle may go across the
        wrap.

    Returns
    -------
    FloatArray
        Of d [px²], alpha [deg²], w [px²], beta [deg²], shape (4,).

    Raises
    ------
    ParameterError
        There are fewer than two steps between labelled frames.
    """
    full = np.zeros((states.shape[0], STATE_SIZE))
    full[:, :4] = states[:, :4]
    labelled = np.asarray(np.isfinite(full).all(axis=1))
    pairs = labelled[1:] & labelled[:-1]
    count = int(pairs.sum())
    if count < 2:
        raise ParameterError(
            f"{count} steps between labelled frames: give at least 3 consecutive labelled frames"
        )
    before, after = full[:-1][pairs], full[1:][pairs]
    # In the chart of the state before, a step across the wrap is as small as any other.
    after[:, 1] -= before[:, 1]
    steps = wrap_states(after)
    steps[:, (0, 2, 3)] -= before[:, (0, 2, 3)]
    variances: FloatArray = np.var(steps[:, :4], axis=0, ddof=1) * UNITS
    return variances


def scenario_variances(
    seeds: Iterable[int], scenarios: Mapping[str, Scenario] = SCENARIOS
) -> tuple[VarianceRow, ...]:
    """Return the variances of every scenario that shows a cable, for every seed.

    Only the geometry is worked out; nothing is rendered.
    """
    chosen = tuple(seeds)
    return tuple(
        VarianceRow(
            scenario.name,
            seed,
            increment_variances(scenario_states(scenario, seed)),
            _wanted(scenario),
        )
        for scenario in scenarios.values()
        if scenario.has_cable
        for seed in chosen
    )


def _wanted(scenario: Scenario) -> FloatArray:
    motion = scenario.motion
    sways = (motion.distance, motion.angle, motion.width, motion.skew)
    return np.array([np.nan if sway.variance is None else sway.variance for sway in sways])
