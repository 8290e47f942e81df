"""Experiments that are one campaign of runs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

from cable_tracker.campaigns.settings import CampaignSettings
from cable_tracker.evaluation.campaign import Campaign, evaluate_methods
from cable_tracker.evaluation.experiments.experiment_result import ExperimentResult
from cable_tracker.evaluation.runs import RunResult


class CampaignExperiment(ABC):
    """A campaign, and what is said of its runs."""

    @abstractmethod
    def campaign(self) -> Campaign:
        """Return what is run."""

    @abstractmethod
    def result_of(self, results: Sequence[RunResult]) -> ExperimentResult:
        """Put the runs into tables and figures."""

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through; None if that is not known."""
        return self.campaign().frame_count()

    def run(self, settings: CampaignSettings, advance: Callable[[int], None]) -> ExperimentResult:
        """Run it; `advance` is told now and then how many more frames are done."""
        return self.result_of(evaluate_methods(self.campaign(), settings, advance=advance))
