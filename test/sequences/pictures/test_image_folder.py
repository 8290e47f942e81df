from __future__ import annotations

import cv2
import numpy as np
import pytest

from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.pictures.image_folder import load_picture
from cable_tracker.sequences.source import open_source
from cable_tracker.stamps import FIRST_STAMP

SUFFIXES = [".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm"]


@pytest.fixture
def folder(tmp_path, picture):
    """Twelve pictures whose names sort wrongly as text."""
    path = tmp_path / "pictures"
    path.mkdir()
    for index in range(12):
        cv2.imwrite(str(path / f"img_{index}.png"), picture(index))
    return path


def test_pictures_come_in_natural_order(folder, picture):
    frames = list(open_source(folder).frames())
    assert len(frames) == 12
    for index, frame in enumerate(frames):
        np.testing.assert_array_equal(decode_grey(frame.image), picture(index))


def test_the_rate_gives_the_time(folder):
    source = open_source(folder, rate=10.0)
    assert [frame.stamp - FIRST_STAMP for frame in source.frames()][:3] == [
        0,
        100_000_000,
        200_000_000,
    ]
    assert source.frame_count == 12


def test_missing_numbers_are_noted_and_the_times_kept(folder):
    for index in (4, 5, 9):
        (folder / f"img_{index}.png").unlink()
    source = open_source(folder, rate=10.0)
    assert source.note.startswith("3 pictures are missing by their numbers, the first after img_3")
    stamps = [(frame.stamp - FIRST_STAMP) // 100_000_000 for frame in source.frames()]
    assert stamps == [0, 1, 2, 3, 6, 7, 8, 10, 11]
    source.label({})
    assert "missing" in source.note


def test_other_and_hidden_files_are_left_out(folder):
    (folder / "notes.txt").write_text("x")
    (folder / ".hidden.png").write_bytes(b"x")
    assert open_source(folder).frame_count == 12


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_kind_of_picture_is_decoded(tmp_path, suffix):
    flat = np.full((20, 30) if suffix == ".pgm" else (20, 30, 3), 77, np.uint8)
    cv2.imwrite(str(tmp_path / f"a{suffix}"), flat)
    frame = next(open_source(tmp_path).frames())
    assert decode_grey(frame.image).shape == (20, 30)
    np.testing.assert_allclose(decode_grey(frame.image), 77, atol=2)


@pytest.mark.parametrize(
    ("dtype", "channels", "encoding"),
    [
        ("uint8", 1, "mono8"), ("uint8", 3, "bgr8"), ("uint8", 4, "bgra8"),
        ("uint16", 1, "mono16"), ("uint16", 3, "bgr16"),
    ],
)  # fmt: skip
def test_depth_and_channels_are_kept(tmp_path, dtype, channels, encoding):
    shape = (4, 6) if channels == 1 else (4, 6, channels)
    cv2.imwrite(str(tmp_path / "a.png"), np.full(shape, 200, dtype))
    assert load_picture(tmp_path / "a.png").encoding == encoding


def pnm(kind: int, white: int, levels: np.ndarray) -> bytes:
    height, width = levels.shape[:2]
    header = b"P%d\n# a camera\n%d %d #12\n%d\n" % (kind, width, height, white)
    if kind < 5:
        return header + b" ".join(b"%d" % level for level in levels.ravel()) + b"\n"
    return header + levels.astype(">u2" if white > 255 else "u1").tobytes()


@pytest.mark.parametrize("kind", [2, 3, 5, 6])
@pytest.mark.parametrize("white", [15, 100, 255, 1023, 4095, 65535])
def test_white_of_a_pnm_is_that_of_its_header(tmp_path, kind, white):
    shares = np.linspace(0.0, 1.0, 16).reshape(2, 8)
    levels = np.rint(shares * white).astype(int)
    if kind in (3, 6):
        levels = np.repeat(levels[..., None], 3, axis=2)
    (tmp_path / "a.pnm").write_bytes(pnm(kind, white, levels))
    grey = decode_grey(load_picture(tmp_path / "a.pnm"))
    np.testing.assert_allclose(grey, 255.0 * shares, atol=0.5 * 255.0 / white + 1.0)
    assert grey.min() == 0.0
    assert grey.max() == 255.0


def test_a_bitmap_is_black_and_white(tmp_path):
    (tmp_path / "a.pbm").write_bytes(b"P4\n8 2\n\xf0\x0f")
    grey = decode_grey(load_picture(tmp_path / "a.pbm"))
    np.testing.assert_array_equal(grey, [[0] * 4 + [255] * 4, [255] * 4 + [0] * 4])


def test_a_16_bit_picture_with_transparency_is_refused(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((4, 6, 4), np.uint16))
    with pytest.raises(FrameError, match="4 channels of uint16"):
        load_picture(tmp_path / "a.png")


@pytest.mark.parametrize("suffix", sorted({*SUFFIXES} - {".jpeg", ".tiff"}))
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.95])
def test_a_truncated_picture_is_refused(tmp_path, suffix, share):
    noise = np.random.default_rng(0).integers(0, 256, (60, 80, 3), dtype=np.uint8)
    if suffix == ".pgm":
        noise = noise[:, :, 0]
    path = tmp_path / f"a{suffix}"
    cv2.imwrite(str(path), noise)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(FrameError):
        load_picture(path)


def test_a_bad_picture_stops_after_those_before_it(folder):
    (folder / "img_3.png").write_bytes(b"rubbish")
    frames = []
    with pytest.raises(RecordingError, match=r"frame 3 \(img_3\.png\) cannot be decoded"):
        for frame in open_source(folder).frames():
            frames.append(frame)
    assert len(frames) == 3


def test_a_bad_picture_can_be_handed_out(folder):
    (folder / "img_3.png").write_bytes(b"rubbish")
    (folder / "img_5.png").unlink()
    (folder / "img_5.png").mkdir()
    frames = list(open_source(folder, skip_bad_frames=True).frames())
    assert len(frames) == 12
    for index in (3, 5):
        with pytest.raises(FrameError):
            decode_grey(frames[index].image)
