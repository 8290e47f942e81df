from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError, RecordingError, UnreachableError
from cable_tracker.sequences.bags.bag import BagSource
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.labels.sequence_file import Label, SequenceFileSource, write_labels
from cable_tracker.sequences.pictures.image_folder import ImageFolderSource
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.sequences.source import open_source
from cable_tracker.sequences.source_base import Source
from cable_tracker.sequences.videos.video import VideoSource
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate


@pytest.fixture
def write_truth(tmp_path, state):
    """Write a sequence file that labels the given names."""

    def write(*names: tuple[str, int | None]):
        path = tmp_path / "truth.txt"
        write_labels(path, [Label(*name, state=state(k)) for k, name in enumerate(names)])
        return path

    return write


@pytest.fixture
def truth_of(pictures):
    """Return a function that writes labels of the given names beside the pictures."""

    def write(*names):
        path = pictures / "truth.txt"
        path.write_text("# a comment\n" + "".join(f"1 0.1 30 0 # {name}\n" for name in names))
        return path

    return write


def labelled(source: Source) -> dict[int, CableState]:
    return {frame.index: frame.truth for frame in source.frames() if frame.truth is not None}


def test_the_path_decides_the_kind(make_bag, make_ros1_bag, make_video, pictures, write_truth):
    video = make_video()
    bag = make_bag()
    kinds = {
        bag: BagSource,
        bag / "bag.mcap": BagSource,
        bag / "metadata.yaml": BagSource,
        make_bag("b3", storage="sqlite3") / "b3.db3": BagSource,
        make_ros1_bag(): BagSource,
        video: VideoSource,
        pictures: ImageFolderSource,
        write_truth((video.name, 1)): SequenceFileSource,
    }
    for path, kind in kinds.items():
        source = open_source(path)
        assert type(source) is kind
        assert isinstance(source, Source)
        assert list(source.frames())


def test_a_folder_with_a_stray_bag_file_beside_pictures_is_a_folder_of_pictures(pictures, make_bag):
    (make_bag() / "bag.mcap").rename(pictures / "bag.mcap")
    assert type(open_source(pictures)) is ImageFolderSource


def test_a_folder_of_ros1_bags_names_them(make_ros1_bag):
    with pytest.raises(RecordingError, match=r"name the file: old\.bag"):
        open_source(make_ros1_bag().parent)


@pytest.mark.parametrize(
    "name", ["x.mcap", "x.db3", "x.bag", "x.mp4", "x.txt", "x", "folder/", "a\0b"]
)
def test_a_missing_path_is_refused(tmp_path, name):
    with pytest.raises(RecordingError, match=name.rstrip("/").partition("\0")[0]):
        open_source(tmp_path / name)


@pytest.mark.parametrize("name", ["x.mcap", "x.db3", "x.bag", "x.mp4", "x.avi", "x.txt", "x.seq"])
def test_an_empty_file_is_refused(tmp_path, name):
    (tmp_path / name).touch()
    with pytest.raises(RecordingError, match=rf"{name}: the file is empty"):
        open_source(tmp_path / name)


def test_an_unknown_kind_is_refused_with_the_known_ones(tmp_path):
    (tmp_path / "x.pdf").write_text("x")
    with pytest.raises(RecordingError, match=r"\.pdf is no known kind .*\.mcap.*\.mp4"):
        open_source(tmp_path / "x.pdf")


def test_an_empty_folder_may_be_the_place_of_a_disk_that_is_not_mounted(tmp_path):
    with pytest.raises(UnreachableError, match=r"the folder is empty: .*mounted"):
        open_source(tmp_path)


def test_a_folder_without_pictures_is_refused(tmp_path):
    (tmp_path / "x.pdf").write_text("x")
    with pytest.raises(RecordingError, match="holds no pictures"):
        open_source(tmp_path)


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, math.inf])
def test_a_rate_must_be_positive(pictures, rate):
    with pytest.raises(ParameterError, match="rate"):
        open_source(pictures, rate=rate)


def test_a_topic_makes_sense_for_bags_only(make_bag, pictures, make_video):
    assert len(list(open_source(make_bag(), topic="camera/image").frames())) == 5
    for path in (pictures, make_video()):
        with pytest.raises(RecordingError, match="no topics"):
            open_source(path, topic="image")


def test_skipping_bad_frames_is_passed_on(make_bag):
    path = make_bag(bad_frame=0)
    assert len(list(open_source(path, skip_bad_frames=True).frames())) == 5


def test_labels_are_attached_to_a_video_by_number(make_video, write_truth, state):
    truth = write_truth(("dive.avi", 2), ("dive.avi", 7))
    source = open_source(make_video(), truth=truth)
    assert source.has_truth
    assert labelled(source) == {2: state(0).at_rest(), 7: state(1).at_rest()}


def test_labels_are_attached_to_a_bag_by_number(make_bag, write_truth, state):
    source = open_source(make_bag(truth=False), truth=write_truth(("strip.mp4", 3)))
    assert source.has_truth
    assert labelled(source) == {3: state(0).at_rest()}


def test_truth_of_a_bag_is_attached_to_a_bag_by_time_and_to_others_by_order(tmp_path):
    dive = list(simulate(SimulationSettings(4, image_size=(64, 48))))
    write_bag(tmp_path / "truth", [dive[1], dive[3]])
    write_bag(tmp_path / "dive", dive)
    truths = {index: dive[index].truth for index in (1, 3)}
    named = open_source(tmp_path / "dive", truth=tmp_path / "truth")
    assert named.has_truth
    assert labelled(named) == truths
    write_sequence(tmp_path / "two", [dive[1], dive[3]])
    pictures = open_source(tmp_path / "two", truth=tmp_path / "truth")
    assert labelled(pictures) == {0: dive[1].truth, 1: dive[3].truth}
    write_sequence(tmp_path / "four", dive)
    with pytest.raises(RecordingError, match="2 labels for 4 frames"):
        open_source(tmp_path / "four", truth=tmp_path / "truth")


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_truth_of_another_dive_is_refused(tmp_path, make_bag, storage):
    other = list(simulate(SimulationSettings(2, image_size=(64, 48))))
    write_bag(tmp_path / "other", other)
    with pytest.raises(RecordingError, match=r"other: not one of its 2 labels .* frame of .*bag"):
        open_source(make_bag(storage=storage), truth=tmp_path / "other")


def test_truth_of_a_dive_is_its_own_however_late_it_begins(tmp_path, make_bag, make_ros1_bag):
    write_bag(tmp_path / "late", list(open_source(make_bag()).frames())[4:])
    for path in (make_bag("again", truth=False), make_ros1_bag(truth=False)):
        assert list(labelled(open_source(path, truth=tmp_path / "late"))) == [4]


def test_a_bag_without_truth_is_no_truth(tmp_path, make_bag):
    dive = simulate(SimulationSettings(2, image_size=(64, 48)))
    write_bag(tmp_path / "other", [replace(frame, truth=None) for frame in dive])
    with pytest.raises(RecordingError, match="holds no ground_truth"):
        open_source(make_bag(), truth=tmp_path / "other")


def test_labels_are_attached_to_pictures_by_name(pictures, write_truth, state):
    truth = write_truth(("pictures/3.png", None), ("0.png", None))
    assert labelled(open_source(pictures, truth=truth)) == {
        3: state(0).at_rest(),
        0: state(1).at_rest(),
    }


@pytest.fixture
def days(tmp_path, picture):
    """Two folders, each with pictures of the same names."""
    folders = [tmp_path / "dives" / name for name in ("day1", "day2")]
    for folder in folders:
        folder.mkdir(parents=True)
        for index in range(2):
            cv2.imwrite(str(folder / f"{index}.png"), picture(index))
    return folders


@pytest.mark.parametrize("place", ["dives/", "", "elsewhere/"])
def test_labels_of_several_folders_are_matched_by_folder(tmp_path, days, write_truth, place, state):
    truth = write_truth(
        ("day1/0.png", None), ("day2/0.png", None), ("day1/1.png", None), ("day3/1.png", None)
    )
    (tmp_path / place).mkdir(exist_ok=True)
    moved = truth.replace(tmp_path / place / "truth.txt")
    day1, day2 = (labelled(open_source(folder, truth=moved)) for folder in days)
    assert day1 == {0: state(0).at_rest(), 1: state(2).at_rest()}
    assert day2 == {0: state(1).at_rest()}


def test_a_folder_is_known_by_its_place_before_its_name(days, write_truth, state):
    truth = write_truth(("old/day1/0.png", None), ("dives/day1/0.png", None))
    assert labelled(open_source(days[0], truth=truth)) == {0: state(1).at_rest()}


def test_labels_of_other_folders_that_could_both_be_meant_are_refused(days, write_truth):
    truth = write_truth(("a/0.png", None), ("b/0.png", None))
    with pytest.raises(RecordingError, match=r"labels a/0\.png and b/0\.png, either of which"):
        open_source(days[0], truth=truth)


def test_labels_of_a_folder_that_was_renamed_are_attached_by_name(days, write_truth, state):
    truth = write_truth(("a/0.png", None), ("a/1.png", None))
    assert labelled(open_source(days[0], truth=truth)) == {
        0: state(0).at_rest(),
        1: state(1).at_rest(),
    }


def test_labels_of_videos_of_one_name_are_matched_by_folder(make_video, write_truth, state):
    video = make_video()
    truth = write_truth(("other/dive.avi", 2), ("dive.avi", 2))
    assert labelled(open_source(video, truth=truth)) == {2: state(1).at_rest()}
    truth = write_truth(("other/dive.avi", 2), ("third/dive.avi", 2))
    with pytest.raises(RecordingError, match="either of which"):
        open_source(video, truth=truth)


def test_labels_are_attached_to_pictures_by_number(pictures, write_truth, state):
    truth = write_truth(("strip.mp4", 1))
    assert labelled(open_source(pictures, truth=truth)) == {1: state(0).at_rest()}


def test_labels_of_several_videos_are_matched_by_name(make_video, write_truth, state):
    truth = write_truth(("other.mp4", 1), ("dive.avi", 2))
    assert labelled(open_source(make_video(), truth=truth)) == {2: state(1).at_rest()}


def test_labels_for_several_other_videos_are_refused(make_video, write_truth):
    truth = write_truth(("a.mp4", 1), ("b.mp4", 2))
    with pytest.raises(RecordingError, match=r"holds labels, but none for a frame of .*dive"):
        open_source(make_video(), truth=truth)


def test_labels_that_fit_nothing_are_refused(make_video, write_truth):
    with pytest.raises(RecordingError, match="FILE:FRAME"):
        open_source(make_video(), truth=write_truth(("a.png", None)))


def test_a_missing_truth_is_refused(make_video, tmp_path):
    with pytest.raises(RecordingError, match=r"none\.txt"):
        open_source(make_video(), truth=tmp_path / "none.txt")


def test_the_real_video_with_its_labels(footage):
    with open_source(footage / "strip.mp4", truth=footage / "strip.txt") as source:
        frames = list(source.frames())
    assert len(frames) == 240
    assert sum(frame.truth is not None for frame in frames) == 138


def told(frame):
    return (frame.index, frame.stamp, bytes(frame.image.data), frame.truth)


def test_reading_may_begin_anywhere(make_bag, make_ros1_bag, make_video, pictures, write_truth):
    video = make_video()
    sequence = write_truth((video.name, 1), (video.name, 3), ("pictures/2.png", None))
    paths = [make_bag(), make_bag("b3", storage="sqlite3"), make_ros1_bag(), video, pictures]
    for path in (*paths, sequence):
        source = open_source(path)
        everything = [told(frame) for frame in source.frames()]
        for start in range(len(everything) + 2):
            rest = [told(frame) for frame in source.frames(start)]
            assert rest == everything[start:], (path, start)


def test_labels_are_found_by_the_names_of_their_pictures(pictures, truth_of):
    with open_source(pictures, truth=truth_of("2.png", "0.png")) as source:
        assert list(labelled(source)) == [0, 2]


@pytest.mark.parametrize("named", [".", "metadata.yaml", "../bag/", "../bag/../bag"])
def test_a_recording_has_the_name_of_its_folder_however_it_is_given(
    monkeypatch, make_bag, truth_of, named
):
    truth = truth_of("other:1", "bag:2", "old/bag:3")
    monkeypatch.chdir(make_bag(truth=False))
    with open_source(Path(named), truth=truth) as source:
        assert list(labelled(source)) == [2]


def test_a_label_without_a_frame_is_named(pictures, truth_of):
    truth = truth_of("0.png", "missing.png")
    with pytest.raises(RecordingError, match=r"line 3 labels missing\.png, which is no picture in"):
        open_source(pictures, truth=truth)


def test_a_label_beyond_the_last_frame_is_named(pictures, truth_of):
    truth = truth_of("any.mp4:3", "any.mp4:4")
    with pytest.raises(RecordingError, match=r"line 3 labels any\.mp4:4.*only 4 frames"):
        open_source(pictures, truth=truth)


def test_a_label_beyond_the_end_of_a_video_is_named(make_video, truth_of):
    with pytest.raises(RecordingError, match=r"labels dive\.avi:10.*only 10 frames"):
        open_source(make_video(), truth=truth_of("dive.avi:10"))


def test_a_label_beyond_the_end_is_named_after_the_last_frame_where_the_end_is_not_known(
    make_video, truth_of
):
    source = open_source(make_video("dive.mkv"), truth=truth_of("dive.mkv:9", "dive.mkv:10"))
    seen = []
    with pytest.raises(RecordingError, match=r"only 10 frames.* frame 10 is labelled"):
        seen.extend(source.frames())
    assert len(seen) == 10
    later = open_source(make_video("dive.mkv"), truth=truth_of("dive.mkv:9")).frames(start=8)
    assert [frame.truth is None for frame in later] == [True, False]


def test_a_label_without_a_frame_number_is_refused_for_a_bag(make_bag, truth_of):
    with pytest.raises(RecordingError, match=r"line 2 labels bag, which is no .*FILE:FRAME"):
        open_source(make_bag(truth=False), truth=truth_of("bag", "bag:3"))


@pytest.mark.parametrize("name", ["dive.avi: 3", "dive.avi:three", "dive.avi:-1", "dive.avi"])
def test_a_bad_frame_number_is_malformed(make_video, truth_of, name):
    with pytest.raises(RecordingError, match=r"line 3 is malformed .*dive\.avi"):
        open_source(make_video(), truth=truth_of("dive.avi:2", name))


def test_a_picture_may_be_named_after_a_frame_of_a_video(pictures, truth_of):
    (pictures / "0.png").rename(pictures / "dive.avi:0.png")
    assert open_source(pictures, truth=truth_of("dive.avi:0.png")).has_truth


def test_labels_of_frames_that_a_sequence_file_does_not_list_are_not_taken_for_others(
    make_video, truth_of
):
    folder = make_video().parent
    listed = folder / "listed.txt"
    listed.write_text("9 0.1 30 0 # dive.avi:5\n9 0.1 30 0 # dive.avi:7\n")
    with pytest.raises(RecordingError, match="none for a frame that"):
        open_source(listed, truth=truth_of("dive.avi:1"))
    with open_source(listed, truth=truth_of("dive.avi:1", "dive.avi:7")) as source:
        assert list(labelled(source)) == [1]


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
