from __future__ import annotations

import os
import runpy
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from cable_tracker import compilation
from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.compilation import (
    compiled,
    compiled_fast_loop,
    compiled_fast_part,
    compiled_inside,
    compiled_loop,
    compiled_part,
)
from cable_tracker.trackers import warm_up

ROOT = Path(__file__).resolve().parents[1]
WITHOUT_COMPILING = (
    "test/cable/hypotheses/test_clusters.py",
    "test/cable/hypotheses/test_prediction.py",
    "test/cable/thesis/test_bootstrap_filter.py",
    "test/cable/measure/test_scanned_gradients.py::test_lines_know_where_they_are",
    "test/particle_filter/test_particles.py",
)
"""Kernels as plain Python take long, so few of them."""

LONG = (
    "test/cable/thesis/test_bootstrap_filter.py"
    "::test_a_given_cable_is_followed_as_the_only_hypothesis[likelihood_ratio]"
)
"""The same test with the other observation takes a quarter of the time."""


def sum_of_squares(values):
    total = 0.0
    for value in values:
        total += value * value
    return total


def test_a_compiled_function_returns_what_the_plain_one_returns():
    values = np.arange(100.0)
    assert compiled(sum_of_squares)(values) == sum_of_squares(values)


@pytest.mark.parametrize(
    "part",
    [compiled_part, compiled_fast_part, compiled_loop, compiled_fast_loop, compiled_inside],
)
def test_a_part_is_plain_for_python_and_compiled_within_an_entry(part):
    def half(value):
        return 0.5 * value

    assert part(half) is half

    @compiled
    def quarter(value):
        return half(half(value))

    assert quarter(8.0) == 2.0


def test_a_function_without_a_file_is_compiled():
    namespace = {}
    exec("def twice(value):\n    return 2 * value", namespace)  # Of no file: there is no cache.
    assert compiled(namespace["twice"])(4) == 8


@pytest.fixture
def unkept(tmp_path, monkeypatch):
    """A compiled function whose folder on disk is gone when it is called."""
    monkeypatch.setattr(compilation, "PACKAGE", tmp_path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    source = tmp_path / "kernel.py"
    source.write_text("def twice(value):\n    return 2 * value\n")
    function = compiled(runpy.run_path(str(source))["twice"])
    (folder,) = (tmp_path / "cache" / "cable_tracker").iterdir()
    shutil.rmtree(folder)
    folder.write_text("no folder")
    compilation._warn_of_disk.cache_clear()
    return function


def test_machine_code_that_cannot_be_saved_is_used(unkept):
    with pytest.warns(RuntimeWarning, match="is not kept .*; make room"):
        assert unkept(4) == 8


def test_that_it_cannot_be_saved_is_shown_once(unkept):
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        assert (unkept(4), unkept(4.0)) == (8, 8.0)
    assert len(shown) == 1


@pytest.mark.parametrize("name", PRESETS)
def test_warming_up_ends_by_itself(name):
    warm_up(preset(name).replaced({"particle_count": 50}))


def test_kernels_run_as_plain_python_for_a_debugger():
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider",
         "--hypothesis-profile", "quick", "--deselect", LONG, *WITHOUT_COMPILING],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:]


def forget_what_was_read():
    for remembered in (compilation._text_of, compilation._imported_by, compilation._sources_of):
        remembered.cache_clear()


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of three modules: `entry` calls `part`, which needs `constants`."""
    monkeypatch.setattr(compilation, "PACKAGE", tmp_path)
    (tmp_path / "wing").mkdir()
    (tmp_path / "entry.py").write_text("from cable_tracker.wing.part import half\n")
    (tmp_path / "wing" / "part.py").write_text("from cable_tracker.constants import TWO\n")
    (tmp_path / "constants.py").write_text("TWO = 2\n")
    (tmp_path / "other.py").write_text("")
    forget_what_was_read()
    yield tmp_path
    forget_what_was_read()


def digest_after(path, text):
    path.write_text(text)
    forget_what_was_read()
    return compilation.digest_of(compilation.PACKAGE / "entry.py")


def test_machine_code_is_of_all_that_it_was_made_of(package):
    before = compilation.digest_of(package / "entry.py")
    assert digest_after(package / "other.py", "THREE = 3\n") == before
    changed = {
        before,
        digest_after(package / "constants.py", "TWO = 2.0\n"),
        digest_after(package / "wing" / "part.py", "TWO = 2\n"),
        digest_after(package / "entry.py", "from cable_tracker.wing import part\n"),
    }
    assert len(changed) == 4


def test_another_version_of_numba_has_other_machine_code(package, monkeypatch):
    before = compilation.digest_of(package / "entry.py")
    monkeypatch.setattr(compilation.numba, "__version__", "0.0")
    assert compilation.digest_of(package / "entry.py") != before


KEPT = """
from cable_tracker.particle_filter.particles import log_sum_exp
import numpy as np
log_sum_exp(np.zeros(3))
print(sum(log_sum_exp.stats.cache_hits.values()))
"""


def hits(**environment) -> str:
    done = subprocess.run(
        [sys.executable, "-c", KEPT],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env={k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"} | environment,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize(
    "name", ["NUMBA_CACHE_DIR", pytest.param("XDG_CACHE_HOME", marks=pytest.mark.slow)]
)
def test_the_next_process_finds_the_machine_code_in_the_folder_of_the_user(tmp_path, name):
    environment = {name: str(tmp_path / "cache")}
    assert hits(**environment) == "0"
    assert list((tmp_path / "cache" / "cable_tracker").glob("*/**/*.nbc"))
    assert hits(**environment) == "1"


def test_the_settings_of_numba_are_as_they_were():
    before = compilation.numba.config.CACHE_DIR
    compiled(sum_of_squares)
    assert before == compilation.numba.config.CACHE_DIR
