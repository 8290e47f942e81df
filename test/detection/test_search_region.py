from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.search_region import SearchRegion

UPRIGHT = SearchRegion(CableState(10.0, 0.0, 30.0), distance=5.0, angle=0.1, width=6.0)


def states(*rows) -> np.ndarray:
    return np.array([[*row, 0.0, 0.0, 0.0, 0.0] for row in rows])


def test_only_cables_in_the_box_are_admitted():
    inside = UPRIGHT.admits(
        states(
            (10, 0.0, 30, 0), (14.9, 0.09, 35.9, 0), (15.1, 0.0, 30, 0),
            (10, 0.11, 30, 0), (10, 0.0, 36.1, 0), (10, 0.0, 23.9, 0),
        )
    )  # fmt: skip
    np.testing.assert_array_equal(inside, [True, True, False, False, False, False])


def test_a_cable_across_the_wrap_is_admitted_with_its_distance_turned():
    region = SearchRegion(CableState(40.0, np.deg2rad(89.0), 30.0), 5.0, np.deg2rad(4.0), 5.0)
    other_side = np.deg2rad(-89.0)
    inside = region.admits(states((-40, other_side, 30, 0), (40, other_side, 30, 0)))
    np.testing.assert_array_equal(inside, [True, False])


def test_the_cover_widens_away_from_the_foot_point():
    # Half the largest width and the largest distance: 18 + 5 px about x = 10 at the foot point.
    points = np.array([[32.9, 0.0], [33.1, 0.0], [-12.9, 0.0], [-13.1, 0.0], [42.9, 100.0]])
    np.testing.assert_array_equal(UPRIGHT.covers(points), [True, False, True, False, True])


@given(
    distance=st.floats(-5, 5),
    angle=st.floats(-0.1, 0.1),
    width=st.floats(-6, 6),
    along=st.floats(-90, 90),
)
def test_the_borders_of_every_admitted_upright_cable_are_covered(distance, angle, width, along):
    d, half = 10.0 + distance, (30.0 + width) / 2
    normal, up = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    points = np.array([(d - half) * normal + along * up, (d + half) * normal + along * up])
    # The foot point of a turned cable is not that of the expected one: a pixel is allowed.
    wider = SearchRegion(UPRIGHT.state, UPRIGHT.distance + 1.0, UPRIGHT.angle, UPRIGHT.width)
    assert wider.covers(points).all()


def test_scaling_leaves_the_angle_alone():
    scaled = UPRIGHT.scaled(0.25)
    assert scaled == SearchRegion(CableState(2.5, 0.0, 7.5), 1.25, 0.1, 1.5)
