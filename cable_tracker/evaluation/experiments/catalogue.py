"""All experiments by name, and the files that they write."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.evaluation.evaluation_sequences import (
    THESIS_SEQUENCES,
    StripSequence,
    simulated_sequences,
)
from cable_tracker.evaluation.experiments.ablation import (
    TABLE_FILE,
    AblationExperiment,
    cold_ablation,
)
from cable_tracker.evaluation.experiments.coverage_experiment import reported_coverage
from cable_tracker.evaluation.experiments.experiment import TABLE_MARKDOWN, Experiment
from cable_tracker.evaluation.experiments.metres_experiment import TABLES as METRES_TABLES
from cable_tracker.evaluation.experiments.metres_experiment import MetresExperiment
from cable_tracker.evaluation.experiments.motion_experiment import (
    MOTION_SEQUENCES,
    MotionExperiment,
)
from cable_tracker.evaluation.experiments.roc_experiment import reported_roc
from cable_tracker.evaluation.experiments.strips_experiment import StripsExperiment
from cable_tracker.evaluation.experiments.thesis_experiments import (
    ReinitialisationExperiment,
    SequenceExperiment,
    SpeedExperiment,
    speed_sequence,
)
from cable_tracker.evaluation.result_table import TABLE_CSV

ExperimentMaker: TypeAlias = Callable[[tuple[int, ...], int | None], Experiment]
"""Makes an experiment from its seeds and the number of frames used of each dive; None: all."""


def _of_scenarios(make: Callable[..., Experiment], names: Sequence[str]) -> ExperimentMaker:
    """Return a function that makes an experiment on some scenarios."""
    return lambda seeds, limit: make(seeds, sequences=simulated_sequences(names, limit))


EXPERIMENTS: Mapping[str, ExperimentMaker] = MappingProxyType(
    {
        "sequences": _of_scenarios(SequenceExperiment, THESIS_SEQUENCES),
        "reinitialisation": _of_scenarios(ReinitialisationExperiment, THESIS_SEQUENCES),
        "speed": lambda seeds, limit: SpeedExperiment(seeds, speed_sequence(limit)),
        "ablation": _of_scenarios(AblationExperiment, THESIS_SEQUENCES),
        "ablation_cold": cold_ablation,
        "metres": _of_scenarios(MetresExperiment, THESIS_SEQUENCES),
        "motion": _of_scenarios(MotionExperiment, MOTION_SEQUENCES),
        "roc": reported_roc,
        "strips": lambda seeds, limit: StripsExperiment(seeds, StripSequence(limit=limit)),
        "coverage": reported_coverage,
    }
)
"""Functions that make an experiment, by the name on the command line."""

FILES = frozenset(
    {
        TABLE_MARKDOWN,
        TABLE_CSV,
        *(f"sequence_{name}.png" for name in THESIS_SEQUENCES),
        "clear_starts.csv",
        "reinitialisation.png",
        "speed.png",
        TABLE_FILE,
        *(file_name for _, file_name in METRES_TABLES.values()),
        *(f"{name}.csv" for name in PRESETS),
        "roc.png",
        "coverage.csv",
        "factors.csv",
    }
)
"""Names of all files that experiments write."""
