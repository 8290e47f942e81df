"""Lines of a survey display: taken out while the ground moves behind them, and nothing else is."""

import numpy as np
import pytest

from cable_tracker.cable.measure.picture.burned_in_lines import (
    standing_lines,
    without_standing_lines,
)

FRAME = 0.04
ENOUGH = 0.04
BRIGHT, DARK = 235, 0


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


def test_of_frames_far_apart_as_many_are_needed():
    pictures = dive(crosshair(BRIGHT))
    for count, is_enough in ((2, False), (3, False), (4, True)):
        found = cleared(pictures[:count], dt=1.0, least_time=0.1)
        assert (found is not pictures[count - 1]) == is_enough


def test_ground_that_moves_is_left_as_it_is():
    pictures = dive(nothing)
    assert cleared(pictures) is pictures[-1]


def test_a_picture_that_stands_still_is_left_as_it_is():
    pictures = dive(crosshair(BRIGHT), speed=0)
    assert cleared(pictures) is pictures[-1]


def test_where_thin_lines_are_everywhere_none_is_taken_out():
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
def test_what_may_be_a_cable_is_left(draw):
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


def test_pictures_of_another_size_begin_anew():
    lines = None
    for picture in dive(crosshair(BRIGHT)):
        lines = lines_after(lines, picture)
    smaller = ground_of(0, (180, 240))
    assert without_standing_lines(smaller, lines_after(lines, smaller), ENOUGH) is smaller


def test_what_was_kept_before_a_picture_does_not_change_with_it():
    first, second = dive(crosshair(BRIGHT), frames=2)
    lines = lines_after(lines_after(None, first, 0.0), first)
    kept = lines.down.copy(), lines.across.copy()
    lines_after(lines, second)
    np.testing.assert_array_equal(lines.down, kept[0])
    np.testing.assert_array_equal(lines.across, kept[1])


@pytest.mark.parametrize(("width", "has_room"), [(160, False), (240, True), (320, True)])
def test_in_a_narrow_picture_a_line_is_as_thin_as_a_cable(width, has_room):
    assert (lines_after(None, np.zeros((120, width), np.uint8)) is not None) is has_room
