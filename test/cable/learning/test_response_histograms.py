from __future__ import annotations

import numpy as np
import pytest
from measured_points import points, ratios_at

from cable_tracker.cable.learning.response_histograms import (
    ResponseHistograms,
    table_from_histograms,
)
from cable_tracker.cable.measure.borders.response_table import CLASSES, RATIO_LIMIT
from cable_tracker.errors import ParameterError


def histograms(rng, response, count=4000) -> ResponseHistograms:
    counted = ResponseHistograms()
    counted.add(
        points(
            rng.normal(response, 1.0, count),
            np.abs(rng.normal(0.0, 0.2, count)),
            rng.normal(response, 1.0, count),
        )
    )
    assert counted.edges.sum() == counted.contrasts.sum() == count
    return counted


def test_ratios_are_positive_on_borders_and_negative_elsewhere(rng):
    table = table_from_histograms([histograms(rng, 5.0)] * CLASSES, histograms(rng, 0.0), "test")
    border, background = ratios_at(points([5.0, 0.0], 0.0, [5.0, 0.0]), table)[:, 0]
    assert border > 2.0
    # Strays bound what speaks against a border, in either table.
    assert -4.7 < background < -2.0
    assert table.source == "test"
    assert np.abs(table.edges).max() <= RATIO_LIMIT
    assert np.abs(table.contrasts).max() <= RATIO_LIMIT


def test_equal_responses_on_borders_and_elsewhere_have_a_ratio_of_zero(rng):
    same = histograms(rng, 1.0)
    table = table_from_histograms([same] * CLASSES, same, "test")
    np.testing.assert_allclose(table.edges, 0.0, atol=1e-6)
    np.testing.assert_allclose(table.contrasts, 0.0, atol=1e-6)


@pytest.mark.parametrize("border", [True, False])
def test_a_table_from_an_empty_histogram_is_refused(rng, border):
    some, none = histograms(rng, 1.0), ResponseHistograms()
    with pytest.raises(ParameterError, match="nothing to learn"):
        table_from_histograms(*([[some], none] if border else [[none], some]), "test")


def test_a_class_that_was_never_met_looks_like_the_nearest(rng):
    borders = [ResponseHistograms() for _ in range(CLASSES)]
    borders[2] = histograms(rng, 3.0)
    borders[0] = histograms(rng, 1.5)
    table = table_from_histograms(borders, histograms(rng, 0.0), "test")
    np.testing.assert_array_equal(table.edges[3], table.edges[2])
    assert not np.array_equal(table.edges[0], table.edges[2])
