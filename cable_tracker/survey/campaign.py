"""A survey of many recordings: each a task, then all routes together."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from cable_tracker import __version__
from cable_tracker.atomic_output import alone_in, atomic_file
from cable_tracker.campaigns.folder_tasks import (
    MARKER,
    Outcome,
    TaskState,
    fingerprint_of_files,
    forget,
    is_done,
    is_result,
)
from cable_tracker.campaigns.result_store import noting_finished_tasks
from cable_tracker.campaigns.runner import run_folder_tasks
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.errors import ParameterError, RecordingError, write_failure
from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.metric.recorded_instruments import own_vehicle_file
from cable_tracker.printable import printable
from cable_tracker.sequences.recording_files import recording_files
from cable_tracker.survey.outputs.frames import FRAMES, join_frames
from cable_tracker.survey.outputs.maps import WRITERS, SurveyMap
from cable_tracker.survey.outputs.report import RecordingRow, write_report
from cable_tracker.survey.outputs.surveyed_dive import (
    PICTURES,
    RECORDINGS,
    ROUTES,
    SUMMARY,
    Origin,
    SurveyedDive,
    read_origin,
    read_surveyed,
)
from cable_tracker.survey.recording import SurveySettings, find_datum, survey_recording
from cable_tracker.survey.routes.merging import MergedRoute, merge

REPORT = "report.html"
OWN_NAMES = frozenset({FRAMES, ROUTES, SUMMARY, PICTURES, MARKER})
"""All that is ever written into the folder of a recording."""

WITHOUT_PLACE = "without_place"
"""Folder of the map of routes that are not on the earth, where others are."""


@dataclass(frozen=True, slots=True)
class SurveyTask:
    """Survey one recording.

    Attributes
    ----------
    path : Path
        The recording.
    settings : SurveySettings
        Settings of the survey.
    name : str
        Name of the recording's results and of their folder.
    """

    path: Path
    settings: SurveySettings
    name: str

    def fingerprint(self) -> str:
        """Return a text that changes with the recording and the settings."""
        forward = self.settings.forward
        vehicle = forward.vehicle or own_vehicle_file(self.path)
        files = (*recording_files(self.path), vehicle, *forward.parameters.files)
        return f"{fingerprint_of_files(*files)} {self.settings!r}"

    @staticmethod
    def is_own_name(name: str) -> bool:
        """Tell whether a survey writes a file of this name into the folder of a recording."""
        return name in OWN_NAMES

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        """Survey it."""
        survey_recording(self.path, folder, self.settings, advance, name=self.name)


@dataclass(frozen=True, slots=True)
class SurveyResult:
    """Result of a survey.

    Attributes
    ----------
    routes : tuple of MergedRoute
        Routes: those on the earth, longest first, then the others.
    names : tuple of str
        Names of the routes in the files; of those in a folder of their own with its name before.
    outcomes : tuple of Outcome
        Outcomes, one for each recording.
    rows : tuple of RecordingRow
        Rows of the table of recordings, with the remarks about each.
    left_out : tuple of str
        Names of earlier results beside these, of recordings that were not given this time: they are
        not in the map.
    is_earlier_map_kept : bool
        Whether no recording could be surveyed, and the map of an earlier survey is as it was.
    """

    routes: tuple[MergedRoute, ...]
    names: tuple[str, ...]
    outcomes: tuple[Outcome, ...]
    rows: tuple[RecordingRow, ...]
    left_out: tuple[str, ...]
    is_earlier_map_kept: bool = False


def holds_survey(output: Path) -> bool:
    """Tell whether a survey has written a folder, be it that no recording could be surveyed.

    Recordings too may lie in a folder of that name.
    """
    root = output / RECORDINGS
    if not root.is_dir():
        return False
    found = [each for each in root.iterdir() if not each.name.startswith(".")]
    return not found or any(map(is_result, found))


def names_of(paths: Sequence[Path], earlier: Mapping[str, Path] | None = None) -> list[str]:
    """Return the names of recordings: those of their files, after the folder's where two agree.

    Parameters
    ----------
    paths : sequence of Path
        The recordings.
    earlier : mapping of str to Path or None
        Whole paths of recordings by names that they have already: these they keep, and no other
        recording gets one of them.

    Raises
    ------
    ParameterError
        One recording is given twice.
    """
    whole = [path.resolve() for path in paths]
    twice = sorted({str(path) for path in whole if whole.count(path) > 1})
    if twice:
        raise ParameterError(f"{', '.join(twice)} is given twice; leave one out")
    names: dict[Path, str] = {}
    for name, recording in (earlier or {}).items():
        if recording in whole:
            names.setdefault(recording, name)
    new = [path for path in whole if path not in names]
    names |= zip(new, _new_names(new, set(earlier or ())), strict=True)
    return [names[path] for path in whole]


def _new_names(paths: Sequence[Path], taken: Set[str]) -> list[str]:
    """Return a name for each whole path, none of which is taken or given twice."""
    names = short = [printable(path.name) for path in paths]
    agree = {name for name in short if name in taken or short.count(name) > 1}
    for depth in range(2, max((len(path.parts) for path in paths), default=0) + 1):
        if len(set(names)) == len(names) and taken.isdisjoint(names):
            break
        long = [printable("_".join(path.parts[-depth:]).replace("/", "")) for path in paths]
        names = [folders if own in agree else own for own, folders in zip(short, long, strict=True)]
    return names


def run_survey(
    paths: Sequence[Path],
    output: Path,
    settings: SurveySettings,
    cluster: ClusterSettings,
    *,
    resume: bool = False,
    advance: Callable[[int], None] = lambda count: None,
) -> SurveyResult:
    """Survey recordings, merge their routes, and write everything into a folder.

    Without a datum that of earlier results is taken, where these are kept: with another one they
    would all have to be made anew. Else it is the first fix of the first recording that has one.
    Recordings keep the names of their earlier results likewise. Those that cannot be laid on the
    earth keep routes of their own. Where no recording can be surveyed, an earlier map stays.

    Raises
    ------
    ParameterError
        A recording is given twice, or the cluster cannot be used.
    OutputError
        The folder cannot be written, or another survey is writing it.
    """
    root = output / RECORDINGS
    earlier = _origins_in(root) if resume else {}
    datum = settings.datum or _usual_datum(earlier.values())
    datum = datum or find_datum(paths, settings.forward)
    settings = replace(settings, datum=datum)
    names = names_of(paths, _names_in_use(earlier, paths))
    tasks = [
        SurveyTask(path.resolve(), settings, name) for path, name in zip(paths, names, strict=True)
    ]

    def finished() -> int:
        return sum(is_done(task, root / task.name, __version__) for task in tasks)

    with alone_in(root), noting_finished_tasks(root, finished):
        outcomes = run_folder_tasks(tasks, root, cluster, resume=resume, advance=advance)
        return _merge_and_write(output, outcomes, datum, paths)


def _origins_in(root: Path) -> dict[str, Origin]:
    """Return the origins of earlier results in a folder by their names, where they are given."""
    if not root.is_dir():
        return {}
    found = {
        folder.name: read_origin(folder) for folder in sorted(root.iterdir()) if is_result(folder)
    }
    return {name: origin for name, origin in found.items() if origin is not None}


def _names_in_use(earlier: Mapping[str, Origin], paths: Sequence[Path]) -> dict[str, Path]:
    """Return the recordings of earlier results by their names.

    One that is neither given nor where it was may have been moved, and be given under another path.
    """
    named = {path.resolve() for path in paths}
    return {
        name: origin.recording
        for name, origin in earlier.items()
        if origin.recording in named or os.path.lexists(origin.recording)
    }


def _usual_datum(origins: Iterable[Origin]) -> tuple[float, float] | None:
    """Return the datum of most earlier results [deg]; None: they have none."""
    counts = Counter(origin.datum for origin in origins if origin.datum is not None)
    return counts.most_common(1)[0][0] if counts else None


def _merge_and_write(
    output: Path,
    outcomes: Sequence[Outcome],
    datum: tuple[float, float] | None,
    paths: Sequence[Path],
) -> SurveyResult:
    """Merge the results of all recordings, and write them."""
    root = output / RECORDINGS
    results = [_read_result(root, outcome) for outcome in outcomes]
    dives, rows = [dive for dive, _ in results if dive is not None], [row for _, row in results]
    if not dives and (output / FRAMES).is_file():
        return SurveyResult((), (), tuple(outcomes), tuple(rows), (), is_earlier_map_kept=True)
    try:
        routes, names = _write_all(output, dives, rows, datum)
    except OSError as error:
        raise write_failure(output, error) from error
    left_out = _results_of_others(root, paths) - {outcome.name for outcome in outcomes}
    return SurveyResult(routes, names, tuple(outcomes), tuple(rows), tuple(sorted(left_out)))


def _read_result(root: Path, outcome: Outcome) -> tuple[SurveyedDive | None, RecordingRow]:
    """Read the results of a recording; return them, None if it failed, and its row of the table."""
    if outcome.state is TaskState.FAILED:
        return None, RecordingRow(outcome.name, f"failed: {printable(outcome.reason)}")
    try:
        dive = read_surveyed(root / outcome.name)
    except RecordingError as error:
        # What is damaged is not kept: the next `--resume` does it again.
        forget(root / outcome.name)
        return None, RecordingRow(outcome.name, f"failed: {printable(str(error))}")
    notes = tuple(map(printable, dive.notes))
    return dive, RecordingRow(dive.name, "done", dive.frames, dive.tracked, dive.seconds, notes)


def _results_of_others(root: Path, paths: Sequence[Path]) -> set[str]:
    """Return the names of results in a folder that are of none of some recordings."""
    named = {path.resolve() for path in paths}
    own = {name for name, origin in _origins_in(root).items() if origin.recording in named}
    return {
        printable(folder.name)
        for folder in root.iterdir()
        if is_result(folder) and folder.name not in own
    }


def _write_all(
    output: Path,
    dives: Sequence[SurveyedDive],
    rows: Sequence[RecordingRow],
    datum: tuple[float, float] | None,
) -> tuple[tuple[MergedRoute, ...], tuple[str, ...]]:
    """Merge the routes of dives, and write them; return routes and names of `SurveyResult`."""
    on_earth = [placed for dive in dives if dive.on_earth for placed in dive.routes]
    unplaced = [placed for dive in dives if not dive.on_earth for placed in dive.routes]
    in_time = tuple(event for dive in dives for event in dive.events)
    frame = LocalFrame(*datum) if datum is not None and on_earth else None
    merged = _longest_first(merge(on_earth))
    apart = _longest_first([route for placed in unplaced for route in merge([placed])])
    folder_apart = output / WITHOUT_PLACE
    _remove_map(folder_apart)
    names, names_apart = _names(merged), _names(apart)
    # One file has one frame: routes on the earth, and those of each odometry in a folder beside.
    if frame is not None:
        _write_map(output, SurveyMap(tuple(merged), frame, names, in_time), rows)
        if apart:
            folder_apart.mkdir(exist_ok=True)
            _write_map(folder_apart, SurveyMap(tuple(apart), None, names_apart, root="../"), rows)
            names_apart = tuple(f"{WITHOUT_PLACE}: {name}" for name in names_apart)
    else:
        _write_map(output, SurveyMap(tuple(apart), None, names_apart, in_time), rows)
    _write_all_frames(output, dives)
    return (*merged, *apart), (*names, *names_apart)


def _write_all_frames(output: Path, dives: Sequence[SurveyedDive]) -> None:
    """Write the frames of all dives into one table; without dives there is none."""
    parts = [output / RECORDINGS / dive.name / FRAMES for dive in dives]
    (output / FRAMES).unlink(missing_ok=True)
    if parts:
        with atomic_file(output / FRAMES) as part:
            join_frames(parts, part)


def _remove_map(folder: Path) -> None:
    """Remove the files of an earlier map, and their folder unless it holds others."""
    for name in (*WRITERS, REPORT):
        (folder / name).unlink(missing_ok=True)
    # What the user has put there stays, and the folder with it; or there is none.
    with suppress(OSError):
        folder.rmdir()


def _longest_first(routes: Iterable[MergedRoute]) -> list[MergedRoute]:
    return sorted(routes, key=lambda route: -float(route.along[-1]))


def _write_map(output: Path, survey: SurveyMap, rows: Sequence[RecordingRow]) -> None:
    survey = replace(survey, folder=output)
    for name, write in WRITERS.items():
        with atomic_file(output / name) as part:
            write(part, survey)
            is_written = part.exists()
        if not is_written:
            # A map of layers without any: what an earlier survey has left is not of this one.
            (output / name).unlink(missing_ok=True)
    with atomic_file(output / REPORT) as part:
        write_report(part, survey, rows, "Cable survey")


def _names(routes: Sequence[MergedRoute]) -> tuple[str, ...]:
    return tuple(f"route {number}" for number in range(1, len(routes) + 1))
