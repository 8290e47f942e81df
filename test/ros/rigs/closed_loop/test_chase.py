"""A chase with real processes, over a few frames."""

from itertools import count

import pytest

from cable_tracker.evaluation.targets.chase_table import TABLE, ChaseSummary
from cable_tracker.ros.rigs.closed_loop.chase import ChaseRequest, file_names, run_chase
from cable_tracker.simulation.targets.chase import ChaseSettings


@pytest.mark.slow
def test_in_lockstep_the_same_seed_gives_the_same_table(tmp_path):
    request = ChaseRequest(
        ChaseSettings(seed=2, duration=1.5, rate=8.0, image_width=160, image_height=120),
        preset="default",
        distance=2.5,
    )
    shown = count()

    def run(name: str) -> ChaseSummary:
        return run_chase(request, tmp_path / name, overwrite=False, advance=lambda: next(shown))

    first, second = run("first"), run("second")
    assert repr(first) == repr(second)  # What never happened is NaN.
    tables = [(tmp_path / name / TABLE).read_bytes() for name in ("first", "second")]
    assert tables[0] == tables[1]
    assert tables[0].count(b"\n") - 1 == next(shown) / 2 >= 10
    assert {path.name for path in (tmp_path / "first").iterdir()} == set(file_names())
