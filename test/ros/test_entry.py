from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cable_tracker.ros.entry import run
from cable_tracker.ros.process.stop_request import StopRequest


@pytest.mark.parametrize(
    ("name", "raised", "missing"),
    [
        ("tracker", "ModuleNotFoundError('no rclpy', name='rclpy')", "(rclpy)"),
        ("replay", "ImportError('librcl.so: cannot open shared object file')", "(librcl.so: "),
    ],
)
def test_without_ros_the_nodes_say_what_to_install(
    name: str, raised: str, missing: str, tmp_path: Path
) -> None:
    (tmp_path / "rclpy.py").write_text(f"raise {raised}\n")
    path = os.pathsep.join((str(tmp_path), os.environ["PYTHONPATH"]))
    code = f"from cable_tracker.ros.entry import {name}; {name}()"
    run = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 2
    words = f"error: rclpy or a message package is not installed {missing}"
    assert run.stderr.startswith(words)
    assert len(run.stderr.splitlines()) == 1


def test_another_missing_module_is_not_taken_for_ros(tmp_path: Path) -> None:
    (tmp_path / "cv2.py").write_text("raise ModuleNotFoundError('no cv2', name='cv2')\n")
    path = os.pathsep.join((str(tmp_path), os.environ["PYTHONPATH"]))
    run = subprocess.run(
        [sys.executable, "-c", "from cable_tracker.ros.entry import tracker; tracker()"],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 1
    assert "ModuleNotFoundError: no cv2" in run.stderr


@pytest.mark.parametrize(
    ("arguments", "code"), [(["--help"], 0), (["-p", "particle_count:=9"], 2), (["thesis"], 2)]
)
def test_arguments_before_ros_args_print_the_usage(
    arguments: list[str],
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("cable_tracker.ros.entry.stop_on_signals", StopRequest)
    assert run("tracker", ["tracker", *arguments]) == code
    assert capfd.readouterr().err.startswith("usage: tracker --ros-args")
