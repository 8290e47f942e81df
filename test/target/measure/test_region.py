import numpy as np
import pytest

from cable_tracker.target.measure.region import NO_SCORE, HueModel, score_poses
from cable_tracker.target.model.template import template_of_mask


def hues(shape, weight=0.0):
    return HueModel(np.zeros(shape, np.uint16), np.array([1.0, 0.0]), weight)


def scores_of(mask, poses, weight=0.0):
    template = template_of_mask(mask, 60, 1.0)
    ratios = np.where(mask, 2.0, -1.0).astype(np.float32)
    states = np.zeros((len(poses), 6))
    states[:, :4] = poses
    return score_poses(
        ratios, states, template.inside, template.around, template.size, hues(mask.shape, weight)
    )


def test_the_true_pose_scores_best(draw):
    mask = draw(centre=(200, 100), axes=(30, 12), tilt=0)[1]
    true = (40.5, 19.5, 0.0, 0.0)
    others = [(48.0, 19.5, 0.0, 0.0), (40.5, 19.5, 0.3, 0.0), (40.5, 19.5, 0.0, 0.8)]
    scores = scores_of(mask, [true, *others])
    assert scores[0] == pytest.approx(3.0, abs=0.2)
    assert (scores[1:] < scores[0] - 0.2).all()


def test_beyond_the_picture_there_is_no_score(draw):
    assert scores_of(draw()[1], [(400.0, 0.0, 0.0, 0.0)]) == NO_SCORE


def test_hues_that_agree_add_their_weight(draw):
    mask = draw()[1]
    plain, weighted = (scores_of(mask, [(0.5, -0.5, 0.0, 0.0)], weight) for weight in (0.0, 1.5))
    assert weighted - plain == pytest.approx(1.5)
