from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.parametrize("name", ["tracker", "replay"])
def test_without_ros_the_nodes_say_what_to_install(name: str, tmp_path: Path) -> None:
    (tmp_path / "rclpy.py").write_text("raise ModuleNotFoundError('no rclpy', name='rclpy')\n")
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
    assert run.stderr.startswith("RosError: rclpy or a message package is not installed (rclpy)")
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
