from pathlib import Path

from cable_tracker.sequences.videos.video_frames import ffmpeg_name


def test_nothing_before_a_colon_looks_like_a_protocol():
    assert ffmpeg_name(Path("12:30:00.mp4")) == "./12:30:00.mp4"


def test_a_path_from_the_root_is_as_it_was():
    assert ffmpeg_name(Path("/dives/12:30:00.mp4")) == "/dives/12:30:00.mp4"
