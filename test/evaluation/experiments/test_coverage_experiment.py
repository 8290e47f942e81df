"""Truths inside the stated covariance, counted over rightly claimed frames."""

from dataclasses import replace

import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.campaigns.settings import HERE
from cable_tracker.evaluation.experiments.coverage_experiment import (
    CoverageExperiment,
    SequenceGroup,
    coverage_cells,
    reported_coverage,
)
from cable_tracker.evaluation.trace import trace_of
from cable_tracker.simulation.worlds.ground import FOLDER_VARIABLE

SIGMA = (2.0, 0.02, 3.0, 0.01)


@pytest.fixture
def claims(outcome):
    """Make a run from errors of d, alpha, w and beta in sigma, one row for each frame."""

    def make(*rows):
        truth = CableState(0.0, 0.0, 60.0)
        errors = [tuple(x * s for x, s in zip(row, SIGMA, strict=True)) for row in rows]
        return trace_of([outcome(i, truth, each, sigma=SIGMA) for i, each in enumerate(errors)])

    return make


def test_coverage_by_hand(claims):
    first = claims((0.0, 0.0, 0.0, -3.0), (1.0, 0.1, -1.0, 2.0))
    second = claims((2.0, 0.0, -1.9, 1.9), (3.0, 1.9, 1.0, 1.9))
    # NEES: 9, 6.01, 11.22, 17.22. Inside 1.96 sigma: two of d, all of alpha and w, two of beta;
    # inside the region, that of 9.49, two, both of one dive. d errs by 0, 2, 4, 6 px, w by 0, -3,
    # -5.7, 3 px.
    shares = ("50.0", "100.0", "100.0", "50.0", "50.0")
    cells = ("4", *shares, "10.11", "3.00", "−1.50", "1 of 2")
    assert coverage_cells((first, second)) == cells


def test_coverage_of_no_claim_is_unknown(trace):
    unknown = ("0", *8 * ("–",), "0 of 0")
    claimed = [run.where(run.useful) for run in (trace("ss"), trace("n"))]
    assert coverage_cells(claimed) == unknown
    assert coverage_cells(()) == unknown


def test_a_wrong_claim_does_not_count(stripe):
    class Elsewhere(type(stripe)):
        """The same pictures, with a truth far from the stripe but for the first frames."""

        def frames(self, seed):
            for frame in super().frames(seed):
                far = replace(frame.truth, distance=frame.truth.distance - 100.0)
                yield frame if frame.index < 5 else replace(frame, truth=far)

    group = SequenceGroup("all", (Elsewhere(),))
    result = CoverageExperiment((0,), (group,)).run(HERE, lambda count: None)
    assert result.tables[0].rows[0][1] == "5"


def test_a_group_has_a_row_together_and_one_for_each_sequence(stripe):
    others = tuple(replace(stripe, name=name) for name in ("one", "two"))
    groups = (
        SequenceGroup("both", others, ("a third is left out",)),
        SequenceGroup("S", (stripe,)),
    )
    result = CoverageExperiment((0, 1), groups).run(HERE, lambda count: None)
    shares, factors = result.tables
    names = ["both", "`one`", "`two`", "S", "`stripe`"]
    assert [row[0] for row in shares.rows] == [row[0] for row in factors.rows] == names
    assert [int(row[1]) for row in shares.rows] == [48, 24, 24, 24, 24]
    assert [row[-1] for row in shares.rows] == ["0 of 4", *4 * ("0 of 2",)]
    assert all(len(row) == len(table.headings) for table in result.tables for row in table.rows)
    assert shares.notes[1:] == ("a third is left out",)
    # A crisp stripe is found to a fraction of sigma, and all shares are full.
    assert shares.rows[0][2:7] == 5 * ("100.0",)
    assert all(0.0 < float(cell) < 1.0 for cell in factors.rows[0][1:])


def test_all_that_is_reported_has_a_cable(monkeypatch, tmp_path):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "none"))
    worlds, scenarios = reported_coverage((0,), 7).groups
    names = {each.name for each in worlds.sequences}
    assert "report_sand" in names
    assert not names & {"report_empty", "report_decoys"}
    assert len(worlds.notes) == 2
    assert {each.frame_count() for each in (*worlds.sequences, *scenarios.sequences)} == {7}
    assert [each.name for each in scenarios.sequences] == ["S1", "S2", "S3", "S4", "S5", "S6"]
