from __future__ import annotations

import pytest

from cable_tracker.benchmark.start_time import measure_start


@pytest.mark.slow
def test_the_second_start_finds_what_the_first_has_compiled():
    start = measure_start("thesis")
    assert 0.0 < start.warm < start.cold
