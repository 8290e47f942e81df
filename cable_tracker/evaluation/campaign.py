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

    def parts(self) -> list[Campaign]:
        """Return the runs on each sequence with each seed: what one process does at a time."""
        return [
            replace(
                self,
                sequences=(sequence,),
                seeds=(seed,),
                with_sheets=self.with_sheets and seed == self.seeds[0],
            )
            for sequence in self.sequences
            for seed in self.seeds
        ]

    def fingerprint(self) -> str:
        """Return a text that changes with what is run, and with the recordings."""
        recorded = [file for each in self.sequences for file in each.files()]
        tables = [file for each in self.filters for file in each.parameters.files]
        return f"{self!r} {fingerprint_of_files(*recorded, *tables)}"

    def run(self, advance: Callable[[int], None]) -> list[RunResult]:
        """Run one of `parts`."""
        (sequence,), (seed,) = self.sequences, self.seeds
        runs = [
            MethodRun(
                name,
                make,
                seed,
                self.start,
                restart_every=self.restart_every,
                with_sheet=self.with_sheets,
            )
            for name, make in self.makers()
        ]
        return run_together(runs, sequence.frames(seed), sequence.name, advance)


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
        Called with the number of frames done since its last call.

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
    runs = run_all(campaign.parts(), settings, advance=advance)
    return [result for results in runs for result in results]
