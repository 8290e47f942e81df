"""Every command that writes, on a full disk, where it may not write, and over what exists."""

from __future__ import annotations

import errno
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate

pytestmark = pytest.mark.slow

PAGE = 4096
SOME_ROOM = 8
"""Pages of a disk that fills up while an output is written."""

COMMANDS: dict[str, tuple[str, ...]] = {
    "track": ("track", "{dive}", "--output", "{out}"),
    "convert to mcap": ("convert", "{dive}", "{out}"),
    "convert to sqlite3": ("convert", "{dive}", "{out}", "--storage", "sqlite3"),
    "simulate a bag": ("simulate", "{out}", "--frames", "5", "--size", "160x120"),
    "simulate pictures": (
        "simulate", "{out}", "--frames", "5", "--size", "160x120", "--format", "sequence",
    ),
    "evaluate": (
        "evaluate", "--source", "{dive}", "--method", "thesis", "--seeds", "1", "--workers", "1",
        "--output", "{out}",
    ),
    "experiment": (
        "dev", "experiment", "ablation", "--row", "default", "--seeds", "1", "--workers", "1",
        "--output", "{out}",
    ),
    "learn": ("learn", "{dive}", "--output", "{out}"),
    "parameters": ("parameters", "--output", "{out}"),
}  # fmt: skip

SLOW = {"experiment"}
"""Computes for minutes before it writes; what it writes with is tested with `evaluate`."""

WRITING = [name for name in COMMANDS if name not in SLOW]

LARGE = [name for name in WRITING if name not in ("learn", "parameters")]
"""Write more than there is some room for."""


@pytest.fixture(scope="module")
def dive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A labelled bag of six frames, on a disk with room."""
    path = tmp_path_factory.mktemp("dive") / "dive"
    settings = SimulationSettings(frame_count=6, image_size=(160, 120), clutter=0.1, seed=1)
    write_bag(path, simulate(settings))
    return path


@pytest.fixture
def run(dive: Path, command: Callable[..., Any]) -> Callable[..., Any]:
    """Run a command of the table."""

    def run_command(name: str, output: Path, *more: str) -> Any:
        words = [word.format(dive=dive, out=output) for word in COMMANDS[name]]
        return command(*words, *more)

    return run_command


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Callable[[int], Path]]:
    """Make a folder in which so many pages can be written.

    A tiny disk in memory where one may be mounted; elsewhere a limit on the size of files.
    """
    folder = tmp_path / "small"
    folder.mkdir()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    mounted: list[Path] = []

    def make(pages: int) -> Path:
        size = f"size={PAGE * max(pages, 1)}"
        mount = ["mount", "-t", "tmpfs", "-o", size, "tmpfs", str(folder)]
        if os.geteuid() or subprocess.run(mount, capture_output=True, check=False).returncode:
            # A limit for each file, not for all of them, so it is a part of the room.
            resource.setrlimit(resource.RLIMIT_FSIZE, (PAGE * pages // 8, limits[1]))
            return folder
        mounted.append(folder)
        if not pages:
            (folder / "ballast").write_bytes(bytes(PAGE))
        return folder

    yield make
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    for disk in mounted:
        # Lazily: a database that could not be made is closed when its exception is forgotten.
        subprocess.run(["umount", "--lazy", str(disk)], check=True)


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("name", "pages"), [*((name, 0) for name in WRITING), *((name, SOME_ROOM) for name in LARGE)]
)
def test_on_a_full_disk_only_finished_tasks_are_left_and_one_line_names_the_reason(
    run, small_disk, name, pages
):
    disk = small_disk(pages)
    before = names_in(disk)
    outcome = run(name, disk / "out")
    assert outcome.code == 2
    assert outcome.err.startswith("error: ")
    assert outcome.err.count("\n") == 1
    assert "cannot be written" in outcome.err
    assert names_in(disk) - before <= {"out.tasks"}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_cannot_be_written_to_is_refused_at_once(run, tmp_path, name):
    # A file where a folder is needed stops every user, root too.
    (tmp_path / "file").write_text("x")
    outcome = run(name, tmp_path / "file" / "out")
    assert outcome.code == 2
    assert outcome.err.startswith("error: ")
    assert outcome.err.count("\n") == 1
    assert os.strerror(errno.ENOTDIR) in outcome.err


@pytest.mark.parametrize("inside", [(), ("chapter.tex",)], ids=["file", "folder"])
@pytest.mark.parametrize("name", COMMANDS)
def test_a_foreign_file_or_folder_is_never_replaced(run, tmp_path, name, inside):
    output = tmp_path / "out"
    mine = output.joinpath(*inside)
    mine.parent.mkdir(exist_ok=True)
    mine.write_text("mine")
    assert "--force" in run(name, output).err
    forced = run(name, output, "--force")
    assert forced.code == 2
    assert "not overwritten" in forced.err
    assert mine.read_text() == "mine"
    assert names_in(tmp_path) == {"out"}


@pytest.mark.parametrize("name", WRITING)
def test_an_earlier_output_is_replaced_with_force(run, tmp_path, name):
    output = tmp_path / "out"
    assert run(name, output).code == 0
    before = output.stat().st_ino
    refused = run(name, output)
    assert refused.code == 2
    assert "--force" in refused.err
    assert output.stat().st_ino == before
    assert run(name, output, "--force").code == 0
    assert output.stat().st_ino != before
    assert names_in(tmp_path) == {"out"}


def test_an_earlier_output_outlives_a_full_disk(run, small_disk):
    disk = small_disk(1)
    output = disk / "out.yaml"
    output.write_text("a: 1\n")
    assert run("parameters", output, "--force").code == 2
    assert output.read_text() == "a: 1\n"
    assert names_in(disk) == {"out.yaml"}


def test_a_power_cut_leaves_nothing_that_looks_complete(tmp_path):
    command = [sys.executable, "-m", "cable_tracker.cli", "simulate", "out", "--frames", "5000"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL) as process:
        while process.poll() is None and not (tmp_path / ".out.partial" / "out").exists():
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert process.returncode == -signal.SIGKILL
    assert names_in(tmp_path) == {".out.partial"}
