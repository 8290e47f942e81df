import dataclasses
import math

import pytest

from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME, TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.campaigns.settings import HERE
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.evaluation_sequences import simulated_sequences
from cable_tracker.evaluation.experiments.ablation import (
    ABLATION_ROWS,
    ROW_NAMES,
    AblationExperiment,
    check_row_names,
    cold_ablation,
    mean_and_error,
)
from cable_tracker.evaluation.runs import Start
from cable_tracker.simulation.worlds.catalogue import Split, worlds_of


def test_every_row_is_a_valid_tracker():
    for row in ABLATION_ROWS:
        assert isinstance(row.parameters(), TrackerParameters), row.name
        assert set(row.changes) <= set(PARAMETERS_BY_NAME), row.name
        assert row.description, row.name


def test_names_are_unique():
    assert len(set(ROW_NAMES)) == len(ABLATION_ROWS)


def test_what_is_taken_away_is_taken_from_the_preset_default():
    first, *others = ABLATION_ROWS
    assert (first.name, first.parameters()) == ("default", preset("default"))
    for row in others:
        assert row.parameters() != preset("default"), row.name


def test_an_unknown_row_is_named_with_what_there_is():
    with pytest.raises(ParameterError, match=r"row: 'magic' is none of default \| no_detector"):
        check_row_names(("default", "magic"))


@pytest.fixture(scope="module")
def short_stripe(stripe):
    return dataclasses.replace(stripe, length=4)


@pytest.mark.slow
def test_every_row_has_a_cell_for_every_heading(short_stripe):
    experiment = AblationExperiment((7,), ("any_width", "default"), (short_stripe,))
    told = []
    (table,) = experiment.run(HERE, told.append).tables
    assert [row[0] for row in table.rows] == ["default", "any_width"]
    assert all(len(row) == len(table.headings) for row in table.rows)
    assert sum(told) == experiment.frame_count() == 4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "compared"),
    [(("default", "particles_200"), ["–", "default"]), (("particles_200",), ["–"])],
)
def test_a_loss_is_compared_only_if_the_preset_default_was_run(short_stripe, names, compared):
    result = AblationExperiment((0, 1), names, (short_stripe,)).run(HERE, lambda count: None)
    (table,) = result.tables
    place = table.headings.index("lost more than")
    assert [row[place] for row in table.rows] == compared


@pytest.mark.slow
def test_a_note_names_the_values_that_were_changed(short_stripe):
    result = AblationExperiment((0,), ("particles_200",), (short_stripe,)).run(HERE, lambda n: None)
    assert "`particles_200`: 200 particles (`particle_count` = 200)" in result.tables[0].notes


@pytest.mark.slow
@pytest.mark.parametrize(("rows", "words"), [(("magic",), "'magic' is none of"), ((), "at least")])
def test_rows_are_checked(rows, words):
    with pytest.raises(ParameterError, match=words):
        AblationExperiment((0,), rows)


@pytest.mark.slow
def test_the_error_of_a_mean_over_sequences_is_that_of_the_runs_within_them():
    # Means 2 and 20; standard errors 1 and 0: the sequences differ, but were chosen.
    losses = {("S1", 0): 1.0, ("S1", 1): 3.0, ("S2", 0): 20.0, ("S2", 1): 20.0}
    assert mean_and_error(losses, ("S1", "S2")) == pytest.approx((11.0, 0.5))


@pytest.mark.slow
def test_the_error_of_single_runs_is_unknown():
    mean, error = mean_and_error({("S1", 0): 1.0, ("S2", 0): 3.0}, ("S1", "S2"))
    assert mean == pytest.approx(2.0)
    assert math.isnan(error)


@pytest.mark.slow
def test_the_cold_ablation_starts_from_nothing_on_worlds_to_report_on_alone():
    campaign = cold_ablation((3,), limit=5).campaign()
    reported = {world.name for world in worlds_of(Split.REPORT)}
    assert campaign.start is Start.RANDOM
    assert {sequence.name for sequence in campaign.sequences} <= reported
    assert {sequence.frame_count() for sequence in campaign.sequences} == {5}
    assert [each.name for each in campaign.filters] == list(ROW_NAMES)


@pytest.mark.slow
def test_the_cold_ablation_tells_of_claims_without_a_cable(monkeypatch):
    monkeypatch.setattr(
        "cable_tracker.evaluation.experiments.ablation.reported_worlds",
        lambda limit: (
            simulated_sequences(("S3", "no_cable"), limit),
            ("`x` is left out: it cannot be drawn",),
        ),
    )
    cold = dataclasses.replace(cold_ablation((1,), 3), rows=("default",))
    (table,) = cold.run(HERE, lambda count: None).tables
    assert "false tracking [%]" in table.headings
    assert table.headings[-2:] == ("S3: frames lost [%]", "no_cable: frames lost [%]")
    assert table.rows[0][-1] == "–"
    assert table.notes[-1] == "`x` is left out: it cannot be drawn"
