from functools import partial

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.errors import OutputError, ParameterError
from cable_tracker.visualisation.contact_sheet import CAPTION_SHARE, ContactSheet
from cable_tracker.visualisation.palette import AMBER


def _picture(value=90, size=(64, 48)):
    return np.full((size[1], size[0], 3), value, dtype=np.uint8)


def test_every_tenth_frame_is_kept():
    sheet = ContactSheet()
    drawn = []
    for frame in range(31):
        sheet.add(lambda frame=frame: (drawn.append(frame), _picture())[1], frame)
    assert drawn == [0, 10, 20, 30]
    assert len(sheet) == 4


@settings(max_examples=30)
@given(st.integers(1, 700), st.integers(1, 5), st.integers(2, 9))
def test_a_long_recording_is_spanned_evenly_in_bounded_memory(count, stride, limit):
    sheet = ContactSheet(stride, limit, 32)
    for frame in range(count):
        sheet.add(_picture, frame)
        assert len(sheet) <= limit
    assert len(sheet) == -(-count // sheet.stride)


def test_the_pictures_kept_are_those_of_the_stride():
    sheet = ContactSheet(stride=1, limit=4, thumbnail_width=32)
    for frame in range(9):
        sheet.add(partial(_picture, frame * 20), frame)
    assert sheet.stride == 4
    cells = [sheet.draw()[6, 6 + 36 * place, 0] for place in range(2)]
    assert len(sheet) == 3
    assert cells == [0, 80]


def test_the_sheet_is_written_as_png(tmp_path):
    sheet = ContactSheet(stride=1, thumbnail_width=100)
    for frame in range(7):
        sheet.add(_picture, frame)
    sheet.write(tmp_path / "overlay.png")
    written = cv2.imread(str(tmp_path / "overlay.png"))
    np.testing.assert_array_equal(written, sheet.draw())
    assert [path.name for path in tmp_path.iterdir()] == ["overlay.png"]


def test_frames_are_labelled_with_their_numbers():
    one, other = ContactSheet(), ContactSheet()
    one.add(_picture, 7)
    other.add(_picture, 8)
    assert (one.draw() != other.draw()).any()


def test_a_frame_of_another_size_is_fitted_without_distortion():
    sheet = ContactSheet(stride=1, thumbnail_width=64)
    sheet.add(partial(_picture, 200), 0)
    sheet.add(partial(_picture, 200, (48, 200)), 1)
    second = sheet.draw()[4:52, -68:-4]
    bright = np.flatnonzero((second[10] == 200).all(axis=1))
    assert bright.size == pytest.approx(48 * 48 / 200, abs=1)


def test_a_sheet_of_one_frame_has_its_size():
    sheet = ContactSheet(thumbnail_width=64)
    sheet.add(_picture, 0)
    caption = round(CAPTION_SHARE * 64) + 2
    assert sheet.draw().shape == (48 + caption + 8, 64 + 8, 3)


def test_the_label_stands_below_the_picture():
    sheet = ContactSheet(thumbnail_width=64)
    sheet.add(_picture, 123, "INITIALISING 12 %", AMBER)
    drawn = sheet.draw()
    assert (drawn[4:52, 4:68] == 90).all()
    assert drawn[52:-4, 4:68].max() > 100


def test_no_frames_no_sheet(tmp_path):
    with pytest.raises(OutputError, match="no frames"):
        ContactSheet().write(tmp_path / "overlay.png")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("arguments", [(0, 60, 320), (10, 1, 320), (10, 60, 31)])
def test_numbers_that_are_too_small_are_refused(arguments):
    with pytest.raises(ParameterError, match="contact sheet"):
        ContactSheet(*arguments)
