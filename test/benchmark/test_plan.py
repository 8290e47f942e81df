import pytest

from cable_tracker.benchmark import plan
from cable_tracker.benchmark.cases import REFERENCE_PARTICLES
from cable_tracker.benchmark.footage import RENDERED_SIZE
from cable_tracker.benchmark.plan import FULL, QUICK, versions


@pytest.mark.parametrize("each", [FULL, QUICK])
def test_goals_need_the_reference_size_and_count_in_every_plan(each):
    assert each.sizes[0] == RENDERED_SIZE
    assert REFERENCE_PARTICLES in each.particles


def test_versions_name_what_is_absent(monkeypatch):
    monkeypatch.setattr(plan, "VERSIONS", ("numba", "no-such-package-anywhere"))
    assert versions().endswith(", no-such-package-anywhere absent")
