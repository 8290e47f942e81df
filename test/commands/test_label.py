import socket

import cv2
import numpy as np
import pytest

from cable_tracker.commands.label import label
from cable_tracker.errors import GuiError, RecordingError

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED")

LINE = "1 0 40 0 # dive/000.png\n"


@pytest.fixture
def folder(tmp_path):

    path = tmp_path / "dive"
    path.mkdir()
    cv2.imwrite(str(path / "000.png"), np.zeros((24, 32), np.uint8))
    return path


def test_a_missing_recording_is_told(tmp_path):
    with pytest.raises(RecordingError, match="there is no such file or folder"):
        label(tmp_path / "nowhere.avi")


@pytest.mark.parametrize("named", [True, False])
def test_an_unreadable_label_file_is_told_by_line_and_left_alone(folder, tmp_path, named):
    labels = tmp_path / "dive.txt"
    labels.write_text(f"{LINE}what?\n")
    with pytest.raises(RecordingError, match=r"dive\.txt: line 2 is malformed"):
        label(folder, labels=labels if named else None)
    assert labels.read_text() == f"{LINE}what?\n"


def test_a_taken_port_is_told(folder):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(GuiError, match=f"port {port}"):
            label(folder, port=port)
