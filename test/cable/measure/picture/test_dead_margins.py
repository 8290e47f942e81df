from __future__ import annotations

import cv2
import numpy as np
import pytest

from cable_tracker.cable.measure.picture.dead_margins import (
    BESIDE,
    dead_lines,
    without_dead_margins,
)


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


def test_what_is_written_on_a_bar_does_not_hide_it(live, rng):
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
