from __future__ import annotations

import numpy as np
import pytest
from measured_points import points, ratios_at
from plain_images import plain_image

from cable_tracker.cable.learning.response_counts import (
    ResponseCounts,
    border_strength,
    strength_class,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.borders.response_table import CLASSES
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import ParameterError

SIZE = (160, 120)
CABLES = [
    CableState(12.0, 0.2, 24.0, 0.03),
    CableState(-30.0, -0.5, 16.0),
    CableState(0.0, 1.5, 30.0, -0.05),
    CableState(20.0, 0.9, 20.0),
]


@pytest.fixture
def learnt(draw_strip, noise_picture):
    def learn(strip=170.0, ground=90.0, seed=0) -> ResponseCounts:
        counts = ResponseCounts(np.random.default_rng(seed))
        for number, cable in enumerate(CABLES):
            picture = draw_strip(cable, SIZE, strip=strip, ground=ground).astype(np.float32)
            picture += noise_picture(number, SIZE, 6.0) - np.float32(110.0)
            counts.add(plain_image(picture), cable)
        return counts

    return learn


def ratios(table) -> np.ndarray:
    """On a bright cable: of a clear edge on its ridge, of nothing, of one with darkness behind."""
    looked_at = points([11.0, 0.0, 11.0], 0.0, [11.0, 0.0, -11.0])
    return ratios_at(looked_at, table)[:, CLASSES - 1]


@pytest.mark.parametrize(("strip", "ground"), [(170.0, 90.0), (90.0, 170.0)])
def test_edges_are_learnt_as_borders_whether_cables_are_bright_or_dark(learnt, strip, ground):
    counts = learnt(strip, ground)
    assert counts.frames == len(CABLES)
    edge, nothing, furrow = ratios(counts.table("strips"))
    assert edge > 1.0
    assert nothing < 0.0
    assert furrow < edge - 1.0


def test_a_learnt_table_prefers_the_true_place_of_an_unseen_cable(learnt, draw_strip, tmp_path):
    path = tmp_path / "table.json"
    learnt().table("strips").save(path)
    model = BorderLikelihoodRatio(TrackerParameters(response_table=str(path)))
    other = CableState(-10.0, -0.2, 28.0)
    states = np.array([other.to_array(), other.to_array() + np.array([15.0, *[0.0] * 7])])
    true, shifted = model.log_likelihoods(states, plain_image(draw_strip(other, SIZE)))
    assert true > 0.5
    assert true > shifted + 1.0


def test_the_same_frames_and_seed_give_the_same_table(learnt):
    first, again, other = (learnt(seed=seed).table("x") for seed in (3, 3, 4))
    np.testing.assert_array_equal(first.edges, again.edges)
    np.testing.assert_array_equal(first.contrasts, again.contrasts)
    assert (first.edges != other.edges).any()


def test_a_cable_outside_the_image_teaches_nothing(draw_strip):
    counts = ResponseCounts(np.random.default_rng(0))
    image = plain_image(draw_strip(CABLES[0], SIZE))
    counts.add(image, CableState(900.0, 0.0, 20.0))
    assert counts.frames == 0
    with pytest.raises(ParameterError, match="no labelled frame"):
        counts.table("nothing")


def test_the_strength_of_a_border_is_the_mean_of_its_upper_half():
    assert border_strength(np.array([5.0, -9.0, 3.0, 0.0], np.float32)) == pytest.approx(4.0)
    assert border_strength(np.array([1.0, 7.0, 3.0], np.float32)) == pytest.approx(5.0)
    classes = [strength_class(strength) for strength in (0.0, 1.19, 1.2, 2.0, 3.9, 99.0)]
    assert classes == [-1, -1, 0, 1, 2, 3]
