import pytest

from cable_tracker.errors import ParameterError
from cable_tracker.followed_kinds import CABLE, TARGET

KINDS = pytest.mark.parametrize("kind", [CABLE, TARGET])


@KINDS
def test_names_that_only_the_node_knows_are_passed_over(kind):
    values = {"seed": 5, "image_transport": "raw"}
    parameters = kind.with_values("thesis", values)
    assert parameters == kind.presets["thesis"].replaced({"seed": 5})
    with pytest.raises(ParameterError, match="image_transport"):
        kind.presets["thesis"].replaced(values)


@KINDS
def test_other_names_and_presets_are_refused(kind):
    with pytest.raises(ParameterError, match="unknown parameter sped"):
        kind.with_values("default", {"sped": 1.0})
    with pytest.raises(ParameterError, match="'dusk' is none of"):
        kind.with_values("dusk", {})


@KINDS
def test_no_name_is_both_the_filters_and_the_nodes(kind):
    names = [spec.name for spec in (*kind.table, *kind.of_node)]
    assert len(names) == len(set(names))
    assert set(kind.runtime) <= set(kind.of_node)
