"""Our filters and their peers on the same frames of simulated targets."""

from __future__ import annotations

import csv
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.evaluation.targets.metrics import (
    JudgedClaim,
    claimed_in_view,
    claimed_while_absent,
    keeps_its_own,
    returns_found,
    success,
)
from cable_tracker.evaluation.targets.peers import PEERS, BoxTracker
from cable_tracker.simulation.targets.sequence import TargetFrame, simulate_target
from cable_tracker.target.model.estimate import Box, TargetEstimate
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.parameters.presets import TARGET_PRESETS
from cable_tracker.target.tracker import TargetTracker
from cable_tracker.tracking.status import TrackingStatus

GREY = "grey"
"""Word before the name of a method: it gets grey pictures."""

FIGURES = (
    "success", "claimed_in_view", "claimed_while_absent", "returns_found", "own_after_crossing",
    "ms",
)  # fmt: skip


class OwnTracker:
    """Our tracker as one that follows a box.

    Parameters
    ----------
    parameters : TargetParameters
        Of the tracker.
    """

    def __init__(self, parameters: TargetParameters) -> None:
        self._tracker = TargetTracker(parameters)

    def start(self, image: Image, box: Box, stamp: int) -> Box | None:
        """Take what is in the box for the target."""
        self._tracker.initialise(TargetStart.from_box(*box))
        return _claim(self._tracker.process(image, stamp))

    def update(self, image: Image, stamp: int) -> Box | None:
        """Return the box in the next frame; None unless the status is TRACKING."""
        return _claim(self._tracker.process(image, stamp))


def _claim(estimate: TargetEstimate) -> Box | None:
    return estimate.box if estimate.status is TrackingStatus.TRACKING else None


def method_names() -> list[str]:
    """Return the names of all methods: presets, peers, and each on grey pictures."""
    plain = [*TARGET_PRESETS, *PEERS]
    return plain + [f"{GREY} {name}" for name in plain]


def make_method(name: str, seed: int) -> BoxTracker:
    """Return a tracker by its name, without the word for grey pictures."""
    if name in TARGET_PRESETS:
        return OwnTracker(TARGET_PRESETS[name].replaced({"seed": seed}))
    return PEERS[name]()


@dataclass(frozen=True, slots=True)
class RunFigures:
    """Figures of one method on one run of a scenario; NaN where they say nothing.

    Attributes
    ----------
    scenario : str
        Name.
    seed : int
        Of the run.
    method : str
        Name.
    values : tuple of float
        In the order of `FIGURES`.
    """

    scenario: str
    seed: int
    method: str
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ScenarioTask:
    """One run of a scenario, followed by several methods.

    Attributes
    ----------
    scenario : str
        Name.
    seed : int
        Of the simulation and of our filters.
    methods : tuple of str
        Names, see `method_names`.
    frame_count : int
        Length of the run.
    """

    scenario: str
    seed: int
    methods: tuple[str, ...]
    frame_count: int = 150

    def run(self, advance: Callable[[], None]) -> list[RunFigures]:
        """Follow the target with every method."""
        frames = list(simulate_target(self.scenario, self.seed, self.frame_count))
        results = []
        for method in self.methods:
            claims = follow(frames, method, self.seed)
            if claims:
                results.append(
                    RunFigures(self.scenario, self.seed, method, _figures(self.scenario, claims))
                )
        for _ in frames:
            advance()
        return results


def follow(frames: Sequence[TargetFrame], method: str, seed: int) -> list[JudgedClaim]:
    """Follow the target from the first frame that shows it; nothing where none does."""
    grey = method.startswith(f"{GREY} ")
    tracker = make_method(method.removeprefix(f"{GREY} "), seed)
    claims: list[JudgedClaim] = []
    for frame in frames:
        image = cv2.cvtColor(frame.image, cv2.COLOR_BGR2GRAY) if grey else frame.image
        begin = time.process_time()
        if claims:
            claim = tracker.update(image, frame.stamp)
        elif frame.box is not None:
            claim = tracker.start(image, frame.box, frame.stamp)
        else:
            continue
        ms = (time.process_time() - begin) * 1e3
        claims.append(JudgedClaim(frame.box, claim, frame.twin_box, ms))
    return claims


def _figures(scenario: str, claims: Sequence[JudgedClaim]) -> tuple[float, ...]:
    # What is hidden behind its twin has its box where the twin is: that claim is no error.
    absent = float("nan") if scenario == "crossing" else claimed_while_absent(claims)
    found = returns_found(claims)
    return (
        success(claims),
        claimed_in_view(claims),
        absent,
        float(np.mean(found)) if found else float("nan"),
        keeps_its_own(claims) if scenario == "crossing" else float("nan"),
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
    means = []
    for column in columns:
        known = column[~np.isnan(column)]
        means.append(float(known.mean()) if len(known) else float("nan"))
    return means


def write_figures(path: Path, results: Sequence[RunFigures]) -> None:
    """Write one row for every run and method."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("scenario", "seed", "method", *FIGURES))
        for each in results:
            numbers = ["" if np.isnan(value) else f"{value:.4f}" for value in each.values]
            writer.writerow((each.scenario, each.seed, each.method, *numbers))


def markdown_table(results: Sequence[RunFigures], methods: Sequence[str], note: str) -> str:
    """Return the means over all runs, and the success by scenario, as Markdown."""
    lines = ["# How well targets are followed", "", note, ""]
    lines += [f"| method | {' | '.join(name.replace('_', ' ') for name in FIGURES)} |"]
    lines += ["|---" * (len(FIGURES) + 1) + "|"]
    for method in methods:
        means = mean_figures(results, method, None)
        cells = [_percent(value) for value in means[:-1]] + [f"{means[-1]:.1f}"]
        lines.append(f"| {method} | {' | '.join(cells)} |")
    scenarios = list(dict.fromkeys(each.scenario for each in results))
    lines += ["", "Success by scenario [%]:", "", f"| method | {' | '.join(scenarios)} |"]
    lines += ["|---" * (len(scenarios) + 1) + "|"]
    for method in methods:
        shares = [_percent(mean_figures(results, method, name)[0]) for name in scenarios]
        lines.append(f"| {method} | {' | '.join(shares)} |")
    return "\n".join(lines) + "\n"


def _percent(value: float) -> str:
    return "" if np.isnan(value) else f"{100.0 * value:.0f}"
