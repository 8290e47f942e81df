"""Recordings to label: the same bright cable, as pictures, as a video, and as a sequence file."""

import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.geometry import project_borders
from cable_tracker.cable.model.state import CableState
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.source import open_source

from ..conftest import Running

SIZE = (320, 240)
COUNT = 24


def true_state(frame):
    """The cable of a frame: it drifts and turns slowly."""
    return CableState(-20.0 + 2.0 * frame, 0.1 - 0.01 * frame, 50.0, 0.03)


def picture_of(state, rng):
    width, height = SIZE
    x, y = np.meshgrid(np.arange(width) - (width - 1) / 2, (height - 1) / 2 - np.arange(height))
    borders = project_borders(state.to_array()[None])
    across = [
        x * np.cos(angle) + y * np.sin(angle) - offset
        for angle, offset in zip(borders.angles[0], borders.offsets[0], strict=True)
    ]
    inside = np.clip(across[0] + 0.5, 0, 1) * np.clip(0.5 - across[1], 0, 1)
    grey = 60 + 110 * inside + rng.normal(0.0, 6.0, (height, width))
    return np.clip(grey, 0, 255).astype(np.uint8)


@pytest.fixture(scope="session")
def pictures():
    rng = np.random.default_rng(5)
    return [picture_of(true_state(frame), rng) for frame in range(COUNT)]


@pytest.fixture(scope="session")
def png_files(pictures):
    return {
        f"{number:03d}.png": cv2.imencode(".png", picture)[1].tobytes()
        for number, picture in enumerate(pictures)
    }


def write_folder(path, png_files):
    path.mkdir()
    for name, data in png_files.items():
        (path / name).write_bytes(data)
    return path


@pytest.fixture
def folder(tmp_path, png_files):
    """A folder of pictures."""
    return write_folder(tmp_path / "dive", png_files)


@pytest.fixture
def video(tmp_path, pictures):
    """A video."""
    path = tmp_path / "dive.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 25.0, SIZE)
    for picture in pictures:
        writer.write(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


@pytest.fixture
def bag(folder):
    """A ROS 2 bag."""
    path = folder.parent / "bag"
    write_bag(path, open_source(folder).frames())
    return path


@pytest.fixture
def sequence(folder):
    """A sequence file beside the folder."""
    path = folder.parent / "sequence.txt"
    lines = [f"{n}.5 0.1 40 0 # dive/{n:03d}.png\n" for n in range(3)]
    path.write_text("".join(lines))
    return path


@pytest.fixture(scope="session")
def window(tmp_path_factory, png_files):
    """The command `label` at work, for all tests that need none of their own."""
    home = tmp_path_factory.mktemp("label")
    write_folder(home / "dive", png_files)
    running = Running(["label", "dive", "--labels", "start.txt", "--port", "0"], home)
    running.home = home
    yield running
    running.stop()
