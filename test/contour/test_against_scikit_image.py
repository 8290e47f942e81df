import numpy as np
import pytest

from cable_tracker.contour.evolution import ContourSettings, evolve

MISSING = "SCIKIT-IMAGE IS MISSING: nothing is compared with it; run `pip install -e '.[dev]'`"
segmentation = pytest.importorskip("skimage.segmentation", reason=MISSING)


def overlap(one, two):
    return (one & two).sum() / (one | two).sum()


def test_a_fast_contour_is_as_good_as_that_of_morphological_chan_vese(draw_disc):
    truth = draw_disc(80, 110, (50, 42), 24)
    noise = np.random.default_rng(4).normal(0.0, 0.1, truth.shape)
    image = (np.where(truth, 0.7, 0.35) + noise).astype(np.float32)
    start = np.zeros_like(truth)
    start[20:60, 30:80] = True
    ours = evolve(image, start, ContourSettings(regulariser=0.05, balance=-1.0), by_means=True)
    theirs = segmentation.morphological_chan_vese(image, 40, init_level_set=start, smoothing=1)
    assert overlap(ours.mask, truth) > 0.97
    assert overlap(ours.mask, truth) >= overlap(theirs > 0, truth) - 0.005
