from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.cable.model.geometry import states_in_chart
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.border_lines import EdgePoints


def errors_between(found: CableState, truth: CableState) -> np.ndarray:
    """Found minus true d, alpha, w, beta [px, deg], also across the wrap."""
    chart = states_in_chart(found.to_array()[None, :], truth.angle)[0, :4]
    difference = chart - truth.to_array()[:4]
    difference[[1, 3]] = np.rad2deg(difference[[1, 3]])
    return difference


def points_along(angle: float, offset: float, start=-100.0, end=100.0, contrast=6.0) -> EdgePoints:
    """Edge points, one a pixel, of a line whose normal points to the brighter side."""
    along = np.arange(start, end)[:, None]
    normal = np.array([np.cos(angle), np.sin(angle)])
    up = np.array([-np.sin(angle), np.cos(angle)])
    count = len(along)
    return EdgePoints(offset * normal + along * up, np.full(count, angle), np.full(count, contrast))


@pytest.fixture
def draw_strip(draw_strip: Callable[..., Image]) -> Callable[..., Image]:
    """Draw strips of a lower contrast than elsewhere."""
    return partial(draw_strip, strip=180.0, ground=70.0)


@pytest.fixture
def errors() -> Callable[..., np.ndarray]:
    return errors_between


@pytest.fixture
def edge_line() -> Callable[..., EdgePoints]:
    return points_along


@pytest.fixture
def join() -> Callable[..., EdgePoints]:
    """Put several sets of edge points together."""

    def joined(*parts: EdgePoints) -> EdgePoints:
        return EdgePoints(
            np.concatenate([part.positions for part in parts]),
            np.concatenate([part.directions for part in parts]),
            np.concatenate([part.contrasts for part in parts]),
        )

    return joined


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(4711)
