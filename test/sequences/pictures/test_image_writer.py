from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError
from cable_tracker.sequences.encodings import decode_bgr, decode_grey, raw_from_array
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.sequences.source import open_source

STATE = CableState(12.345678901234567, -0.7, 30.0, 0.01)


@pytest.fixture
def frames(make_frame):
    return [make_frame(index, STATE if index != 1 else None) for index in range(3)]


def test_all_frames_are_written_and_the_labelled_ones_listed(tmp_path, frames):
    assert write_sequence(tmp_path / "out", frames) == 3
    with open_source(tmp_path / "out") as source:
        read = list(source.frames())
    assert len(read) == 3
    for old, new in zip(frames, read, strict=True):
        np.testing.assert_array_equal(decode_grey(old.image), decode_grey(new.image))
    with open_source(tmp_path / "out" / "sequence.txt") as source:
        assert [frame.truth for frame in source.frames()] == [STATE, STATE]


def test_the_labels_fit_the_folder(tmp_path, frames):
    write_sequence(tmp_path / "out", frames)
    with open_source(tmp_path / "out", truth=tmp_path / "out" / "sequence.txt") as source:
        assert [frame.truth for frame in source.frames()] == [STATE, None, STATE]


def test_colour_is_kept(tmp_path):
    picture = np.random.default_rng(0).integers(0, 256, (6, 8, 3), dtype=np.uint8)
    write_sequence(tmp_path / "out", [Frame(0, 0, raw_from_array(picture, "bgr8"))])
    frame = next(open_source(tmp_path / "out").frames())
    np.testing.assert_array_equal(decode_bgr(frame.image), picture)


def test_sixteen_bits_become_eight(tmp_path):
    picture = np.full((6, 8), 257 * 100, np.uint16)
    write_sequence(tmp_path / "out", [Frame(0, 0, raw_from_array(picture, "mono16"))])
    frame = next(open_source(tmp_path / "out").frames())
    assert frame.image.encoding == "mono8"
    assert decode_grey(frame.image)[0, 0] == 100


def test_nothing_is_left_after_a_bad_frame(tmp_path, frames):
    bad = Frame(3, 0, RawImage("mono8", 1, 1, 0, False, memoryview(b"")))
    with pytest.raises(FrameError):
        write_sequence(tmp_path / "out", [*frames, bad])
    assert list(tmp_path.iterdir()) == []
