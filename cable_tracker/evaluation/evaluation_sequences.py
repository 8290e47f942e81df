"""Sequences with ground truth for evaluation: simulated scenarios and labelled recordings."""

from __future__ import annotations

import fnmatch
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Protocol

from cable_tracker.arrays import Image
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.evaluation.trace import UNKNOWN_VISIBILITY
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import CompressedImage, Frame, RawImage
from cable_tracker.sequences.recording_files import recording_files
from cable_tracker.sequences.source import open_chosen
from cable_tracker.sequences.source_base import ChosenRecording
from cable_tracker.simulation.dive import SimulatedFrame
from cable_tracker.simulation.scenario_dive import simulate_scenario
from cable_tracker.simulation.scenarios import SCENARIOS
from cable_tracker.simulation.worlds.catalogue import WORLDS, Split, worlds_of
from cable_tracker.simulation.worlds.ground import photographs_of
from cable_tracker.simulation.worlds.strip import simulate_strip
from cable_tracker.simulation.worlds.world_dive import simulate_world

THESIS_SEQUENCES = ("S1", "S2", "S3", "S4", "S5", "S6")
"""Scenarios like the sequences of the thesis."""

STRIP_FRAMES = 10
"""Number of frames of a crisp strip."""


@dataclass(frozen=True, slots=True)
class LabelledRecording(ChosenRecording):
    """A recording with labels, the same for every seed.

    Attributes
    ----------
    unlabelled_is_empty : bool
        Whether a frame without a label shows nothing to track. Otherwise it is not judged.
    """

    unlabelled_is_empty: bool = field(default=False, kw_only=True)

    @property
    def name(self) -> str:
        """The name of the file or folder."""
        return self.path.resolve().name

    def decoded(
        self, frame: Frame, decode: Callable[[RawImage | CompressedImage], Image]
    ) -> Image | None:
        """Return the pixels of a frame; None for a bad one where such frames are left out.

        Raises
        ------
        RecordingError
            It cannot be decoded, and the user did not ask to go on.
        """
        try:
            return decode(frame.image)
        except FrameError as error:
            if self.skip_bad_frames:
                return None
            raise RecordingError(
                f"{self.path}: frame {frame.index} cannot be decoded ({error});"
                " --skip-bad-frames leaves such frames out"
            ) from error

    def files(self) -> list[Path]:
        """Return the paths that it is read from: files or a folder, and the labels."""
        labels = [] if self.truth is None else [self.truth]
        return [*recording_files(self.path), *labels]


@dataclass(frozen=True, slots=True, eq=False)
class EvaluationFrame:
    """A frame, decoded, with what is known about it.

    Attributes
    ----------
    index : int
        Number of the frame in its sequence.
    stamp : int
        Time of the frame [ns].
    image : Image
        Grey levels 0..255 as the tracker gets them everywhere, shape (H, W): uint8, or float32 of
        recordings with more than eight bits.
    truth : CableState or None
        True state of the cable; None if there is none, or it is unknown.
    visibility : float
        Share of the borders that can be seen, 0 to 1; NaN if unknown.
    """

    index: int
    stamp: int
    image: Image
    truth: CableState | None
    visibility: float


class EvaluationSequence(Protocol):
    """Something to judge methods on. It is sent to other processes, and opened there."""

    @property
    def name(self) -> str:
        """Name of the sequence in reports."""
        ...

    @property
    def description(self) -> str:
        """One sentence about the sequence."""
        ...

    def frame_count(self) -> int | None:
        """Return the number of frames; None if it is unknown before all have been read."""
        ...

    def files(self) -> list[Path]:
        """Return the files and folders that it is read from; none if it is made up."""
        ...

    def frames(self, seed: int) -> Iterator[EvaluationFrame]:
        """Make or read the frames."""
        ...


@dataclass(frozen=True, slots=True)
class SimulatedSequence(ABC):
    """A built-in dive of the simulator; each seed is another one.

    Attributes
    ----------
    name : str
        Name of the sequence; a key of the table that it stands in, if there is one.
    limit : int or None
        Number of frames used from the beginning; None: all.
    """

    name: str
    limit: int | None = None

    @property
    @abstractmethod
    def description(self) -> str:
        """One sentence about the sequence."""

    def frame_count(self) -> int | None:
        """Return the number of frames.

        Raises
        ------
        RecordingError
            It needs photographs, and there are none.
        """
        count = self._whole_count()
        return count if self.limit is None else min(count, self.limit)

    def files(self) -> list[Path]:
        """Return the files that it is made from.

        Raises
        ------
        RecordingError
            It needs photographs, and there are none.
        """
        return []

    def frames(self, seed: int) -> Iterator[EvaluationFrame]:
        """Simulate the dive of a seed."""
        for item in self.simulated(seed):
            yield _judged(item.frame, decode_grey(item.frame.image), item.visibility)

    def simulated(self, seed: int) -> Iterator[SimulatedFrame]:
        """Simulate the frames of a seed, as the simulator gives them."""
        return islice(self._dive(seed), self.limit)

    @abstractmethod
    def _whole_count(self) -> int:
        """Return the number of frames where there is no limit."""

    @abstractmethod
    def _dive(self, seed: int) -> Iterator[SimulatedFrame]:
        """Simulate all frames of a seed."""


@dataclass(frozen=True, slots=True)
class ScenarioSequence(SimulatedSequence):
    """A scenario: a key of `SCENARIOS`."""

    @property
    def description(self) -> str:
        """Description of the scenario."""
        return SCENARIOS[self.name].description

    def _whole_count(self) -> int:
        return SCENARIOS[self.name].frame_count

    def _dive(self, seed: int) -> Iterator[SimulatedFrame]:
        return simulate_scenario(self.name, seed)


@dataclass(frozen=True, slots=True)
class WorldSequence(SimulatedSequence):
    """A world: a key of `WORLDS`."""

    @property
    def description(self) -> str:
        """Description of the world."""
        return WORLDS[self.name].description

    def _whole_count(self) -> int:
        self.files()
        return WORLDS[self.name].frame_count

    def files(self) -> list[Path]:
        """Return the photographs that its ground is taken from."""
        world = WORLDS[self.name]
        return list(photographs_of(world.split)) if world.photographed else []

    def _dive(self, seed: int) -> Iterator[SimulatedFrame]:
        return simulate_world(self.name, seed)


@dataclass(frozen=True, slots=True)
class StripSequence(SimulatedSequence):
    """A crisp strip on a plain ground."""

    name: str = "strip"

    @property
    def description(self) -> str:
        """Description of the strip."""
        return "a crisp strip on a plain ground"

    def _whole_count(self) -> int:
        return STRIP_FRAMES

    def _dive(self, seed: int) -> Iterator[SimulatedFrame]:
        return simulate_strip(seed, STRIP_FRAMES)


@dataclass(frozen=True, slots=True)
class RecordingSequence(LabelledRecording):
    """A recording of the user's, labelled with cables."""

    @property
    def description(self) -> str:
        """Origin of the labels."""
        return f"labelled by {self.truth.name}" if self.truth is not None else ""

    def frame_count(self) -> int | None:
        """Return the number of frames, and see that there is something to judge.

        Raises
        ------
        RecordingError
            The recording or the labels cannot be read, do not fit, or there are none.
        """
        with open_chosen(self) as source:
            if not (source.has_truth or self.unlabelled_is_empty):
                raise RecordingError(
                    f"{self.path}: has no ground truth to judge by; give labels with --truth FILE,"
                    " or say with --unlabelled-is-empty that it shows no cable"
                )
            return source.frame_count

    def frames(self, seed: int) -> Iterator[EvaluationFrame]:
        """Read the recording.

        Raises
        ------
        RecordingError
            It is damaged, or has no frames. Frames that cannot be decoded are left out if they
            were asked to be skipped.
        """
        unlabelled = 0.0 if self.unlabelled_is_empty else UNKNOWN_VISIBILITY
        count = 0
        with open_chosen(self) as source:
            for frame in source.frames():
                count += 1
                image = self.decoded(frame, decode_grey)
                if image is not None:
                    yield _judged(frame, image, unlabelled if frame.truth is None else 1.0)
        if not count:
            raise RecordingError(f"{self.path}: holds no frames; record it again")


def _judged(frame: Frame, grey: Image, visibility: float) -> EvaluationFrame:
    return EvaluationFrame(frame.index, frame.stamp, grey, frame.truth, visibility)


def simulated_sequences(
    names: Sequence[str], limit: int | None = None
) -> tuple[SimulatedSequence, ...]:
    """Return scenarios and worlds by name, each once, in the order given.

    Parameters
    ----------
    names : sequence of str
        Keys of `SCENARIOS` or `WORLDS`, or patterns of them such as "report_*"; all scenarios, but
        no world, if no name is given.
    limit : int or None
        Number of frames used of each; None: all.

    Raises
    ------
    ParameterError
        There is no such scenario or world.
    """
    chosen: dict[str, SimulatedSequence] = {}
    for pattern in names or SCENARIOS:
        scenarios = fnmatch.filter(SCENARIOS, pattern)
        worlds = fnmatch.filter(WORLDS, pattern)
        if not (scenarios or worlds):
            known = " | ".join((*SCENARIOS, *WORLDS))
            raise ParameterError(f"scenario: {pattern!r} is none of {known}")
        chosen |= {name: ScenarioSequence(name, limit) for name in scenarios}
        chosen |= {name: WorldSequence(name, limit) for name in worlds}
    return tuple(chosen.values())


def available_sequences(
    names: Sequence[str], limit: int | None = None
) -> tuple[tuple[SimulatedSequence, ...], dict[str, str]]:
    """Return scenarios and worlds by name, and those of a pattern that can be drawn here.

    Returns
    -------
    sequences : tuple of SimulatedSequence
        See `simulated_sequences`.
    left_out : dict of str to str
        Why each other world that a pattern stands for cannot be drawn. What is named itself is
        never left out.

    Raises
    ------
    ParameterError
        There is no such scenario or world.
    RecordingError
        None of them can be drawn here.
    """
    sequences = simulated_sequences(names, limit)
    _, left_out = _drawable([each for each in sequences if each.name not in names])
    if len(left_out) == len(sequences):
        raise RecordingError(next(iter(left_out.values())))
    return tuple(each for each in sequences if each.name not in left_out), left_out


def reported_worlds(
    limit: int | None = None, *, with_cable: bool = False
) -> tuple[tuple[SimulatedSequence, ...], tuple[str, ...]]:
    """Return the worlds to report on that can be drawn here, and a note on each other one.

    `limit`: number of frames used of each, None: all; `with_cable`: only worlds with a cable.
    """
    worlds = (world for world in worlds_of(Split.REPORT) if world.has_cable or not with_cable)
    drawable, left_out = _drawable([WorldSequence(world.name, limit) for world in worlds])
    notes = tuple(f"`{name}` is left out: {reason}" for name, reason in left_out.items())
    return drawable, notes


def _drawable(
    sequences: Sequence[SimulatedSequence],
) -> tuple[tuple[SimulatedSequence, ...], dict[str, str]]:
    """Return the sequences that can be drawn here, and why each other one cannot, by its name."""
    drawable: list[SimulatedSequence] = []
    left_out: dict[str, str] = {}
    for each in sequences:
        try:
            each.files()
        except RecordingError as error:
            left_out[each.name] = str(error)
        else:
            drawable.append(each)
    return tuple(drawable), left_out


def frames_in_all(counts: Iterable[int | None], runs: int = 1) -> int | None:
    """Return how many frames sequences have in so many runs of each; None if one does not say."""
    known = list(counts)
    return None if None in known else runs * sum(count or 0 for count in known)
