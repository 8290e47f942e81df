import cv2
import numpy as np
import pytest

from cable_tracker.gui.labelling import pictures as pictures_module
from cable_tracker.gui.labelling.pictures import Pictures
from cable_tracker.sequences.frame_access import FrameAccess
from cable_tracker.sequences.pictures.shown_levels import STAND_IN_SIZE
from cable_tracker.sequences.source import open_source

from .conftest import COUNT


def test_a_picture_shows_its_frame(folder, pictures):
    picture = Pictures(FrameAccess(open_source(folder))).picture(3)
    shown = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert np.abs(shown.astype(int) - pictures[3]).mean() < 3.0
    assert picture.frame == 3


def test_a_picture_of_a_camera_of_ten_bits_is_not_black(tmp_path):
    folder = tmp_path / "deep"
    folder.mkdir()
    deep = np.tile(np.linspace(100, 900, 64).astype(np.uint16), (48, 1))
    cv2.imwrite(str(folder / "0.png"), deep)
    picture = Pictures(FrameAccess(open_source(folder))).picture(0)
    shown = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert np.ptp(shown) > 25


def test_pictures_beyond_the_capacity_are_made_anew(folder, monkeypatch):
    monkeypatch.setattr(pictures_module, "KEPT_BYTES", 1)
    made = Pictures(FrameAccess(open_source(folder)))
    first = made.picture(0)
    assert made.picture(0) is first
    made.picture(1)
    assert made.picture(0) is not first


def test_a_frame_without_a_picture_says_why(folder):
    (folder / "001.png").write_bytes(b"no picture")
    source = open_source(folder, skip_bad_frames=True)
    picture = Pictures(FrameAccess(source)).picture(1)
    assert picture.trouble
    assert picture.jpeg


def test_a_frame_that_no_jpeg_can_hold_says_so(tmp_path):
    folder = tmp_path / "tall"
    folder.mkdir()
    cv2.imwrite(str(folder / "0.png"), np.zeros((65_501, 8), np.uint8))
    picture = Pictures(FrameAccess(open_source(folder))).picture(0)
    assert "cannot be encoded" in picture.trouble
    assert picture.size == STAND_IN_SIZE


def test_there_is_no_picture_behind_the_end(folder):
    with pytest.raises(IndexError):
        Pictures(FrameAccess(open_source(folder))).picture(COUNT)
