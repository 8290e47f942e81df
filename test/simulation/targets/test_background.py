from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.simulation.targets.background import random_background


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_panorama_goes_on_as_far_as_the_camera_looks_beside_its_first_view(side):
    size, farthest = (960, 96), 210.0
    background = random_background(size, np.random.default_rng(1), margin=farthest)
    even = replace(background, glitter=np.zeros_like(background.glitter))
    view = even.view(size, (side * farthest, 0.0), 0.0)
    # Beyond its end the outermost column would be repeated.
    assert np.abs(np.diff(view, axis=1)).max(axis=(0, 2)).min() > 0.0


def test_a_picture_that_is_recorded_stays_as_it_is():
    background = random_background((64, 48), np.random.default_rng(1), margin=0.0)
    picture = np.full((48, 64, 3), 90.0, np.float32)
    recorded = background.recorded(picture, 1.0, np.random.default_rng(2))
    assert (picture == 90.0).all()
    assert recorded.max() > 110
