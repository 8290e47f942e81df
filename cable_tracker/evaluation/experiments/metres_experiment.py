"""How well the cable is known in metres: the tracker's output against the simulated vehicle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import wrap_angles
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.campaigns.runner import run_all
from cable_tracker.campaigns.settings import CampaignSettings
from cable_tracker.evaluation.errors import forgiven_distance, is_off_cable, state_errors
from cable_tracker.evaluation.evaluation_sequences import (
    EvaluationSequence,
    frames_in_all,
)
from cable_tracker.evaluation.experiments.aided import (
    LOOK_AHEAD,
    AidedFilter,
    OdometryFault,
    SimulatedVehicle,
    simulated_vehicle,
)
from cable_tracker.evaluation.experiments.experiment import ExperimentResult
from cable_tracker.evaluation.result_table import ResultTable, median_and_range
from cable_tracker.evaluation.sample_statistics import (
    mean,
    percentage,
    percentile_of_size,
    root_mean_square,
    spread_of,
)
from cable_tracker.metric.cross_track import CrossTrack

HEADINGS = (
    "sequence", "runs", "with metres [%]",
    "RMSE at x = 0 [% of altitude]", "RMSE of heading [deg]",
    "on the cable [%]",
    "RMSE at x = 0, on the cable [% of altitude]", "RMSE of heading, on the cable [deg]",
    f"RMSE at x = {LOOK_AHEAD:g} m, on the cable [% of altitude]",
    "95th percentile at x = 0 [% of altitude]", "95th percentile of heading [deg]",
    "offset inside 2 sigma [%]", "heading inside 2 sigma [%]",
)  # fmt: skip
BRIEF_COLUMNS = 8
TABLES = {
    None: ("Without odometry", "without_odometry.csv"),
    OdometryFault.NONE: ("With odometry", "with_odometry.csv"),
}
"""Title and file of each table, by the odometry: none, or sound."""

NOTE = (
    "Medians over the runs (least – most). *On the cable*: without the frames in which what is"
    " claimed is off by more than max(10 px, w/2) or 8 deg, that is not the cable."
)
OFFSET, AHEAD, HEADING, OFFSET_IN_SIGMAS, HEADING_IN_SIGMAS, ON_CABLE = range(6)
"""Columns of the errors."""


@dataclass(frozen=True, slots=True)
class _Dive:
    """One scenario with one seed."""

    sequence: EvaluationSequence
    seed: int
    odometry: OdometryFault | None

    def run(self, advance: Callable[[int], None]) -> FloatArray:
        """Return one row for each frame that shows a cable, NaN where there are no metres.

        Errors of offset and offset ahead [share of the altitude] and heading [rad], those of offset
        and heading in standard deviations, and whether the estimate is on the cable, shape (N, 6).
        """
        name = self.sequence.name
        vehicle = simulated_vehicle(name, self.seed)
        method = AidedFilter("default", preset("default"), name, self.odometry).make(self.seed)
        rows = []
        for frame in self.sequence.frames(self.seed):
            if frame.index == 0 and frame.truth is not None:
                method.initialise(GivenState.around(frame.truth))
            estimate = method.process(frame.image, frame.stamp)
            result = method.measure(estimate)
            advance(1)
            if frame.visibility == 0.0 or frame.truth is None:
                continue
            row = np.full(ON_CABLE + 1, np.nan)
            if isinstance(result, CrossTrack):
                row[: HEADING + 1] = self._errors(result, vehicle, frame.index)
                sigmas = result.standard_deviations()
                row[OFFSET_IN_SIGMAS] = row[OFFSET] * vehicle.altitudes[frame.index] / sigmas[0]
                row[HEADING_IN_SIGMAS] = row[HEADING] / sigmas[2]
                errors = state_errors(estimate.state, frame.truth)[None, :]
                widths = np.array([frame.truth.width])
                forgiven = forgiven_distance(estimate.image_size[0])
                row[ON_CABLE] = not is_off_cable(errors, widths, forgiven=forgiven)[0]
            rows.append(row)
        return np.array(rows).reshape(-1, ON_CABLE + 1)

    @staticmethod
    def _errors(result: CrossTrack, vehicle: SimulatedVehicle, index: int) -> FloatArray:
        found = np.array([result.offset, result.offset_ahead, result.heading])
        error = found - vehicle.truths[index]
        error[HEADING] = wrap_angles(error[HEADING])
        altitude = vehicle.altitudes[index]
        return np.asarray(error / [altitude, altitude, 1.0])


@dataclass(frozen=True, slots=True)
class MetresExperiment:
    """Follow the scenarios with the preset `default`, calibrated, with altimeter and imu.

    Without odometry, and with it.

    Attributes
    ----------
    seeds : tuple of int
        Each makes another dive of the same kind.
    sequences : tuple of EvaluationSequence
        Sequences to run on.
    """

    seeds: tuple[int, ...]
    sequences: tuple[EvaluationSequence, ...]

    def frame_count(self) -> int | None:
        """Return how many frames there are to go through."""
        counts = (sequence.frame_count() for sequence in self.sequences)
        return frames_in_all(counts, len(self.seeds) * len(TABLES))

    def run(self, settings: CampaignSettings, advance: Callable[[int], None]) -> ExperimentResult:
        """Run it; the results do not depend on the number of workers."""
        dives = [
            _Dive(sequence, seed, odometry)
            for sequence in self.sequences
            for seed in self.seeds
            for odometry in TABLES
        ]
        errors = run_all(dives, settings, advance=advance)
        results = list(zip(dives, errors, strict=True))
        title = "The cable in metres: errors against the simulated vehicle"
        return ExperimentResult(title, tuple(self._table(each, results) for each in TABLES))

    def _table(
        self, odometry: OdometryFault | None, results: Sequence[tuple[_Dive, FloatArray]]
    ) -> ResultTable:
        chosen = [each for each in results if each[0].odometry is odometry]
        rows = tuple(
            _row(sequence.name, [errors for dive, errors in chosen if dive.sequence == sequence])
            for sequence in self.sequences
        )
        title, file_name = TABLES[odometry]
        return ResultTable(HEADINGS, rows, title, file_name, (NOTE,), BRIEF_COLUMNS)


def _row(name: str, runs: Sequence[FloatArray]) -> tuple[str, ...]:
    numbers = np.array([_numbers(errors) for errors in runs])
    return (
        name,
        str(len(runs)),
        *(median_and_range(spread_of(column), "") for column in numbers.T),
    )


def _numbers(errors: FloatArray) -> tuple[float, ...]:
    """Return the columns from `with metres` on, for the errors (N, 6) of one run."""
    known = errors[np.isfinite(errors).all(axis=1)]
    held = known[known[:, ON_CABLE] > 0.0]
    inside = np.abs(known) <= 2.0
    return (
        percentage(len(known), len(errors)),
        100.0 * root_mean_square(known[:, OFFSET]),
        math.degrees(root_mean_square(known[:, HEADING])),
        100.0 * mean(known[:, ON_CABLE]),
        100.0 * root_mean_square(held[:, OFFSET]),
        math.degrees(root_mean_square(held[:, HEADING])),
        100.0 * root_mean_square(held[:, AHEAD]),
        100.0 * percentile_of_size(known[:, OFFSET], 95.0),
        math.degrees(percentile_of_size(known[:, HEADING], 95.0)),
        100.0 * mean(inside[:, OFFSET_IN_SIGMAS]),
        100.0 * mean(inside[:, HEADING_IN_SIGMAS]),
    )
