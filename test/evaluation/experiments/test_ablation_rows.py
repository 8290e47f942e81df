import pytest

from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME, TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.experiments.ablation_rows import (
    ABLATION_ROWS,
    ROW_NAMES,
    check_row_names,
)


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
