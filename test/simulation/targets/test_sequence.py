import numpy as np
import pytest

from cable_tracker.errors import ParameterError
from cable_tracker.simulation.targets.scenarios import TARGET_SCENARIOS
from cable_tracker.simulation.targets.sequence import simulate_target


def frames(name, seed=3, count=12, **options):
    return list(simulate_target(name, seed, count, **options))


def test_the_same_seed_gives_the_same_frames():
    for one, two in zip(frames("diver", count=3), frames("diver", count=3), strict=True):
        np.testing.assert_array_equal(one.image, two.image)
        np.testing.assert_array_equal(one.mask, two.mask)


def test_another_seed_gives_others():
    assert (frames("buoy", 1, 1)[0].image != frames("buoy", 2, 1)[0].image).any()


@pytest.mark.parametrize("name", sorted(set(TARGET_SCENARIOS) - {"nothing", "low_contrast"}))
def test_what_the_mask_covers_differs_from_what_is_beside_it(name):
    frame = frames(name)[0]
    left, top, right, bottom = (int(side) for side in frame.box)
    near = np.zeros_like(frame.mask)
    near[max(top - 6, 0) : bottom + 6, max(left - 6, 0) : right + 6] = True
    inside = frame.image[frame.mask].mean(axis=0)
    beside = frame.image[near & ~frame.mask].mean(axis=0)
    assert np.abs(inside - beside).max() > 25.0


def test_what_leaves_comes_back_and_what_vanishes_does_not():
    leaving = [frame.box is not None for frame in frames("leaving", count=30)]
    assert leaving[0]
    assert leaving[-1]
    assert not all(leaving)
    vanishing = [frame.box is not None for frame in frames("vanishing", count=30)]
    assert vanishing[0]
    assert not any(vanishing[10:])
    assert not any(frame.box for frame in frames("nothing"))


def test_stalks_hide_the_target():
    run = frames("occlusion", count=75)
    assert run[0].box is not None
    assert run[-1].box is not None
    areas = [frame.mask.sum() for frame in run]
    assert min(areas) < 0.5 * areas[0]


def test_twins_never_cover_the_same_pixel_and_change_sides():
    run = frames("crossing", count=30)
    assert not any((frame.mask & frame.twin_mask).any() for frame in run)
    sides = [np.sign(frame.box[0] - frame.twin_box[0]) for frame in (run[0], run[-1])]
    assert sides[0] == -sides[1]


def test_larger_frames_show_the_same_larger():
    small, large = frames("buoy", count=1)[0], frames("buoy", count=1, size=(640, 480))[0]
    assert large.image.shape == (480, 640, 3)
    assert large.mask.sum() == pytest.approx(4 * small.mask.sum(), rel=0.1)


def test_an_unknown_scenario_is_refused():
    with pytest.raises(ParameterError, match="submarine"):
        frames("submarine")
