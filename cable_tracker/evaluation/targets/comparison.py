"""Our filters of targets and their peers on the same frames: claimed boxes against true ones."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path
from types import MappingProxyType

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.campaigns.folder_tasks import fingerprint_of_files
from cable_tracker.errors import FrameError
from cable_tracker.evaluation.evaluation_sequences import frames_in_all
from cable_tracker.evaluation.result_table import ResultTable, table_markdown
from cable_tracker.evaluation.sample_statistics import mean
from cable_tracker.evaluation.targets.peers import PEERS, BoxTracker
from cable_tracker.evaluation.targets.target_sequences import TargetEvaluationFrame, TargetSequence
from cable_tracker.sequences.tables.csv_tables import write_csv
from cable_tracker.target.model.estimate import Box
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.parameters.presets import TARGET_PRESETS
from cable_tracker.target.tracker import TargetTracker

ENOUGH_OVERLAP = 0.5
"""Intersection over union of the boxes above which a frame is a success."""

RETURN_FRAMES = 15
"""Number of frames within which a target that comes back should be found."""

OWN_FRAMES = 20
"""Number of frames, the last after a crossing, that tell which target the box is on."""

GREY = "grey"
"""Word before the name of a method: it gets grey pictures."""

FIGURES = (
    "success", "centred", "claimed_in_view", "claimed_while_absent", "returns_found",
    "own_after_crossing", "ms",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class EvaluatedClaim:
    """One frame of a run.

    Attributes
    ----------
    truth : Box or None
        True box of the visible part of the target [px]; None while it is out of view.
    claim : Box or None
        None where no target is claimed.
    twin : Box or None
        True box of a second target of the same appearance [px].
    ms : float
        Processor time [ms].
    number : int
        Number of the frame in the run: between two, others may not count.
    """

    truth: Box | None
    claim: Box | None
    twin: Box | None
    ms: float
    number: int


def overlap(one: Box | None, two: Box | None) -> float:
    """Return the intersection of two boxes over their union; 0 without one of them."""
    if one is None or two is None:
        return 0.0
    width = min(one[2], two[2]) - max(one[0], two[0])
    height = min(one[3], two[3]) - max(one[1], two[1])
    if width <= 0.0 or height <= 0.0:
        return 0.0
    both = width * height
    areas = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (one, two))
    return both / (areas - both)


def success(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of frames in view whose box overlaps enough; NaN if none is in view."""
    return mean([overlap(c.truth, c.claim) > ENOUGH_OVERLAP for c in claims if c.truth])


def centred(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of frames in view whose box is centred within half the target's size.

    The size is the mean of width and height. NaN if none is in view.
    """
    return mean([_is_centred(c.truth, c.claim) for c in claims if c.truth])


def _is_centred(truth: Box, claim: Box | None) -> bool:
    if claim is None:
        return False
    across, down = ((claim[k] + claim[k + 2] - truth[k] - truth[k + 2]) / 2.0 for k in (0, 1))
    size = (truth[2] - truth[0] + truth[3] - truth[1]) / 2.0
    return math.hypot(across, down) < size / 2.0


def claimed_in_view(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of frames in view in which a target is claimed; NaN if none is."""
    return mean([c.claim is not None for c in claims if c.truth])


def claimed_while_absent(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of frames without the target in which it is claimed; NaN without such."""
    return mean([c.claim is not None for c in claims if c.truth is None])


def returns_found(claims: Sequence[EvaluatedClaim]) -> list[bool]:
    """Return, for every return into view, whether the target was found in time."""
    found = []
    for index in range(1, len(claims)):
        if claims[index].truth is not None and claims[index - 1].truth is None:
            last = claims[index].number + RETURN_FRAMES
            in_view = takewhile(lambda c: c.truth is not None, claims[index:])
            soon = [c for c in in_view if c.number <= last]
            found.append(any(overlap(c.truth, c.claim) > ENOUGH_OVERLAP for c in soon))
    return found


def share_on_own_target(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of the last frames whose box is the target's rather than its twin's."""
    last = [c for c in claims[-OWN_FRAMES:] if c.truth and c.twin]
    return mean([overlap(c.truth, c.claim) > overlap(c.twin, c.claim) for c in last])


class OwnTracker:
    """Our tracker as one that follows a box."""

    def __init__(self, parameters: TargetParameters) -> None:
        self._tracker = TargetTracker(parameters)
        self._event = ""

    def start(self, image: Image, box: Box, stamp: int) -> Box | None:
        """Take what is in the box for the target; frames are (H, W) or (H, W, 3)."""
        self._tracker.initialise(TargetStart.from_box(*box))
        claim = self.update(image, stamp)
        if not self._tracker.has_begun:
            raise FrameError(self._event)
        return claim

    def update(self, image: Image, stamp: int) -> Box | None:
        """Return the box in the next frame; None unless the status is TRACKING."""
        estimate = self._tracker.process(image, stamp)
        self._event = estimate.event
        return estimate.box if estimate.is_claimed else None


def method_names() -> list[str]:
    """Return the names of all methods: presets, peers, and each on grey pictures."""
    plain = [*TARGET_PRESETS, *PEERS]
    return plain + [f"{GREY} {name}" for name in plain]


def make_method(
    name: str, seed: int, tuned: Mapping[str, TargetParameters] = MappingProxyType({})
) -> BoxTracker:
    """Return a tracker by its name, without the word for grey pictures."""
    parameters = tuned.get(name, TARGET_PRESETS.get(name))
    if parameters is not None:
        return OwnTracker(parameters.replaced({"seed": seed}))
    return PEERS[name]()


@dataclass(frozen=True, slots=True)
class RunFigures:
    """Figures of one method on one run of a scenario; NaN where they say nothing.

    Attributes
    ----------
    scenario : str
        Name of the scenario, or of the recording.
    seed : int
        Seed of the run.
    method : str
        Name.
    values : tuple of float
        Values in the order of `FIGURES`.
    refusal : str
        Why the method did not take the first frame that it refused; empty: it refused none.
    """

    scenario: str
    seed: int
    method: str
    values: tuple[float, ...]
    refusal: str = ""


class TargetMethodRun:
    """One method, from the first frame that shows the target.

    Parameters
    ----------
    method : str
        Name, see `method_names`.

    Attributes
    ----------
    claims : list of EvaluatedClaim
        Claims in the frames that count.
    refusal : str
        See `RunFigures`.
    """

    def __init__(self, method: str, tracker: BoxTracker) -> None:
        self._name = method
        self._is_grey = method.startswith(f"{GREY} ")
        self._tracker = tracker
        self._has_begun = False
        self._number = -1
        self.claims: list[EvaluatedClaim] = []
        self.refusal = ""

    def process(self, frame: TargetEvaluationFrame) -> None:
        """Take one frame; those before the first that shows the target are passed over."""
        self._number += 1
        if not self._has_begun and frame.truth is None:
            return
        image = frame.image
        if self._is_grey:
            image = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        begin = time.process_time()
        try:
            claim = self._claim(image, frame)
        except FrameError as error:
            # A frame that is refused is one without a claim.
            claim = None
            self.refusal = self.refusal or f"frame {self._number}: {error}"
        ms = (time.process_time() - begin) * 1e3
        if frame.is_judged:
            self.claims.append(EvaluatedClaim(frame.truth, claim, frame.twin, ms, self._number))

    def result(self, sequence: str, seed: int) -> RunFigures:
        """Return the figures of the run, once there is a frame that counts."""
        return RunFigures(sequence, seed, self._name, figures_of(self.claims), self.refusal)

    def _claim(self, image: Image, frame: TargetEvaluationFrame) -> Box | None:
        if self._has_begun:
            return self._tracker.update(image, frame.stamp)
        assert frame.truth is not None
        self._has_begun = True
        return self._tracker.start(image, frame.truth, frame.stamp)


@dataclass(frozen=True, slots=True)
class TargetCampaign:
    """Campaign of target trackers.

    Attributes
    ----------
    sequences : tuple of TargetSequence
        Scenarios or recordings.
    seeds : tuple of int
        Seeds of the runs.
    methods : tuple of str
        Names.
    tuned : tuple of (str, TargetParameters)
        Parameters of the user's, by name.
    """

    sequences: tuple[TargetSequence, ...]
    seeds: tuple[int, ...]
    methods: tuple[str, ...]
    tuned: tuple[tuple[str, TargetParameters], ...] = ()

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through; None if a recording does not say."""
        counts = (sequence.frame_count() for sequence in self.sequences)
        return frames_in_all(counts, len(self.seeds))

    def parts(self) -> list[TargetCampaign]:
        """Return the runs on each sequence with each seed, those of one seed after another."""
        return [
            replace(self, sequences=(sequence,), seeds=(seed,))
            for seed in self.seeds
            for sequence in self.sequences
        ]

    def fingerprint(self) -> str:
        """Return a text that changes with what is run, and with the recordings."""
        recorded = [file for each in self.sequences for file in each.files()]
        return f"{self!r} {fingerprint_of_files(*recorded)}"

    def run(self, advance: Callable[[int], None]) -> list[RunFigures]:
        """Follow the target of one of `parts` with every method."""
        (sequence,), (seed,) = self.sequences, self.seeds
        tuned = dict(self.tuned)
        runs = [
            TargetMethodRun(name, make_method(name.removeprefix(f"{GREY} "), seed, tuned))
            for name in self.methods
        ]
        for frame in sequence.frames(seed):
            for run in runs:
                run.process(frame)
            advance(1)
        return [run.result(sequence.name, seed) for run in runs if run.claims]


def figures_of(claims: Sequence[EvaluatedClaim]) -> tuple[float, ...]:
    """Return the figures of a run, in the order of `FIGURES`."""
    has_twin = any(claim.twin for claim in claims)
    found = returns_found(claims)
    return (
        success(claims),
        centred(claims),
        claimed_in_view(claims),
        # What is hidden behind its twin has its box where the twin is: that claim is no error.
        float("nan") if has_twin else claimed_while_absent(claims),
        mean(found),
        share_on_own_target(claims) if has_twin else float("nan"),
        float(np.median([claim.ms for claim in claims])),
    )


def mean_figures(results: Sequence[RunFigures], method: str, scenario: str | None) -> list[float]:
    """Return the means of a method's figures over the runs of a scenario, or of all (None)."""
    rows = [
        each.values
        for each in results
        if each.method == method and scenario in {None, each.scenario}
    ]
    columns = np.array(rows).reshape(len(rows), len(FIGURES)).T
    return [mean(column[~np.isnan(column)]) for column in columns]


def write_figures(path: Path, results: Sequence[RunFigures]) -> None:
    """Write one row for every run and method."""
    rows = []
    for each in results:
        numbers = ["" if np.isnan(value) else f"{value:.4f}" for value in each.values]
        rows.append((each.scenario, each.seed, each.method, *numbers))
    write_csv(path, ("scenario", "seed", "method", *FIGURES), rows)


def markdown_table(results: Sequence[RunFigures], methods: Sequence[str], note: str) -> str:
    """Return the means over all runs, and the success by scenario, as Markdown."""
    scenarios = tuple(dict.fromkeys(each.scenario for each in results))
    means = {method: mean_figures(results, method, None) for method in methods}
    figures = (
        (method, *map(_percent, shares), f"{ms:.1f}") for method, (*shares, ms) in means.items()
    )
    successes = (
        (method, *(_percent(mean_figures(results, method, name)[0]) for name in scenarios))
        for method in methods
    )
    headings = (name.replace("_", " ") for name in FIGURES)
    overall = ResultTable(("method", *headings), tuple(figures))
    by_scenario = ResultTable(("method", *scenarios), tuple(successes))
    text = (
        f"# How well targets are followed\n\n{note}\n\n{table_markdown(overall)}\n\n"
        f"Success by scenario [%]:\n\n{table_markdown(by_scenario)}\n"
    )
    refusals = _refusal_notes(results)
    return "\n".join([text, *refusals, ""]) if refusals else text


def _refusal_notes(results: Sequence[RunFigures]) -> list[str]:
    """Return a line for each method and scenario in which frames were refused."""
    refused: dict[tuple[str, str], list[str]] = {}
    for each in results:
        if each.refusal:
            refused.setdefault((each.method, each.scenario), []).append(each.refusal)
    return [
        f"* `{method}` refused frames in {len(reasons)} runs of {scenario}, first {reasons[0]}."
        for (method, scenario), reasons in refused.items()
    ]


def _percent(value: float) -> str:
    return "" if np.isnan(value) else f"{100.0 * value:.0f}"
