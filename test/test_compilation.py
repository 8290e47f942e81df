from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.compilation import (
    compiled,
    compiled_fast,
    compiled_fast_part,
    compiled_inside,
    compiled_part,
)
from cable_tracker.trackers import warm_up

ROOT = Path(__file__).resolve().parents[1]
WITHOUT_COMPILING = (
    "test/cable/hypotheses/test_clusters.py",
    "test/cable/hypotheses/test_ancestors.py",
    "test/cable/thesis/test_bootstrap_filter.py",
    "test/cable/measure/test_scanned_gradients.py::test_lines_know_where_they_are",
    "test/particle_filter/test_weights.py",
)
"""Kernels as plain Python take long, so few of them."""


def sum_of_squares(values):
    total = 0.0
    for value in values:
        total += value * value
    return total


@pytest.mark.parametrize("compiler", [compiled, compiled_fast])
def test_a_compiled_function_returns_what_the_plain_one_returns(compiler):
    values = np.arange(100.0)
    assert compiler(sum_of_squares)(values) == sum_of_squares(values)


@pytest.mark.parametrize("part", [compiled_part, compiled_fast_part, compiled_inside])
def test_a_part_is_plain_for_python_and_compiled_within_an_entry(part):
    def half(value):
        return 0.5 * value

    assert part(half) is half

    @compiled
    def quarter(value):
        return half(half(value))

    assert quarter(8.0) == 2.0


def test_what_cannot_be_kept_on_disk_is_compiled_all_the_same():
    namespace = {}
    exec("def twice(value):\n    return 2 * value", namespace)  # Of no file: there is no cache.
    assert compiled(namespace["twice"])(4) == 8


@pytest.mark.parametrize("name", PRESETS)
def test_warming_up_ends_by_itself(name):
    warm_up(preset(name).replaced({"particle_count": 50}))


def test_kernels_run_as_plain_python_for_a_debugger():
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider",
         *WITHOUT_COMPILING],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:]
