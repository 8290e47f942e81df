"""`cable-tracker learn`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from cable_tracker.cable.measure.learning import ResponseCounts
from cable_tracker.cable.measure.response_table import is_table
from cable_tracker.cable.measure.working_image import check_frame, make_working_image
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.commands.options import (
    ForceOption,
    OutsideOption,
    PresetName,
    RateOption,
    SkipOption,
    TopicOption,
    TruthOption,
    open_recording,
)
from cable_tracker.commands.terminal import console, counted, progress_bar
from cable_tracker.commands.track import chosen_parameters
from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.evaluation.folder import output_file
from cable_tracker.evaluation.judged_sequences import check_labels
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.source import Source
from cable_tracker.simulation.scenario import simulate_scenario
from cable_tracker.simulation.scenarios import SCENARIOS, find_scenario
from cable_tracker.tracking.parameter_files import read_parameter_file

MOST_SEEDS = 1000

SEEDS = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?")
"""One seed, or the first and the last of some."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledSequence:
    """Something to learn from.

    Attributes
    ----------
    name : str
        What messages call it.
    frame_count : int or None
        Number of frames; None when it is unknown before all have been read.
    frames : callable
        Makes or reads them. A frame in which nothing of the cable can be seen has no truth.
    """

    name: str
    frame_count: int | None
    frames: Callable[[], Iterator[Frame]]


def learn(  # noqa: PLR0917
    output: Annotated[Path, typer.Option(help="Table to write, a JSON file.")],
    source: Annotated[
        list[Path] | None, typer.Argument(help="Labelled recordings of any kind.")
    ] = None,
    truth: TruthOption = None,
    scenario: Annotated[
        list[str] | None,
        typer.Option(
            help=f"Learn from simulated dives ({', '.join(SCENARIOS)}), too; may be given several"
            " times."
        ),
    ] = None,
    seeds: Annotated[
        str | None,
        typer.Option(help="Seeds of those dives, such as 0,4-6.  [default: 0]"),
    ] = None,
    every: Annotated[int, typer.Option(help="Use every K-th frame only.", min=1)] = 1,
    preset_name: Annotated[
        PresetName | None,
        typer.Option("--preset", help="Values to start from.  [default: default]"),
    ] = None,
    params: Annotated[
        Path | None,
        typer.Option(help="YAML file with the parameters that the table will be used with."),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Seed of the random numbers, instead of the preset's.")
    ] = None,
    force: ForceOption = False,
    topic: TopicOption = None,
    rate: RateOption = 25.0,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
) -> None:
    """Learn response tables from labelled recordings.

    They hold how likely a response of the border filter is on a cable and beside it.

    The tracker uses them with the parameter `response_table`. Its parameters `working_width` and
    `filter_sigma` should be those that the tables were learnt with. The same command writes the
    same file.
    """
    paths, scenarios = source or [], list(dict.fromkeys(scenario or []))
    _check_wishes(paths, truth, scenarios, seeds)
    numbers = parse_seeds(seeds if seeds is not None else "0")
    values = read_parameter_file(params) if params is not None else {}
    parameters = chosen_parameters(preset_name.value if preset_name else None, values, seed)
    sequences = [simulated_dive(name, number) for name in scenarios for number in numbers]
    counts = ResponseCounts(np.random.default_rng(parameters.seed))
    with ExitStack() as stack:
        for path in paths:
            recording = open_recording(path, topic, rate, truth, skip_bad_frames, allow_outside)
            sequences.append(labelled_recording(stack.enter_context(recording), truth))
        file = stack.enter_context(output_file(output, is_table, overwrite=force))
        progress = stack.enter_context(progress_bar("learning", total_of(sequences)))
        for sequence in sequences:
            frames = counted(sequence.frames(), progress)
            count_frames(
                counts,
                sequence.name,
                frames,
                parameters,
                every=every,
                skip_bad_frames=skip_bad_frames,
            )
        table = counts.table(describe_origin(scenarios, numbers, paths, truth, every))
        table.save(file)
    console.print(
        f"{counts.frames} frames, {counts.border_points} points on borders,"
        f" {counts.background_points} elsewhere",
        soft_wrap=True,
    )
    console.print(f"learnt from {table.source}: {output}", soft_wrap=True)


def _check_wishes(
    paths: Sequence[Path], truth: Path | None, scenarios: Sequence[str], seeds: str | None
) -> None:
    if not (paths or scenarios):
        raise ParameterError(
            "there is nothing to learn from; name a labelled recording, or give --scenario"
        )
    if truth is not None and len(paths) != 1:
        raise ParameterError(
            f"--truth labels a single recording, not {len(paths)}; learn from sequence files"
            " instead, which name their pictures"
        )
    if seeds is not None and not scenarios:
        raise ParameterError("--seeds draws simulated dives; give it with --scenario")


def parse_seeds(text: str) -> tuple[int, ...]:
    """Read seeds such as 0,4-6, each once, in the order given.

    Raises
    ------
    ParameterError
        The text is of another form, or there are too many.
    """
    seeds: list[int] = []
    for part in text.split(","):
        match = SEEDS.fullmatch(part.strip())
        first, last = (int(number) for number in match.groups(match[1])) if match else (1, 0)
        if first > last:
            raise ParameterError(f"seeds: {text!r} is not of the form 0,4-6")
        seeds += range(first, min(last, first + MOST_SEEDS) + 1)
    if len(seeds) > MOST_SEEDS:
        raise ParameterError(f"seeds: {text!r} are more than {MOST_SEEDS}")
    return tuple(dict.fromkeys(seeds))


def simulated_dive(scenario: str, seed: int) -> LabelledSequence:
    """Return a dive to learn from.

    Raises
    ------
    ParameterError
        There is no such scenario.
    """
    return LabelledSequence(
        f"{scenario}, seed {seed}",
        find_scenario(scenario).frame_count,
        lambda: (each.frame for each in simulate_scenario(scenario, seed)),
    )


def labelled_recording(recording: Source, truth: Path | None) -> LabelledSequence:
    """Return an open recording to learn from.

    Raises
    ------
    RecordingError
        It has no labels, or those of the file do not fit.
    """
    if truth is not None:
        check_labels(recording, truth)
    if not recording.has_truth:
        raise RecordingError(
            f"{recording.path}: has no ground truth to learn from; give labels with --truth FILE"
        )
    return LabelledSequence(str(recording.path), recording.frame_count, recording.frames)


def total_of(sequences: Iterable[LabelledSequence]) -> int | None:
    """Return the number of all frames; None if it is unknown of one."""
    counts = [sequence.frame_count for sequence in sequences]
    known = [count for count in counts if count is not None]
    return sum(known) if len(known) == len(counts) else None


def count_frames(
    counts: ResponseCounts,
    name: str,
    frames: Iterable[Frame],
    parameters: TrackerParameters,
    *,
    every: int,
    skip_bad_frames: bool,
) -> None:
    """Count the labelled ones of every K-th frame, as the tracker sees them.

    Raises
    ------
    FrameError
        A frame cannot be used and is not to be skipped.
    """
    for frame in frames:
        if frame.index % every or frame.truth is None:
            continue
        try:
            image = decode_grey(frame.image)
            check_frame(image)
        except FrameError as error:
            if skip_bad_frames:
                continue
            raise FrameError(f"{name}: frame {frame.index}: {error}") from error
        working_image = make_working_image(
            image,
            parameters.working_width,
            parameters.filter_sigma,
            parameters.sample_spacing,
        )
        counts.add(working_image, frame.truth)


def describe_origin(
    scenarios: Sequence[str],
    seeds: Sequence[int],
    paths: Sequence[Path],
    truth: Path | None,
    every: int,
) -> str:
    """Say what a table is learnt from, without the folders, which are nobody's business."""
    parts = []
    if scenarios:
        word = "seed" if len(seeds) == 1 else "seeds"
        numbers = ", ".join(map(str, seeds))
        parts.append(f"simulated {', '.join(scenarios)} with {word} {numbers}")
    parts += [path.resolve().name for path in paths]
    if truth is not None:
        parts[-1] += f" labelled by {truth.name}"
    if every > 1:
        parts.append(f"one frame in {every}")
    return "; ".join(parts)
