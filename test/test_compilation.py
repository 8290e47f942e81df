import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import (
    NUMBA_IS_INSTALLED,
    compiled,
    compiled_fast,
    uses_compiled_kernels,
)
from cable_tracker.trackers import warm_up


def sum_of_squares(values):
    total = 0.0
    for value in values:
        total += value * value
    return total


@pytest.mark.parametrize("compiler", [compiled, compiled_fast])
def test_a_compiled_function_returns_what_the_plain_one_returns(compiler):
    values = np.arange(100.0)
    assert compiler(sum_of_squares)(values) == sum_of_squares(values)


def test_what_cannot_be_kept_on_disk_is_compiled_all_the_same():
    namespace = {}
    exec("def twice(value):\n    return 2 * value", namespace)  # Of no file: there is no cache.
    assert compiled(namespace["twice"])(4) == 8


def test_auto_compiles_where_it_can():
    assert uses_compiled_kernels("auto") == NUMBA_IS_INSTALLED


def test_numpy_never_compiles():
    assert not uses_compiled_kernels("numpy")


@pytest.mark.parametrize("kernels", ["auto", "numpy"])
def test_warming_up_ends_by_itself(kernels):
    warm_up(TrackerParameters(kernels=kernels, particle_count=50))


def test_compiled_kernels_are_refused_where_numba_is_missing(tmp_path):
    done = run_without_numba(
        tmp_path,
        """
        from cable_tracker.cable.parameters.parameters import TrackerParameters
        from cable_tracker.errors import ParameterError
        try:
            TrackerParameters(kernels="compiled")
        except ParameterError as error:
            print(error)
        """,
    )
    assert "pip install numba" in done


def test_without_numba_the_tracker_runs_by_numpy_and_gives_the_same(tmp_path):
    program = """
        from cable_tracker.cable.kernels import make_likelihood_ratio
        from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio
        from cable_tracker.cable.parameters.parameters import TrackerParameters
        from cable_tracker.cable.measure.response_table import load_table
        from cable_tracker.compilation import NUMBA_IS_INSTALLED
        from cable_tracker.trackers import make_proposer, warm_up

        assert not NUMBA_IS_INSTALLED
        parameters = TrackerParameters(kernels="auto", particle_count=200)
        assert type(make_likelihood_ratio(parameters, load_table(""))) is BorderLikelihoodRatio
        assert type(make_proposer(parameters)).__name__ == "LinePairProposer"
        warm_up(parameters)
        """
    run_without_numba(tmp_path, program)
    without = run_without_numba(tmp_path, TRACK.replace("KERNELS", "auto"))
    assert run(TRACK.replace("KERNELS", "numpy")) == without != ""


TRACK = """
        import numpy as np
        from cable_tracker.cable.parameters.parameters import TrackerParameters
        from cable_tracker.trackers import make_tracker

        tracker = make_tracker(TrackerParameters(kernels="KERNELS", particle_count=200))
        picture = np.random.default_rng(0).normal(90, 3, (120, 160))
        picture[:, 70:94] += 60.0
        for number in range(1, 9):
            estimate = tracker.process(picture.astype(np.uint8), stamp=number * 40_000_000)
        print(estimate.state, estimate.status, estimate.presence)
        """


def run_without_numba(folder, program) -> str:
    """Run a program that cannot import Numba, and return what it prints."""
    hidden = folder / "numba"
    hidden.mkdir(exist_ok=True)
    (hidden / "__init__.py").write_text('raise ModuleNotFoundError("hidden")\n', encoding="utf-8")
    return run(program, folder)


def run(program, *folders) -> str:
    paths = [*map(str, folders), *sys.path]
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path)},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
