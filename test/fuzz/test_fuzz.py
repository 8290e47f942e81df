"""Whatever bytes a file holds, what reads it answers with our own errors, in bounded memory."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from targets import TARGETS

pytestmark = pytest.mark.slow

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
EXAMPLES = sorted(path for path in (HERE / "examples").rglob("*") if path.is_file())
RUNS = 250
"""Inputs for each target in the suite; `make fuzz RUNS=1000000` takes more."""

MUTATIONS = 150
BAGS = ("mcap", "sqlite", "ros1")
LARGEST_PEAK = 600 << 20
"""Bytes that reading a small file may take; one unpacked chunk has 256 MB at most."""

MISSING = "ATHERIS IS MISSING: nothing is fuzzed by coverage; run `pip install -e '.[dev]'`"


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """Flip bytes, and cut, repeat or overwrite a stretch."""
    content = bytearray(data)
    for place in rng.integers(0, len(content), rng.integers(1, 9)):
        content[place] ^= 1 << int(rng.integers(8))
    start, end = sorted(int(place) for place in rng.integers(0, len(content), 2))
    kind = int(rng.integers(5))
    if kind == 0:
        del content[end:]
    elif kind == 1:
        del content[start:end]
    elif kind == 2:
        content[start:start] = content[start:end]
    elif kind == 3:
        # A length that nothing can have.
        content[start : start + 8] = b"\xff" * int(rng.integers(1, 9))
    return bytes(content)


@pytest.mark.skipif(importlib.util.find_spec("atheris") is None, reason=MISSING)
@pytest.mark.parametrize("target", TARGETS)
def test_inputs_guided_by_coverage(target, tmp_path):
    command = [
        sys.executable, str(HERE / "run.py"), target,
        "--runs", str(RUNS), "--seed", "1", "--timeout", "300",
        "--corpus", str(tmp_path / "corpus"), "--findings", str(tmp_path / "findings"),
    ]  # fmt: skip
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, errors="replace", check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert f"stat::number_of_executed_units: {RUNS}" in done.stderr


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_inputs_that_once_found_a_defect_pass(path):
    data = path.read_bytes()
    tracemalloc.start()
    try:
        TARGETS[path.parent.name].run(data)
        assert tracemalloc.get_traced_memory()[1] < LARGEST_PEAK
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("target", TARGETS)
def test_the_seeds_of_every_target_are_accepted(target):
    for data in TARGETS[target].seeds().values():
        TARGETS[target].run(data)


@pytest.mark.parametrize("target", BAGS)
def test_recordings_with_flipped_bytes_cuts_and_wrong_lengths(target):
    rng = np.random.default_rng(20)
    for data in TARGETS[target].seeds().values():
        for _ in range(MUTATIONS):
            TARGETS[target].run(mutated(data, rng))


def test_make_fuzzes_every_target():
    (line,) = re.findall(r"^FUZZ_TARGETS \?= (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert line.split() == [*TARGETS]


@pytest.mark.parametrize("target", BAGS)
@pytest.mark.parametrize(
    "name", [b"sensor_msgs/msg/Joint", b"sensor_msgs/msg/.....", b"geometry_msgs/m/Image"]
)
def test_recordings_that_name_a_wrong_type(target, name):
    for data in TARGETS[target].seeds().values():
        for old in (b"sensor_msgs/msg/Image", b"sensor_msgs/Image"):
            TARGETS[target].run(data.replace(old, name[: len(old)]))
