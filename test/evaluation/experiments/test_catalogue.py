import re
from pathlib import Path

import pytest

from cable_tracker.evaluation.experiments import catalogue
from cable_tracker.evaluation.experiments.catalogue import EXPERIMENTS, FILES


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_experiment_knows_how_long_it_takes(name):
    one, two = (EXPERIMENTS[name](seeds, None).frame_count() for seeds in ((0,), (0, 1)))
    assert two == 2 * one


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_dives_are_cut_where_that_is_wanted(name):
    short, shorter = (EXPERIMENTS[name]((0,), limit).frame_count() for limit in (4, 2))
    assert short == 2 * shorter


def test_the_names_of_all_files_that_experiments_write_are_known():
    modules = Path(catalogue.__file__).parent.glob("*.py")
    text = "".join(module.read_text(encoding="utf-8") for module in modules)
    names = set(re.findall(r'"(\w+\.(?:csv|png))"', text))
    assert {"table.csv", "speed.png", "taken_away.csv"} <= names <= FILES
