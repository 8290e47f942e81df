"""Freeze the estimates of `default` and `thesis`, and compare those of the present code with them.

    python docs/golden.py freeze FILE.npz     # before a change
    python docs/golden.py compare FILE.npz    # after it

The frames are in the file, too. Estimates are the same bit for bit only on one kind of machine, so
the file is made and read on the same one, and never committed.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.evaluation.evaluation_sequences import ScenarioSequence
from cable_tracker.trackers import make_tracker
from cable_tracker.tracking.status import TrackingStatus

DIVES = ("S1", "S2", "S3", "S4", "S5", "S6")
FRAMES, SEED, STEP = 150, 1, 40_000_000
INITIALISED_AT = 75
"""Frame at which the tracker is initialised with the true state of the cable."""

STATUSES = list(TrackingStatus)


def main() -> None:
    """Freeze or compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("action", choices=("freeze", "compare"))
    parser.add_argument("file", type=Path)
    arguments = parser.parse_args()
    if arguments.action == "freeze":
        freeze(arguments.file)
    elif not compare(arguments.file):
        raise SystemExit(1)


def freeze(path: Path) -> None:
    """Render the dives, track them, and write frames and estimates."""
    content: dict[str, np.ndarray] = {}
    for dive in DIVES:
        frames = list(ScenarioSequence(dive, FRAMES).frames(SEED))
        content[f"{dive} frames"] = np.stack([frame.image for frame in frames])
        truth = frames[INITIALISED_AT].truth
        content[f"{dive} told"] = truth.to_array() if truth else np.full(8, np.nan)
        for name in PRESETS:
            content[f"{dive} {name}"] = track(
                content[f"{dive} frames"], content[f"{dive} told"], name
            )
    # Into an open file: by a path NumPy would add .npz, which `compare` is not told of.
    with path.open("wb") as file:
        np.savez_compressed(file, **content)


def compare(path: Path) -> bool:
    """Print for every dive and preset from which frame on estimates differ; True if none does."""
    content = np.load(path)
    same = True
    for name in PRESETS:
        for dive in DIVES:
            found = track(content[f"{dive} frames"], content[f"{dive} told"], name)
            differing = ~np.isclose(found, content[f"{dive} {name}"], 0.0, 0.0, equal_nan=True)
            frames = np.flatnonzero(differing.any(axis=1))
            same &= not len(frames)
            first = f"differs from frame {frames[0]} on" if len(frames) else "same bit for bit"
            print(f"{name:8} {dive}: {first}")
    return same


def track(frames: Image, truth: FloatArray, name: str) -> FloatArray:
    """Return the numbers of a preset's estimates, a row for each frame.

    At `INITIALISED_AT` it is given the true state (8,) of that frame, unless this is NaN.
    """
    tracker = make_tracker(preset(name))
    rows = []
    for number, frame in enumerate(frames):
        if number == INITIALISED_AT and np.isfinite(truth).all():
            tracker.initialise(GivenState.around(CableState.from_array(truth)))
        rows.append(numbers_of(tracker.process(frame, stamp=(number + 1) * STEP)))
    return np.array(rows)


def numbers_of(estimate: CableEstimate) -> FloatArray:
    """Return all numbers of an estimate in a row, shape (K,)."""
    presence = math.nan if estimate.presence is None else estimate.presence
    return np.concatenate(
        (
            estimate.state.to_array(),
            estimate.covariance.ravel(),
            [estimate.effective_sample_size, estimate.evidence, presence],
            [STATUSES.index(estimate.status), len(estimate.hypotheses)],
        )
    )


if __name__ == "__main__":
    main()
