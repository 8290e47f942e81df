from __future__ import annotations

from pathlib import Path

import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError, RecordingError, one_line
from cable_tracker.sequences.encodings import decode_bgr, decode_grey
from cable_tracker.sequences.frame import Frame, missing_image
from cable_tracker.sequences.source_base import ChosenRecording, Source


class ListSource(Source):
    """Frames of a list."""

    def __init__(self, items, **options):
        super().__init__(ChosenRecording(Path("list"), **options))
        self.items = items
        self.ended = 0

    def _read(self, start):
        try:
            yield from self.items[start:]
        finally:
            self.ended += 1


def test_leaving_the_context_ends_all_readings(make_frame):
    with ListSource([make_frame(0), make_frame(1)]) as source:
        first, second = source.frames(), source.frames()
        next(first)
        next(second)
        assert source.ended == 0
    assert source.ended == 2


def test_labels_take_the_place_of_all_truth(make_frame, state):
    source = ListSource([make_frame(0, state(0)), make_frame(1, state(1))])
    other = CableState(1.0, 0.0, 2.0)
    source.label({1: other})
    assert source.has_truth
    assert [frame.truth for frame in source.frames()] == [None, other]


def wet(*, compressed=False):
    return Frame(1, 5, missing_image("it is wet", compressed=compressed))


@pytest.mark.parametrize("compressed", [False, True])
def test_a_frame_without_an_image_stops_the_reading(make_frame, compressed):
    source = ListSource([make_frame(0), wet(compressed=compressed)])
    frames = source.frames()
    next(frames)
    with pytest.raises(RecordingError, match=r"list: frame 1 cannot be decoded \(it is wet\)"):
        next(frames)
    assert source.ended == 1


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("decode", [decode_grey, decode_bgr])
def test_decoding_a_missing_image_raises_the_reason(compressed, decode):
    (frame,) = ListSource([wet(compressed=compressed)], skip_bad_frames=True).frames()
    assert not frame.has_image
    with pytest.raises(FrameError, match=r"^it is wet$"):
        decode(frame.image)


def test_long_and_many_lined_reasons_become_one_short_line():
    assert one_line(ValueError("a\n  b\tc")) == "a b c"
    assert one_line(ValueError()) == "ValueError"
    assert len(one_line(ValueError("x" * 10_000))) == 200
