"""Boxes around targets, in files and bags."""

import os
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_writer import StorageFormat
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import (
    find_boxes,
    format_boxes,
    own_boxes,
    read_boxes,
)
from cable_tracker.sequences.labels.target_writer import write_target_bag, write_target_pictures
from cable_tracker.sequences.source import open_source

BOXES = [(1.0, 2.0, 11.0, 22.5), None, (3.0, 4.0, 13.25, 24.0)]

sides = st.floats(-1e6, 1e6)


def labelled():
    for index, box in enumerate(BOXES):
        picture = np.full((48, 64, 3), 10 * index, np.uint8)
        stamp = 1_000_000_000 + 40_000_000 * index
        yield Frame(index, stamp, raw_from_array(picture, "bgr8")), box


def found_in(path, truth=None):
    with open_source(path) as source:
        boxes = find_boxes(source, truth)
        frames = list(source.frames())
    return [(boxes.knows(frame), boxes.box(frame)) for frame in frames]


intervals = st.lists(sides, min_size=2, max_size=2, unique=True).map(sorted)
drawn_boxes = st.tuples(intervals, intervals).map(lambda b: (b[0][0], b[1][0], b[0][1], b[1][1]))


@given(st.lists(st.none() | drawn_boxes, min_size=1))
def test_numbers_are_read_back_to_the_last_bit(tmp_path_factory, boxes):
    file = tmp_path_factory.mktemp("boxes") / "boxes.txt"
    file.write_text(format_boxes((str(index), box) for index, box in enumerate(boxes)))
    assert list(read_boxes(file).values()) == boxes


def test_a_file_with_boxes_that_is_not_there_is_named(tmp_path):
    write_target_pictures(tmp_path / "dive", labelled())
    (tmp_path / "folder").mkdir()
    for name, advice in (("mistyped.txt", "check the path"), ("folder", "name a file in it")):
        with pytest.raises(RecordingError, match=rf"{name}: cannot be read .*; {advice}"):
            found_in(tmp_path / "dive", tmp_path / name)


def test_pictures_are_written_with_their_boxes(tmp_path):
    assert write_target_pictures(tmp_path / "dive", labelled()) == 3
    assert found_in(tmp_path / "dive") == [(True, box) for box in BOXES]


@pytest.mark.parametrize("storage", list(StorageFormat))
def test_labels_of_a_bag_are_matched_by_time(tmp_path, storage):
    assert write_target_bag(tmp_path / "dive", labelled(), storage=storage) == 3
    assert found_in(tmp_path / "dive") == [(True, box) for box in BOXES]


def test_a_text_file_labels_a_bag_by_number(tmp_path):
    write_target_bag(tmp_path / "dive", labelled())
    (tmp_path / "b.txt").write_text("# a comment\n2 buoy 5 6 7 8\n")
    found = found_in(tmp_path / "dive", tmp_path / "b.txt")
    assert found == [(False, None), (False, None), (True, (5.0, 6.0, 7.0, 8.0))]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0.png 1 2 3", "4 words"),
        ("0.png 1 2 3 nan", "not finite"),
        ("0.png 5 2 3 9", "no area"),
        ("0.png 1 2 x 9", "malformed"),
        ("0.png none\n0.png none", "labels 0.png again"),
        ("0 1 2 3 4\n00 2 3 4 5", "labels frame 0 again, as 00"),
        ("0.png 1 2 3 4\n0 none", "labels frame 0 again, as 0"),
        ("# nothing else", "no labels"),
        ("7.png 1 2 3 4", "no frame of"),
        ("7 1 2 3 4", "no frame of"),
    ],
)
def test_a_bad_label_file_is_refused_with_the_reason(tmp_path, line, words):
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 64), np.uint8))
    (tmp_path / "boxes.txt").write_text(line + "\n")
    with pytest.raises(RecordingError, match=words):
        found_in(tmp_path)


def test_missing_boxes_are_refused_with_the_way_to_give_them(tmp_path):
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 64), np.uint8))
    with pytest.raises(RecordingError, match="--truth"):
        found_in(tmp_path)


def test_a_bag_of_a_cable_has_no_boxes(tmp_path):
    write_bag(tmp_path / "dive", (frame for frame, _ in labelled()))
    with pytest.raises(RecordingError, match="ground_truth/box"):
        found_in(tmp_path / "dive")


def test_a_bag_with_boxes_that_cannot_be_opened_is_named(tmp_path):
    write_target_bag(tmp_path / "dive", labelled())
    broken = tmp_path / "broken.mcap"
    shutil.copy(tmp_path / "dive" / "dive.mcap", broken)
    os.truncate(broken, 20)
    with pytest.raises(RecordingError, match=r"broken\.mcap: not one message can be read"):
        found_in(tmp_path / "dive", broken)


def test_a_bag_whose_boxes_break_off_is_named(tmp_path):
    write_target_bag(tmp_path / "dive", labelled(), storage=StorageFormat.SQLITE3)
    write_target_bag(tmp_path / "broken", list(labelled()) * 20, storage=StorageFormat.SQLITE3)
    file = tmp_path / "broken" / "broken.db3"
    os.truncate(file, int(0.6 * file.stat().st_size))
    with pytest.raises(RecordingError, match=r"broken: \S+ is damaged after \d+ boxes"):
        found_in(tmp_path / "dive", tmp_path / "broken")


def test_the_boxes_of_a_recording_are_read_from_the_bag_that_is_open(tmp_path):
    write_target_bag(tmp_path / "dive", labelled())
    with open_source(tmp_path / "dive") as source:
        # A reader that opened it again would find nothing.
        (tmp_path / "dive" / "dive.mcap").unlink()
        assert list(own_boxes(source).by_stamp.values()) == BOXES
        assert list(find_boxes(source).by_stamp.values()) == BOXES


def test_pictures_may_have_blanks_in_their_names(tmp_path):
    for name in ("frame 0.png", "2 0.png", "plain.png"):
        cv2.imwrite(str(tmp_path / name), np.zeros((48, 64), np.uint8))
    text = "frame 0.png 1 1 9 9\n2 0.png 2 2 9 9\nplain.png none\n"
    (tmp_path / "boxes.txt").write_text(text)
    found = found_in(tmp_path)
    assert sorted(box for is_known, box in found if is_known and box) == [
        (1.0, 1.0, 9.0, 9.0),
        (2.0, 2.0, 9.0, 9.0),
    ]
    assert found.count((True, None)) == 1


def test_boxes_of_another_recording_are_refused(tmp_path):
    write_target_bag(tmp_path / "own", labelled())
    late = ((replace(frame, stamp=frame.stamp + 10**12), box) for frame, box in labelled())
    write_target_bag(tmp_path / "other", late)
    with pytest.raises(RecordingError, match="not one of its"):
        found_in(tmp_path / "own", tmp_path / "other")
