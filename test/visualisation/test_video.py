from pathlib import Path
from threading import Event, current_thread

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import OutputError
from cable_tracker.visualisation.video import (
    CAPACITY,
    LONGEST_STEP,
    DrawingThread,
    VideoWriter,
    next_step,
)

av = pytest.importorskip("av", reason="PyAV is not installed")

SECOND = 1_000_000_000


def _picture(level, size=(64, 48)):
    image = np.zeros((size[1], size[0], 3), dtype=np.uint8)
    image[:] = (level, 255 - level, 128)
    return image


def _write(path, stamps, size=(64, 48)):
    with VideoWriter(path) as writer:
        for index, stamp in enumerate(stamps):
            writer.add(_picture(20 * index % 256, size), stamp)


def test_a_time_of_day_in_a_name_is_no_protocol(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    _write(Path("12:30:00.webm"), [0, SECOND])
    assert len(_read(tmp_path / "12:30:00.webm")) == 2


def _read(path):
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name in ("vp8", "libvpx")
        return [
            (
                float(frame.pts * stream.time_base),
                frame.format.name,
                frame.to_ndarray(format="bgr24"),
            )
            for frame in container.decode(stream)
        ]


@pytest.mark.parametrize(
    ("size", "even"), [((64, 48), (64, 48)), ((161, 97), (162, 98)), ((1, 1), (2, 2))]
)
def test_every_frame_is_decoded_again(tmp_path, size, even):
    _write(tmp_path / "v.webm", [index * SECOND // 25 for index in range(12)], size)
    frames = _read(tmp_path / "v.webm")
    assert len(frames) == 12
    assert all(image.shape == (even[1], even[0], 3) for _, _, image in frames)
    assert {name for _, name, _ in frames} == {"yuv420p"}


def test_colours_survive(tmp_path):
    _write(tmp_path / "v.webm", [0, SECOND])
    for index, (_, _, image) in enumerate(_read(tmp_path / "v.webm")):
        wanted = _picture(20 * index).astype(float)
        assert np.abs(image - wanted).mean() < 8


def test_times_are_those_of_the_stamps(tmp_path):
    start = 1_700_000_000 * SECOND
    offsets = [0.0, 0.04, 0.1, 0.5, 2.0, 2.033]
    _write(tmp_path / "v.webm", [start + round(offset * SECOND) for offset in offsets])
    assert [time for time, _, _ in _read(tmp_path / "v.webm")] == pytest.approx(offsets, abs=1e-3)


def test_repeated_and_backward_stamps_go_on_at_the_usual_pace(tmp_path):
    stamps = [0, SECOND // 10, SECOND // 10, 2 * SECOND // 10, 0, SECOND // 10]
    _write(tmp_path / "v.webm", stamps)
    times = [time for time, _, _ in _read(tmp_path / "v.webm")]
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4, 0.5], abs=1e-3)


def test_a_leap_of_the_clock_does_not_stop_the_video(tmp_path):
    _write(tmp_path / "v.webm", [0, SECOND // 25, 1_700_000_000 * SECOND])
    times = [time for time, _, _ in _read(tmp_path / "v.webm")]
    assert times == pytest.approx([0.0, 0.04, 0.08], abs=1e-3)


def test_stamps_nanoseconds_apart_stay_in_order(tmp_path):
    _write(tmp_path / "v.webm", list(range(20)))
    times = [time for time, _, _ in _read(tmp_path / "v.webm")]
    assert len(times) == 20
    assert (np.diff(times) > 0).all()


@given(st.integers(-(2**62), 2**62), st.integers(-(2**62), 2**62), st.integers(1, LONGEST_STEP))
def test_a_step_is_always_forward_and_never_endless(previous, stamp, usual):
    step = next_step(previous, stamp, usual)
    assert 0 < step <= LONGEST_STEP
    assert step in (stamp - previous, usual)


def test_frames_of_another_size_are_fitted(tmp_path):
    with VideoWriter(tmp_path / "v.webm") as writer:
        writer.add(_picture(0), 0)
        writer.add(_picture(0, (640, 100)), SECOND)
        writer.add(_picture(0, (63, 47)), 2 * SECOND)
    frames = _read(tmp_path / "v.webm")
    assert [image.shape for _, _, image in frames] == [(48, 64, 3)] * 3
    assert frames[1][2][:8].mean() < 30


def test_the_file_appears_under_its_name_only_at_the_end(tmp_path):
    path = tmp_path / "v.webm"
    with VideoWriter(path) as writer:
        writer.add(_picture(0), 0)
        assert not path.exists()
    assert [entry.name for entry in tmp_path.iterdir()] == ["v.webm"]


def test_an_error_leaves_nothing_behind(tmp_path):
    with pytest.raises(ZeroDivisionError), VideoWriter(tmp_path / "v.webm") as writer:
        writer.add(_picture(0), 0)
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


def test_an_error_keeps_an_older_video(tmp_path):
    _write(tmp_path / "v.webm", [0, SECOND])
    with pytest.raises(ZeroDivisionError), VideoWriter(tmp_path / "v.webm"):
        raise ZeroDivisionError
    assert len(_read(tmp_path / "v.webm")) == 2


def test_no_frames_no_video(tmp_path):
    with (
        pytest.raises(OutputError, match=r"v\.webm: no frames"),
        VideoWriter(tmp_path / "v.webm"),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_is_reported_at_once(tmp_path):
    with (
        pytest.raises(OutputError, match=r"v\.webm: cannot be written") as caught,
        VideoWriter(tmp_path / "missing" / "v.webm"),
    ):
        raise AssertionError
    assert "\n" not in str(caught.value)


def test_a_folder_in_its_place_is_reported_and_nothing_left(tmp_path):
    (tmp_path / "v.webm").mkdir()
    with pytest.raises(OutputError, match=r"v\.webm: cannot be written"):
        _write(tmp_path / "v.webm", [0, SECOND])
    assert [entry.name for entry in tmp_path.iterdir()] == ["v.webm"]


def test_a_full_disk_is_reported_and_nothing_left(tmp_path, full_disk):
    writer = VideoWriter(tmp_path / "v.webm")
    with pytest.raises(OutputError, match="No space left on device"), writer:
        writer._tick = full_disk
        writer.add(_picture(0), 0)
    assert list(tmp_path.iterdir()) == []


def test_a_writer_that_is_not_open_is_refused(tmp_path):
    with pytest.raises(OutputError, match="not open"):
        VideoWriter(tmp_path / "v.webm").add(_picture(0), 0)


def test_the_same_frames_give_the_same_file(tmp_path):
    for name in ("a.webm", "b.webm"):
        _write(tmp_path / name, [index * SECOND // 25 for index in range(12)])
    assert (tmp_path / "a.webm").read_bytes() == (tmp_path / "b.webm").read_bytes()


def test_jobs_are_done_in_order_in_another_thread():
    done = []
    with DrawingThread() as thread:
        for number in range(20):
            thread.do(lambda number=number: done.append((number, current_thread().name)))
    assert done == [(number, "drawing") for number in range(20)]


def test_no_more_jobs_wait_than_the_capacity():
    begun, go_on = Event(), Event()

    def hold():
        begun.set()
        assert go_on.wait(300)

    with DrawingThread() as thread:
        thread.do(hold)
        assert begun.wait(300)
        for _ in range(CAPACITY):
            thread.do(lambda: None)
        assert thread._jobs.full()
        go_on.set()


def test_an_error_is_told_at_a_later_job_or_at_the_end():
    def fail():
        raise OutputError("the disk is full")

    done = []
    with pytest.raises(OutputError, match="disk is full"), DrawingThread() as thread:
        thread.do(fail)
    with pytest.raises(OutputError, match="disk is full"), DrawingThread() as thread:
        thread.do(fail)
        for _ in range(1000):
            thread.do(lambda: done.append(1))
    assert not done


def test_after_an_exception_waiting_jobs_are_left_out():
    begun, go_on, done = Event(), Event(), []

    def hold():
        begun.set()
        assert go_on.wait(300)

    with pytest.raises(KeyboardInterrupt), DrawingThread() as thread:
        thread.do(hold)
        thread.do(lambda: done.append(1))
        assert begun.wait(300)
        thread._abandoned = True
        go_on.set()
        raise KeyboardInterrupt
    assert done == []
