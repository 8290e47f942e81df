"""How well the cable is known in metres: the tracker's output against the simulated vehicle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.geometry import wrap_angle
from cable_tracker.cable.presets import preset
from cable_tracker.evaluation.experiment_result import ExperimentResult, ResultTable
from cable_tracker.evaluation.flights import LOOK_AHEAD, InstrumentNoise, simulated_vehicle
from cable_tracker.evaluation.frames import ScenarioSequence, scenario_sequences
from cable_tracker.evaluation.methods import ParticleFilterMethod
from cable_tracker.evaluation.report import format_number
from cable_tracker.metric.cross_track import CrossTrack

METRES_SEQUENCES = ("S1", "S2", "S3", "S4", "S5", "S6")
HEADINGS = (
    "sequence", "frames with a visible cable", "with metres [%]", "RMSE at x = 0 [% of altitude]",
    f"RMSE at x = {LOOK_AHEAD:g} m [% of altitude]", "RMSE of heading [deg]",
    "median of heading [deg]", "offset inside 2 sigma [%]", "heading inside 2 sigma [%]",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class MetresExperiment:
    """Follow the scenarios with the preset `default`, calibrated, with altimeter and imu.

    Attributes
    ----------
    seeds : tuple of int
        Each makes another dive of the same kind.
    sequences : tuple of ScenarioSequence
        What to follow.
    noise : InstrumentNoise
        How wrong altimeter and imu are.
    """

    seeds: tuple[int, ...]
    sequences: tuple[ScenarioSequence, ...] = scenario_sequences(METRES_SEQUENCES)
    noise: InstrumentNoise = InstrumentNoise()  # noqa: RUF009

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through."""
        return sum(sequence.frame_count() or 0 for sequence in self.sequences) * len(self.seeds)

    def run(self, workers: int, advance: Callable[[int], None]) -> ExperimentResult:
        """Run it, in one process whatever `workers` says."""
        del workers
        rows = []
        for sequence in self.sequences:
            parts = [self._errors(sequence, seed, advance) for seed in self.seeds]
            rows.append(_row(sequence.name, np.concatenate(parts)))
        title = "The cable in metres: errors against the simulated vehicle"
        return ExperimentResult(title, (ResultTable(HEADINGS, tuple(rows)),))

    def _errors(
        self, sequence: ScenarioSequence, seed: int, advance: Callable[[int], None]
    ) -> FloatArray:
        """Return one row for each frame that shows a cable, NaN where there are no metres.

        Errors of offset and offset ahead [share of the altitude] and heading [rad], then those of
        offset and heading in standard deviations, shape (N, 5).
        """
        vehicle = simulated_vehicle(sequence.name, seed, self.noise)
        method = ParticleFilterMethod(preset("default").replaced({"seed": seed}))
        rows = []
        for frame in sequence.frames(seed):
            if frame.index == 0 and frame.truth is not None:
                method.initialise(frame.truth)
            estimate = method.process(frame.image, frame.stamp)
            result = vehicle.instruments.cross_track(estimate)
            advance(1)
            if frame.visibility == 0.0:
                continue
            row = np.full(5, np.nan)
            if isinstance(result, CrossTrack):
                found = np.array([result.offset, result.offset_ahead, result.heading])
                error = found - vehicle.truths[frame.index]
                error[2] = wrap_angle(error[2])
                sigmas = result.standard_deviations()[[0, 2]]
                row[:3] = error / [*[vehicle.altitudes[frame.index]] * 2, 1.0]
                row[3:] = error[[0, 2]] / sigmas
            rows.append(row)
        return np.array(rows).reshape(-1, 5)


def _row(name: str, errors: FloatArray) -> tuple[str, ...]:
    known = errors[np.isfinite(errors).all(axis=1)]
    if not len(known):
        return (name, str(len(errors)), "0", *["–"] * 6)
    rmse = np.sqrt((known[:, :3] ** 2).mean(axis=0))
    inside = 100.0 * (np.abs(known[:, 3:]) <= 2.0).mean(axis=0)
    median = math.degrees(float(np.median(np.abs(known[:, 2]))))
    return (
        name,
        str(len(errors)),
        format_number(100.0 * len(known) / len(errors), "%"),
        *(f"{100.0 * value:.2f}" for value in rmse[:2]),
        f"{math.degrees(rmse[2]):.2f}",
        f"{median:.2f}",
        *(format_number(float(share), "%") for share in inside),
    )
