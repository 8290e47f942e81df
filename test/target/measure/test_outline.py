import numpy as np
import pytest

from cable_tracker.target.measure.outline import find_outline
from cable_tracker.target.model.template import template_of_mask
from cable_tracker.target.parameters.parameters import TargetParameters

PARAMETERS = TargetParameters(contour_regulariser=0.3, contour_iterations=12)


def outline_of(mask, pose, softness=0.1):
    ratios = np.where(mask, 2.0, -2.0).astype(np.float32)
    template = template_of_mask(mask, 60, 1.0)
    return find_outline(ratios, np.array([*pose, 0.0, 0.0]), template, softness, PARAMETERS)


def test_the_outline_is_that_of_the_target_though_the_pose_is_not_quite(draw):
    mask = draw(centre=(200, 100))[1]
    outline = outline_of(mask, (45.0, 16.0, 0.05, 0.1))
    found = outline.in_picture(mask.shape)
    assert (found & mask).sum() / (found | mask).sum() > 0.9
    assert outline.overlap < 0.9


def test_a_hard_prior_keeps_the_shape_where_it_is(draw):
    mask = draw(centre=(200, 100))[1]
    outline = outline_of(mask, (47.0, 19.5, 0.0, 0.0), softness=0.005)
    assert outline.overlap > 0.85


def test_beyond_the_picture_there_is_none(draw):
    assert outline_of(draw()[1], (500.0, 0.0, 0.0, 0.0)) is None


def test_a_target_at_the_border_touches_it(draw):
    mask = draw(centre=(5, 100))[1]
    rows, columns = np.nonzero(mask)
    pose = (columns.mean() - 159.5, 119.5 - rows.mean(), 0.0, 0.0)
    outline = outline_of(mask, pose)
    assert outline.touches_border(mask.shape)
    assert outline.box[0] == 0.0
    assert outline.area == pytest.approx(mask.sum(), rel=0.1)
