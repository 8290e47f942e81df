import numpy as np
import pytest

from cable_tracker.target.group import TargetGroup
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters

from .conftest import scene

STEP = 40_000_000


def test_two_of_one_kind_are_both_kept(draw):
    def both(number):
        left, _ = draw(centre=(90 + number, 120), axes=(16, 12), seed=number)
        right, mask = draw(centre=(230 - number, 120), axes=(16, 12), seed=number + 100)
        return np.where(mask[..., None], right, left)

    starts = [TargetStart.from_box(x - 16, 108, x + 17, 133) for x in (90, 230)]
    group = TargetGroup(2, TargetParameters())
    for number, start in enumerate(starts):
        group.initialise(number, start)
    for number in range(12):
        estimates = group.process(both(number), (number + 1) * STEP)
    assert [each.status.value for each in estimates] == ["TRACKING"] * 2
    assert estimates[0].state[0] == pytest.approx(101 - 159.5, abs=4.0)
    assert estimates[1].state[0] == pytest.approx(219 - 159.5, abs=4.0)


def pair(seed, size=(320, 240), columns=(90, 230)):
    """Two ellipses, at these of 320 columns, and the masks of both."""
    zoom = size[0] // 320
    drawn = [scene((x * zoom, 120 * zoom), (22 * zoom, 14 * zoom), size, seed) for x in columns]
    return np.where(drawn[1][1][..., None], drawn[1][0], drawn[0][0]), [mask for _, mask in drawn]


def places(estimates):
    assert [each.status.value for each in estimates] == ["TRACKING"] * 2
    return sorted(each.state[0] for each in estimates)


@pytest.mark.parametrize(
    ("size", "pause", "moved"), [((640, 480), 1, 0), ((320, 240), 150, -40), ((320, 240), 150, 40)]
)
def test_two_that_are_found_anew_are_not_the_same(size, pause, moved):
    group = TargetGroup(2, TargetParameters(detector="contours"))
    for number in range(1, 8):
        estimates = group.process(pair(number)[0], number * STEP)
    assert places(estimates) == pytest.approx([-70, 70], abs=5.0)
    zoom = size[0] / 320
    for number in range(8 + pause, 12 + pause):
        image, _ = pair(number, size, (90 + moved, 230 + moved))
        estimates = group.process(image, number * STEP)
        assert np.diff(sorted(each.state[0] for each in estimates)) > 100.0 * zoom
    expected = [(-70 + moved) * zoom, (70 + moved) * zoom]
    assert places(estimates) == pytest.approx(expected, abs=5.0 * zoom)


def test_what_is_marked_for_one_is_not_found_for_another():
    image, masks = pair(1)
    for column, mask in zip((90, 230), masks, strict=True):
        group = TargetGroup(2, TargetParameters(detector="contours"))
        group.initialise(1, TargetStart.from_box(column - 22, 106, column + 23, 135))
        estimates = group.process(image, STEP)
        row, own = int(119.5 - estimates[0].state[1]), int(159.5 + estimates[0].state[0])
        assert not mask[row, own]


def test_a_mark_does_not_keep_others_from_the_middle_of_the_picture():
    group = TargetGroup(2, TargetParameters(detector="contours"))
    left, mask = scene((60, 120))
    image = np.where(mask[..., None], left, scene((160, 120))[0])
    group.process(scene(None)[0], STEP)
    group.initialise(1, TargetStart.from_box(38, 106, 83, 135))
    assert group.process(image, 2 * STEP)[0].state[:2] == pytest.approx([0.0, 0.0], abs=3.0)


def test_a_panning_camera_does_not_swap_two_of_one_kind():
    # Where one was is where the other comes.
    columns, pan = np.array([105, 155]), 50
    group = TargetGroup(2, TargetParameters())
    for number, column in enumerate(columns):
        group.initialise(number, TargetStart.from_box(column - 22, 106, column + 23, 135))
    for number, step in enumerate([0, 0, 0, pan, pan, -pan, -pan, pan]):
        columns = columns + step
        homography = np.array([[1.0, 0.0, step], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        image, _ = pair(number, columns=tuple(columns.tolist()))
        estimates = group.process(image, (number + 1) * 5 * STEP, CameraMotion(homography))
        assert [each.status.value for each in estimates] == ["TRACKING"] * 2
        assert [each.state[0] for each in estimates] == pytest.approx(columns - 159.5, abs=5.0)


def test_a_turn_that_leaves_nothing_in_view_does_not_move_what_others_keep_away_from():
    away = CameraMotion(np.array([[0.0, 0.0, 277.0], [0.0, 1.0, 0.0], [-1.0 / 277.0, 0.0, 0.0]]))

    def states(motion):
        group = TargetGroup(2, TargetParameters())
        for number, column in enumerate((90, 230)):
            group.initialise(number, TargetStart.from_box(column - 22, 106, column + 23, 135))
        group.process(pair(0)[0], STEP)
        return [each.state for each in group.process(pair(1)[0], 2 * STEP, motion)]

    np.testing.assert_array_equal(states(away), states(None))


def test_after_the_last_seed_comes_the_first():
    group = TargetGroup(2, TargetParameters(seed=2**31 - 1))
    assert group.trackers[1].parameters.seed == 0
