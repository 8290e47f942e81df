"""What an experiment is, what it results in, and how that is written into a folder."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from cable_tracker.atomic_output import write_bytes
from cable_tracker.campaigns.settings import CampaignSettings
from cable_tracker.evaluation.result_table import ResultTable, table_csv, table_markdown
from cable_tracker.evaluation.runs import Campaign, RunResult, evaluate_methods

TABLE_MARKDOWN = "table.md"


@dataclass(frozen=True, slots=True)
class FigureFile:
    """A figure as a PNG file."""

    file_name: str
    content: bytes


@dataclass(frozen=True, slots=True)
class ExperimentResult:
    """Results of an experiment.

    Attributes
    ----------
    title : str
        Title of the experiment.
    tables : tuple of ResultTable
        Tables of numbers, each with a file name of its own.
    pictures : tuple of FigureFile
        The figures.
    """

    title: str
    tables: tuple[ResultTable, ...]
    pictures: tuple[FigureFile, ...] = ()

    def file_names(self) -> tuple[str, ...]:
        """Return the names of all files that `write_experiment` writes."""
        tables = (table.file_name for table in self.tables)
        return (TABLE_MARKDOWN, *tables, *(picture.file_name for picture in self.pictures))


class Experiment(Protocol):
    """An experiment that is ready to be run."""

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through; None if that is not known."""
        ...

    def run(self, settings: CampaignSettings, advance: Callable[[int], None]) -> ExperimentResult:
        """Run it; `advance` is called with the number of frames done since its last call."""
        ...


class CampaignExperiment(ABC):
    """An experiment that is one campaign of runs."""

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
        """Run it; `advance` is called with the number of frames done since its last call."""
        return self.result_of(evaluate_methods(self.campaign(), settings, advance=advance))


def result_markdown(result: ExperimentResult, note: str) -> str:
    """Return title, note, tables and figures as Markdown."""
    parts = [f"# {result.title}", note, *(table_markdown(table) for table in result.tables)]
    parts += [f"![{picture.file_name}]({picture.file_name})" for picture in result.pictures]
    return "\n\n".join(parts) + "\n"


def write_experiment(folder: Path, result: ExperimentResult, note: str) -> None:
    """Write tables and figures; the note stands below the title.

    Raises
    ------
    OutputError
        A file cannot be written.
    """
    for table in result.tables:
        write_bytes(folder / table.file_name, table_csv(table).encode())
    write_bytes(folder / TABLE_MARKDOWN, result_markdown(result, note).encode())
    for picture in result.pictures:
        write_bytes(folder / picture.file_name, picture.content)
