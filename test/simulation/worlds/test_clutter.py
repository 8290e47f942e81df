"""Things on the bottom of worlds."""

import numpy as np
import pytest

from cable_tracker.simulation.worlds.catalogue import Split
from cable_tracker.simulation.worlds.clutter import (
    LINES,
    PAIRS,
    PROFILES,
    ClutterObject,
    add_clutter,
    random_clutter,
)


def test_the_splits_share_no_kind_of_clutter():
    tune, report = (set(LINES[split]) | set(PAIRS[split]) for split in Split)
    assert not tune & report
    assert tune | report == set(PROFILES)


def test_a_view_has_as_many_things_as_asked_for():
    rng = np.random.default_rng(0)
    objects = random_clutter(Split.TUNE, (0.0, 26000.0), 2.0, 1.0, rng)
    pairs = [each for each in objects if each.kind == "pair"]
    assert len(pairs) == pytest.approx(100, abs=35)
    assert len(objects) - len(pairs) == pytest.approx(200, abs=50)


def test_a_rope_lies_where_it_should():
    y, x = np.mgrid[-50:50, -50:50].astype(np.float32)
    rope = ClutterObject("rope", 10.0, 0.0, 0.0, 4.0, 40.0, 2.0)
    laid = add_clutter(np.zeros_like(x), (rope,), x, y)
    assert laid[50, 60] > 1.0
    assert laid[50, 45] == 0.0
    assert laid[50, 75] == 0.0


def test_a_trench_is_darker_than_the_ground():
    rng = np.random.default_rng(1)
    trenches = random_clutter(Split.REPORT, (0.0, 9000.0), 0.0, 1.0, rng)
    assert trenches
    assert all(trench.strength > 0.0 for trench in trenches)
    middle = PROFILES["trench"](np.zeros(1, np.float32), np.zeros(1, np.float32), 10.0)
    assert middle[0] < -0.4
