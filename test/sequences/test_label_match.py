import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.source import open_source


@pytest.fixture
def truth_of(pictures):
    """Return a function that writes labels of the given names beside the pictures."""

    def write(*names):
        path = pictures / "truth.txt"
        path.write_text("# a comment\n" + "".join(f"1 0.1 30 0 # {name}\n" for name in names))
        return path

    return write


def test_labels_are_found_by_the_names_of_their_pictures(pictures, truth_of):
    with open_source(pictures, truth=truth_of("2.png", "0.png")) as source:
        labelled = [frame.index for frame in source.frames() if frame.truth is not None]
    assert labelled == [0, 2]


def test_a_label_without_a_frame_is_named(pictures, truth_of):
    truth = truth_of("0.png", "missing.png")
    with pytest.raises(RecordingError, match=r"line 3 labels missing\.png.*no such picture"):
        open_source(pictures, truth=truth)


def test_a_label_beyond_the_last_frame_is_named(pictures, truth_of):
    truth = truth_of("any.mp4:3", "any.mp4:4")
    with pytest.raises(RecordingError, match=r"line 3 labels any\.mp4:4.*only 4 frames"):
        open_source(pictures, truth=truth)


def test_a_label_beyond_the_end_of_a_video_is_named(make_video, truth_of):
    with pytest.raises(RecordingError, match=r"labels dive\.avi:10.*only 10 frames"):
        open_source(make_video(), truth=truth_of("dive.avi:10"))


def test_a_second_label_of_a_frame_is_named(pictures, truth_of):
    with pytest.raises(RecordingError, match=r"line 4 labels 1\.png again, after line 3"):
        open_source(pictures, truth=truth_of("0.png", "1.png", "1.png"))


def test_labels_that_name_files_elsewhere_are_checked_where_that_is_allowed(pictures, truth_of):
    truth = truth_of("../any.mp4:3", "../any.mp4:4")
    with pytest.raises(RecordingError, match="--allow-outside"):
        open_source(pictures, truth=truth)
    with pytest.raises(RecordingError, match=r"line 3 labels .*any\.mp4:4.*only 4 frames"):
        open_source(pictures, truth=truth, allow_outside=True)
    source = open_source(pictures, truth=truth_of("../any.mp4:3"), allow_outside=True)
    assert source.has_truth


@pytest.mark.parametrize("width", [0, -3])
def test_a_label_without_a_width_is_refused(pictures, width):
    truth = pictures / "truth.txt"
    truth.write_text(f"1 0.1 {width} 0 # 0.png\n")
    with pytest.raises(RecordingError, match=f"line 1 is malformed .w is {width} px"):
        open_source(pictures, truth=truth)
