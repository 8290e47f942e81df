import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.contour.evolution import (
    EXTERIOR,
    INNER,
    INTERIOR,
    OUTER,
    ContourSettings,
    evolve,
    levels_of_mask,
)
from cable_tracker.errors import FrameError

PLAIN = ContourSettings()


def energy(image, mask):
    image = image.astype(np.float64)
    return sum(((side - side.mean()) ** 2).sum() for side in (image[mask], image[~mask]))


def worked_example():
    """12x12, inside 30 points of which 2 white, outside 114 of which 95 white."""
    mask = np.zeros((12, 12), bool)
    mask[3:8, 3:9] = True
    image = np.ones((12, 12), np.float32)
    image[3:10, 3:10] = 0.0
    image[3, 4] = image[3, 6] = 1.0
    return image, mask


def test_the_worked_example_holds_its_figures():
    image, mask = worked_example()
    assert (mask.sum(), image[mask].sum(), (~mask).sum(), image[~mask].sum()) == (30, 2, 114, 95)
    energies = [energy(image, mask)]
    for point in ((3, 4), (3, 6), (3, 9), (4, 9)):
        mask[point] ^= True
        energies.append(energy(image, mask))
    assert np.diff(energies) == pytest.approx([-0.874, -0.938, -0.705, -0.718], abs=5e-4)


@pytest.mark.parametrize("flooding", [True, False])
def test_the_worked_example_ends_as_in_the_thesis(flooding):
    image, mask = worked_example()
    contour = evolve(image, mask, ContourSettings(flooding=flooding), by_means=True)
    assert contour.mask.sum() == 47
    assert (contour.inside_mean, contour.outside_mean) == (0.0, 1.0)
    assert contour.iterations < PLAIN.iterations
    np.testing.assert_array_equal(contour.mask, image == 0.0)


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_the_energy_falls_with_every_iteration(seed, flooding):
    rng = np.random.default_rng(seed)
    image = rng.random((14, 17)).astype(np.float32)
    mask = np.zeros((14, 17), bool)
    mask[3:9, 4:13] = True
    contour = evolve(image, mask, ContourSettings(flooding=flooding), by_means=True)
    energies = [energy(image, mask)]
    for count in range(1, contour.iterations + 1):
        settings = ContourSettings(flooding=flooding, iterations=count)
        energies.append(energy(image, evolve(image, mask, settings, by_means=True).mask))
    # The last iteration finds nothing to switch.
    assert (np.diff(energies)[:-1] < 0.0).all()
    assert energies[-1] == energies[-2]
    np.testing.assert_array_equal(contour.levels, levels_of_mask(contour.mask))
    assert contour.inside_mean == pytest.approx(image[contour.mask].mean(), abs=1e-5)


@given(st.integers(0, 2**32 - 1))
def test_a_converged_contour_is_not_improved_by_any_single_point_beside_it(seed):
    rng = np.random.default_rng(seed)
    image = rng.random((10, 10)).astype(np.float32)
    mask = np.zeros((10, 10), bool)
    mask[2:7, 2:7] = True
    contour = evolve(image, mask, PLAIN, by_means=True)
    assert contour.iterations < PLAIN.iterations
    least = energy(image, contour.mask)
    for row, column in np.argwhere(np.abs(contour.levels) == 1):
        other = contour.mask
        other[row, column] ^= True
        if min(other.sum(), (~other).sum()) >= 2:
            assert energy(image, other) >= least - 1e-5


def test_with_ratios_what_is_connected_and_likelier_target_is_inside(draw_disc):
    target = draw_disc(60, 80, (40, 30), 15)
    apart = draw_disc(60, 80, (70, 50), 5)
    start = draw_disc(60, 80, (44, 33), 4)
    ratio = np.where(target | apart, 1.0, -1.0).astype(np.float32)
    np.testing.assert_array_equal(evolve(ratio, start, PLAIN, by_means=False).mask, target)


def test_without_flooding_an_iteration_moves_a_contour_by_a_pixel(draw_disc):
    target, start = draw_disc(60, 80, (40, 30), 20), draw_disc(60, 80, (40, 30), 5)
    ratio = np.where(target, 1.0, -1.0).astype(np.float32)
    contour = evolve(ratio, start, ContourSettings(flooding=False, iterations=5), by_means=False)
    assert contour.iterations == 5
    assert not (contour.mask & ~draw_disc(60, 80, (40, 30), 10.5)).any()


def test_the_regulariser_shuts_out_single_points(draw_disc):
    target = draw_disc(60, 80, (40, 30), 15)
    noise = np.random.default_rng(3).normal(0.0, 0.8, (60, 80))
    ratio = (np.where(target, 1.0, -1.0) + noise).astype(np.float32)
    start = draw_disc(60, 80, (40, 30), 12)
    settings = (ContourSettings(), ContourSettings(regulariser=0.6, balance=-1.0))
    rough, smooth = (evolve(ratio, start, each, by_means=False).mask for each in settings)
    assert (smooth ^ target).sum() < 0.6 * (rough ^ target).sum()


def test_no_region_is_emptied():
    nothing = np.full((20, 20), -1.0, np.float32)
    start = np.zeros((20, 20), bool)
    start[5:10, 5:10] = True
    assert evolve(nothing, start, PLAIN, by_means=False).mask.sum() == 2
    assert evolve(-nothing, start, PLAIN, by_means=False).mask.sum() == 398


def test_images_and_masks_that_cannot_evolve_are_refused():
    image, mask = worked_example()
    with pytest.raises(FrameError, match="cannot evolve"):
        evolve(image[:10], mask, PLAIN, by_means=True)
    with pytest.raises(FrameError, match="on either side"):
        evolve(image, np.zeros_like(mask), PLAIN, by_means=True)


def reference(mask):
    levels = np.where(mask, INTERIOR, EXTERIOR)
    for row, column in np.ndindex(mask.shape):
        for i, j in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)):
            inside_picture = 0 <= i < mask.shape[0] and 0 <= j < mask.shape[1]
            if inside_picture and mask[i, j] != mask[row, column]:
                levels[row, column] = INNER if mask[row, column] else OUTER
    return levels


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32 - 1))
def test_levels_are_those_of_the_definition(height, width, seed):
    mask = np.random.default_rng(seed).random((height, width)) < 0.5
    np.testing.assert_array_equal(levels_of_mask(mask), reference(mask))
