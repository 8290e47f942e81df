"""Many runs: methods x sequences x seeds, on several processors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from cable_tracker.campaigns.folder_tasks import fingerprint_of_files
from cable_tracker.campaigns.runner import run_all
from cable_tracker.campaigns.settings import HERE, CampaignSettings
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.evaluation_sequences import EvaluationSequence, frames_in_all
from cable_tracker.evaluation.methods import METHODS, ConfiguredFilter, Method
from cable_tracker.evaluation.runs import MethodRun, RunResult, Start, run_together
from cable_tracker.tracking.parameter_table import check_name


@dataclass(frozen=True, slots=True)
class Campaign:
    """Runs of a campaign.

    Attributes
    ----------
    methods : tuple of str
        Keys of `METHODS`.
    sequences : tuple of EvaluationSequence
        Sequences of the runs.
    seeds : tuple of int
        Seeds; each makes one run of every method on every sequence.
    start : Start
        Start that the methods are told.
    restart_every : int or None
        See `MethodRun`.
    with_sheets : bool
        Draw contact sheets of the first seed.
    filters : tuple of ConfiguredFilter
        Particle filters that are run after the methods; their names must differ.
    """

    methods: tuple[str, ...]
    sequences: tuple[EvaluationSequence, ...]
    seeds: tuple[int, ...]
    start: Start = Start.TRUTH
    restart_every: int | None = None
    with_sheets: bool = False
    filters: tuple[ConfiguredFilter, ...] = ()

    def __post_init__(self) -> None:
        for name in self.methods:
            check_name("method", name, METHODS)
        if not ((self.methods or self.filters) and self.sequences and self.seeds):
            raise ParameterError("give at least one method, one sequence and one seed")

    def makers(self) -> list[tuple[str, Callable[[int], Method]]]:
        """Return names of all methods and filters, and what makes them from a seed."""
        methods = [(name, METHODS[name].make) for name in self.methods]
        return methods + [(each.name, each.make) for each in self.filters]

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through; None if a recording does not say.

        Raises
        ------
        RecordingError
            A recording cannot be judged by.
        """
        counts = (sequence.frame_count() for sequence in self.sequences)
        return frames_in_all(counts, len(self.seeds))


@dataclass(frozen=True, slots=True)
class _Task:
    """One sequence with one seed: what one process does at a time."""

    campaign: Campaign
    sequence: EvaluationSequence
    seed: int

    @property
    def with_sheet(self) -> bool:
        """Whether contact sheets are drawn."""
        return self.campaign.with_sheets and self.seed == self.campaign.seeds[0]

    def fingerprint(self) -> str:
        """Return a text that changes with what is run, and with the recording."""
        own = replace(
            self.campaign,
            sequences=(self.sequence,),
            seeds=(self.seed,),
            with_sheets=self.with_sheet,
        )
        tables = [file for each in own.filters for file in each.parameters.files]
        return f"{own!r} {fingerprint_of_files(*self.sequence.files(), *tables)}"

    def run(self, advance: Callable[[int], None]) -> list[RunResult]:
        campaign = self.campaign
        runs = [
            MethodRun(
                name,
                make,
                self.seed,
                campaign.start,
                restart_every=campaign.restart_every,
                with_sheet=self.with_sheet,
            )
            for name, make in campaign.makers()
        ]
        frames = self.sequence.frames(self.seed)
        return run_together(runs, frames, self.sequence.name, advance)


def evaluate_methods(
    campaign: Campaign,
    settings: CampaignSettings = HERE,
    *,
    advance: Callable[[int], None] = lambda frames: None,
) -> list[RunResult]:
    """Run each method on each sequence with each seed.

    The results do not depend on the number of workers, except for the times.

    Parameters
    ----------
    campaign : Campaign
        Methods, sequences and seeds to run.
    settings : CampaignSettings
        Machines that run it, and the folder of results.
    advance : callable
        Told now and then how many more frames are done.

    Returns
    -------
    list of RunResult
        By sequence, then seed, then method, in the campaign's order.

    Raises
    ------
    ParameterError
        The cluster cannot be used.
    CableTrackerError
        What stopped the first run that failed.
    """
    tasks = [_Task(campaign, s, seed) for s in campaign.sequences for seed in campaign.seeds]
    runs = run_all(tasks, settings, advance=advance)
    return [result for results in runs for result in results]
