from __future__ import annotations

import cv2
import numpy as np
import pytest

from cable_tracker.cable.measure.picture.overlays import (
    BESIDE,
    dead_lines,
    standing_lines,
    without_dead_margins,
    without_standing_lines,
)

FRAME = 0.04
ENOUGH = 0.04
BRIGHT, DARK = 235, 0


@pytest.fixture
def live(rng) -> np.ndarray:
    return np.clip(rng.normal(100.0, 20.0, (120, 160)), 30, 255).astype(np.uint8)


def test_a_picture_without_margins_is_returned_itself(live):
    assert without_dead_margins(live) is live


@pytest.mark.parametrize("level", [0, 16])
@pytest.mark.parametrize("thickness", [3, 12, 28])
def test_bars_are_filled_with_the_nearest_live_line(live, level, thickness):
    barred = live.copy()
    barred[:thickness] = level
    barred[:, -thickness:] = level
    filled = without_dead_margins(barred)
    inside = np.s_[thickness + BESIDE :, : -thickness - BESIDE]
    np.testing.assert_array_equal(filled[inside], live[inside])
    first = thickness + BESIDE
    assert (filled[: first + 1, :-first] == live[first, :-first]).all()
    assert dead_lines(filled) == 0
    assert (barred[:thickness] == level).all()


def test_text_on_a_bar_does_not_hide_the_bar(live, rng):
    barred = live.copy()
    barred[:20] = 0
    barred[6:14, 30:80] = 255 * (rng.random((8, 50)) < 0.5)
    assert dead_lines(barred) == 20 + BESIDE


def test_a_compressed_caption_at_the_very_edge_does_not_hide_a_bar(live):
    """Compression in blocks of 8 px spreads what is written to the outermost line."""
    barred = live.copy()
    barred[:24] = 6
    write(barred, "KP 23.417", (2, 10))
    shown = compressed(barred, 60)
    assert np.ptp(shown[0].astype(int)) > 10
    assert dead_lines(shown) == 24 + BESIDE


def compressed(picture: np.ndarray, quality: int) -> np.ndarray:
    _, packed = cv2.imencode(".jpg", picture, (cv2.IMWRITE_JPEG_QUALITY, quality))
    return cv2.imdecode(packed, cv2.IMREAD_GRAYSCALE)


def write(picture: np.ndarray, text: str, place: tuple[int, int], level: int = 230) -> None:
    cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.35, level)


@pytest.mark.parametrize("quality", [40, 60, 80])
def test_captions_from_end_to_end_of_a_compressed_bar_do_not_hide_it(live, quality):
    barred = np.tile(live, (1, 2))
    barred[:24] = 16
    for row in (9, 20):
        write(barred, "N 6712", (2, row))
        write(barred, "HDG 183", (260, row))
    assert dead_lines(compressed(barred, quality)) == 24 + BESIDE


def test_boxes_of_captions_that_are_darker_than_a_bar_do_not_hide_it(live):
    barred = live.copy()
    barred[:24] = 16
    barred[4:18, 2:70] = barred[4:18, 80:158] = 0
    write(barred, "KP 12.415", (4, 14))
    assert dead_lines(barred) == 24 + BESIDE


@pytest.mark.parametrize("thickness", [17, 20, 22])
def test_the_block_in_which_a_compressed_bar_ends_is_filled_with_it(live, thickness):
    """The last lines of such a bar are neither black nor of the scene: its edge stands there."""
    barred = live.copy()
    barred[:thickness] = 0
    assert thickness <= dead_lines(compressed(barred, 30)) <= 24 + BESIDE


@pytest.mark.parametrize("thickness", [17, 20, 22])
def test_no_edge_is_left_of_a_compressed_bar(live, thickness):
    barred = np.full_like(live, 120)
    barred[:thickness] = 0
    filled = without_dead_margins(compressed(barred, 30))
    assert np.ptp(filled.astype(int)) < 20


def test_a_dark_bottom_that_is_nowhere_plain_is_no_margin(rng):
    dark = np.clip(rng.normal(8.0, 4.0, (120, 160)), 0, 255).astype(np.uint8)
    assert without_dead_margins(dark) is dark


@pytest.mark.parametrize("reach", [30.0, 35.0, 40.0])
def test_the_dark_about_the_cone_of_a_lamp_is_no_margin(rng, reach):
    y, x = np.mgrid[:120, :160]
    light = np.exp(-((np.hypot(x - 75.0, y - 58.0) / reach) ** 2))
    night = np.round(rng.normal(120.0, 15.0, (120, 160)) * light).astype(np.uint8)
    assert without_dead_margins(night) is night


def test_a_bar_beside_the_cone_of_a_lamp_is_filled(rng):
    y, x = np.mgrid[:120, :160]
    light = np.exp(-((np.hypot(x - 75.0, y - 58.0) / 90.0) ** 2))
    barred = np.round(rng.normal(120.0, 15.0, (120, 160)) * light).astype(np.uint8)
    barred[:15] = 0
    assert dead_lines(barred) == 15 + BESIDE


def test_a_flat_bottom_beside_a_strip_is_no_margin():
    picture = np.full((120, 160), 70, np.uint8)
    picture[:, 30:60] = 180
    assert without_dead_margins(picture) is picture


@pytest.mark.parametrize("shape", [(16, 16), (120, 160)])
def test_a_picture_that_is_flat_all_over_has_no_margins(shape):
    flat = np.full(shape, 7, np.uint8)
    assert without_dead_margins(flat) is flat


def ground_of(frame: int, size=(240, 320), speed=7) -> np.ndarray:
    """Return a rough ground that moves by some pixels per frame."""
    rng = np.random.default_rng(0)
    ground = rng.normal(110.0, 12.0, (size[0] + 400, size[1] + 400))
    corner = 10 + frame * speed
    return (
        ground[corner : corner + size[0], corner : corner + size[1]].clip(1, 254).astype(np.uint8)
    )


def lines_after(before, picture, dt=FRAME):
    return standing_lines(before, picture, dt, picture.shape[1] / 320)


def cleared(pictures, dt=FRAME, least_time=ENOUGH) -> np.ndarray:
    """Return the last of some pictures without what has stood still in all of them."""
    lines = None
    for picture in pictures:
        lines = lines_after(lines, picture, dt)
    return without_standing_lines(picture, lines, least_time)


def dive(draw, frames=6, **ground) -> list[np.ndarray]:
    """Return pictures of a ground that moves, with something drawn on each."""
    pictures = [ground_of(frame, **ground) for frame in range(frames)]
    for frame, picture in enumerate(pictures):
        draw(picture, frame)
    return pictures


def crosshair(level):
    def draw(picture, _frame):
        height, width = picture.shape
        picture[height // 2] = level
        picture[:, width // 2] = level

    return draw


def nothing(_picture, _frame) -> None:
    """Draw nothing."""


@pytest.mark.parametrize("level", [BRIGHT, DARK])
@pytest.mark.parametrize("size", [(240, 320), (180, 320), (480, 640)])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_a_crosshair_over_moving_ground_is_taken_out(level, size, dtype):
    pictures = [picture.astype(dtype) for picture in dive(crosshair(level), size=size)]
    found, bare = cleared(pictures), ground_of(5, size)
    assert found.dtype == dtype
    on_line = pictures[-1] != bare
    assert np.abs(found.astype(float) - bare)[on_line].mean() < 20.0
    np.testing.assert_array_equal(found[~on_line], bare[~on_line])


def test_lines_are_left_until_they_have_stood_still_for_long_enough():
    pictures = dive(crosshair(BRIGHT))
    assert cleared(pictures[:1]) is pictures[0]
    assert cleared(pictures, least_time=0.5) is pictures[-1]


@pytest.mark.parametrize(("count", "is_removed"), [(2, False), (3, False), (4, True)])
def test_overlays_are_removed_only_after_four_frames_even_if_far_apart(count, is_removed):
    pictures = dive(crosshair(BRIGHT))[:count]
    assert (cleared(pictures, dt=1.0, least_time=0.1) is not pictures[-1]) == is_removed


def test_ground_that_moves_is_left_as_it_is():
    pictures = dive(nothing)
    assert cleared(pictures) is pictures[-1]


def test_a_picture_that_stands_still_is_left_as_it_is():
    pictures = dive(crosshair(BRIGHT), speed=0)
    assert cleared(pictures) is pictures[-1]


def test_no_line_is_removed_from_a_picture_full_of_thin_lines():
    def striped(picture, _frame):
        picture[:, ::6] = BRIGHT

    pictures = dive(striped)
    assert cleared(pictures) is pictures[-1]


def test_marks_on_a_crosshair_do_not_hide_it():
    def marked(picture, frame):
        crosshair(BRIGHT)(picture, frame)
        for row in range(12, len(picture), 24):
            picture[row, 156:165] = BRIGHT

    pictures = dive(marked)
    between = np.arange(240) % 24 != 12
    assert (cleared(pictures)[between, 160] < BRIGHT).all()


def moving(picture, frame) -> None:
    picture[:, 100 + frame] = BRIGHT


def oblique(picture, _frame) -> None:
    rows = np.arange(len(picture))
    picture[rows, 100 + rows // 6] = BRIGHT


def thick(picture, _frame) -> None:
    picture[:, 100:104] = BRIGHT


def short(picture, _frame) -> None:
    picture[100:130, 100] = BRIGHT


def stepped(picture, _frame) -> None:
    picture[:, 100:] = BRIGHT


@pytest.mark.parametrize("draw", [moving, oblique, thick, short, stepped])
def test_a_possible_cable_is_not_removed(draw):
    pictures = dive(draw)
    np.testing.assert_array_equal(cleared(pictures), pictures[-1])


def test_a_line_that_was_hidden_for_a_frame_is_known_again_sooner():
    pictures = dive(crosshair(BRIGHT), frames=12)
    pictures[9] = ground_of(9)
    assert cleared(pictures, least_time=0.1) is not pictures[-1]
    assert cleared(pictures[9:], least_time=0.1) is pictures[-1]


def test_a_line_that_is_gone_is_forgotten():
    pictures = dive(crosshair(BRIGHT), frames=6)
    pictures += [ground_of(frame) for frame in range(6, 12)]
    assert cleared(pictures) is pictures[-1]


def test_pictures_of_another_size_restart_the_search_for_overlays():
    lines = None
    for picture in dive(crosshair(BRIGHT)):
        lines = lines_after(lines, picture)
    smaller = ground_of(0, (180, 240))
    assert without_standing_lines(smaller, lines_after(lines, smaller), ENOUGH) is smaller


def test_lines_kept_of_earlier_pictures_are_not_changed_in_place():
    first, second = dive(crosshair(BRIGHT), frames=2)
    lines = lines_after(lines_after(None, first, 0.0), first)
    kept = lines.down.copy(), lines.across.copy()
    lines_after(lines, second)
    np.testing.assert_array_equal(lines.down, kept[0])
    np.testing.assert_array_equal(lines.across, kept[1])


@pytest.mark.parametrize(("width", "has_room"), [(160, False), (240, True), (320, True)])
def test_in_a_narrow_picture_a_line_is_as_thin_as_a_cable(width, has_room):
    assert (lines_after(None, np.zeros((120, width), np.uint8)) is not None) is has_room
