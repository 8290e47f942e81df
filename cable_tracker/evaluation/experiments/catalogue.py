"""All experiments by name, and the files that they write."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Protocol

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.campaigns.settings import CampaignSettings
from cable_tracker.evaluation.evaluation_sequences import THESIS_SEQUENCES
from cable_tracker.evaluation.experiments.ablation import AblationExperiment, cold_ablation
from cable_tracker.evaluation.experiments.ablation_rows import ABLATION_TABLES
from cable_tracker.evaluation.experiments.coverage_experiment import reported_coverage
from cable_tracker.evaluation.experiments.experiment_result import (
    TABLE_CSV,
    TABLE_MARKDOWN,
    ExperimentResult,
)
from cable_tracker.evaluation.experiments.metres_experiment import TABLES as METRES_TABLES
from cable_tracker.evaluation.experiments.metres_experiment import MetresExperiment
from cable_tracker.evaluation.experiments.motion_experiment import MotionExperiment
from cable_tracker.evaluation.experiments.roc_experiment import reported_roc
from cable_tracker.evaluation.experiments.strips_experiment import StripsExperiment
from cable_tracker.evaluation.experiments.thesis_experiments import (
    ReinitialisationExperiment,
    SequenceExperiment,
    SpeedExperiment,
)


class Experiment(Protocol):
    """An experiment that is ready to be run."""

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through; None if that is not known."""
        ...

    def run(self, settings: CampaignSettings, advance: Callable[[int], None]) -> ExperimentResult:
        """Run it; `advance` is told now and then how many more frames are done."""
        ...


EXPERIMENTS: Mapping[str, Callable[[tuple[int, ...]], Experiment]] = MappingProxyType(
    {
        "sequences": SequenceExperiment,
        "reinitialisation": ReinitialisationExperiment,
        "speed": SpeedExperiment,
        "ablation": AblationExperiment,
        "ablation_cold": cold_ablation,
        "metres": MetresExperiment,
        "motion": MotionExperiment,
        "roc": reported_roc,
        "strips": StripsExperiment,
        "coverage": reported_coverage,
    }
)
"""Functions that make an experiment from its seeds, by the name on the command line."""

WITH_LIMIT: Mapping[str, Callable[[tuple[int, ...], int], Experiment]] = MappingProxyType(
    {"ablation_cold": cold_ablation, "roc": reported_roc, "coverage": reported_coverage}
)
"""Those of which so many frames of each dive may be used, given after the seeds."""

FILES = frozenset(
    {
        TABLE_MARKDOWN,
        TABLE_CSV,
        *(f"sequence_{name}.png" for name in THESIS_SEQUENCES),
        "clear_starts.csv",
        "reinitialisation.png",
        "speed.png",
        *(table.file_name for table in ABLATION_TABLES),
        *(file_name for _, file_name in METRES_TABLES.values()),
        *(f"{name}.csv" for name in PRESETS),
        "roc.png",
        "coverage.csv",
        "factors.csv",
    }
)
"""Names of all files that experiments write."""
