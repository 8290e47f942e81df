import pytest

from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME, TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.experiments.ablation_rows import (
    ABLATION_TABLES,
    BUILT_UP,
    ROW_NAMES,
    TAKEN_AWAY,
    check_row_names,
)

ALL_ROWS = [row for table in ABLATION_TABLES for row in table.rows]


def test_every_row_is_a_valid_tracker():
    for row in ALL_ROWS:
        assert isinstance(row.parameters(), TrackerParameters), row.name
        assert set(row.changes) <= set(PARAMETERS_BY_NAME), row.name
        assert row.description, row.name


@pytest.mark.parametrize("table", ABLATION_TABLES, ids=lambda table: table.file_name)
def test_names_are_unique_and_every_row_is_compared_with_one_above_it(table):
    names = [row.name for row in table.rows]
    assert len(set(names)) == len(names)
    for place, row in enumerate(table.rows):
        assert (row.compared_to in names[:place]) == (place > 0)


def test_the_only_row_of_both_tables_is_the_preset_default():
    shared = {row.name for row in TAKEN_AWAY.rows} & {row.name for row in BUILT_UP.rows}
    assert shared == {"default"}
    assert len(ROW_NAMES) == len(ALL_ROWS) - 1


def test_what_is_taken_away_is_taken_from_the_preset_default():
    assert TAKEN_AWAY.rows[0].parameters() == preset("default")
    assert {row.base for row in TAKEN_AWAY.rows} == {"default"}


def test_what_is_built_up_leads_from_one_preset_to_the_other():
    assert BUILT_UP.rows[0].parameters() == preset("thesis")
    assert BUILT_UP.rows[-1].parameters() == preset("default")


def test_the_thesis_filter_is_kept_until_the_row_that_replaces_it():
    names = [row.name for row in BUILT_UP.rows]
    filters = [row.parameters().filter for row in BUILT_UP.rows]
    replaced = names.index("multi_hypothesis")
    assert set(filters[:replaced]) == {"bootstrap"}
    assert set(filters[replaced:]) == {"multi_hypothesis"}


def test_an_unknown_row_is_named_with_what_there_is():
    with pytest.raises(ParameterError, match=r"row: 'magic' is none of default \| no_detector"):
        check_row_names(("thesis", "magic"))
