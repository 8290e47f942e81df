from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cable_tracker.cable.model.geometry import (
    Borders,
    borders_cross_inside,
    foot_point,
    lengths_inside,
    middle_inside,
    points_on_lines,
    project_borders,
    relative_direction,
    segment_inside,
    states_from_borders,
    states_in_chart,
    wrap_angle,
    wrap_angles,
    wrap_states,
    wrapped_estimate,
    wraps_between,
)

SIZE = (320, 240)
ANGLES = st.floats(-np.pi / 2, np.pi / 2)


@st.composite
def cables(draw) -> np.ndarray:
    """One state, shape (1, 8)."""
    return np.array(
        [
            [
                draw(st.floats(-400, 400)),
                draw(st.floats(-10, 10)),
                draw(st.floats(0.5, 300)),
                draw(st.floats(-1.2, 1.2)),
                draw(st.floats(-100, 100)),
                draw(st.floats(-3, 3)),
                draw(st.floats(-50, 50)),
                draw(st.floats(-1, 1)),
            ]
        ]
    )


def points_on(borders: Borders, side: int) -> np.ndarray:
    """Two points of the first cable's border, shape (2, 2)."""
    angle, offset = borders.angles[0, side], borders.offsets[0, side]
    along = np.array([[-50.0], [80.0]])
    return offset * np.array([np.cos(angle), np.sin(angle)]) + along * np.array(
        [-np.sin(angle), np.cos(angle)]
    )


def distance_to(borders: Borders, side: int, points: np.ndarray) -> np.ndarray:
    angle, offset = borders.angles[0, side], borders.offsets[0, side]
    return points @ [np.cos(angle), np.sin(angle)] - offset


def test_borders_of_an_upright_cable():
    borders = project_borders(np.array([[10.0, 0.0, 30.0, 0.0]]))
    np.testing.assert_allclose(borders.angles, [[0.0, 0.0]])
    np.testing.assert_allclose(borders.offsets, [[-5.0, 25.0]])


def test_borders_of_a_leaning_tapering_cable_worked_by_hand():
    # d = 20, alpha = 30 deg, w = 40, beta = 10 deg: the foot point is (17.32, 10), the points half
    # a width beside it are (0, 0) and (34.64, 20), and cos 10 deg = 0.984808.
    degree = np.pi / 180
    borders = project_borders(np.array([[20.0, 30 * degree, 40.0, 10 * degree]]))
    np.testing.assert_allclose(borders.angles, [[20 * degree, 40 * degree]])
    np.testing.assert_allclose(borders.offsets, [[0.0, 39.3923]], atol=1e-4)
    assert distance_to(borders, 0, np.array([0.0, 0.0])) == pytest.approx(0.0, abs=1e-9)
    assert distance_to(borders, 1, np.array([34.6410, 20.0])) == pytest.approx(0.0, abs=1e-4)


def test_a_positive_angle_leans_the_top_to_the_left():
    (bottom_x, bottom_y), (top_x, top_y) = segment_inside(0.2, 0.0, SIZE)
    assert top_y > bottom_y
    assert top_x < bottom_x


def test_borders_of_positive_skew_converge_upwards():
    borders = project_borders(np.array([[0.0, 0.0, 40.0, 0.1]]))
    (low_left, high_left), (low_right, high_right) = (
        segment_inside(borders.angles[0, side], borders.offsets[0, side], SIZE) for side in (0, 1)
    )
    assert 0 < high_right[0] - high_left[0] < low_right[0] - low_left[0]


@given(cables())
def test_borders_give_the_cable_back(states):
    np.testing.assert_allclose(
        states_from_borders(project_borders(states)), states[:, :4], rtol=1e-9, atol=1e-9
    )


@given(st.floats(-1e3, 1e3))
def test_wrapped_angles_are_in_the_half_open_interval_and_whole_half_turns_away(angle):
    wrapped = float(wrap_angles(np.array(angle)))
    assert -np.pi / 2 < wrapped <= np.pi / 2
    assert np.sin(wrapped - angle) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(np.pi / 2, np.pi / 2), (-np.pi / 2, np.pi / 2), (0.0, 0.0), (np.pi, 0.0), (-2.0, np.pi - 2)],
)
def test_the_ends_of_the_interval(angle, wrapped):
    assert float(wrap_angles(np.array(angle))) == pytest.approx(wrapped, abs=1e-12)


def test_a_wrap_lies_where_an_angle_makes_more_than_a_quarter_turn():
    found = wraps_between(np.deg2rad([60.0, 85.0, -85.0, -60.0, np.nan, 20.0]))
    np.testing.assert_array_equal(found, [False, True, False, False, False])


@given(cables(), st.integers(-3, 3))
def test_a_cable_written_the_other_way_round_has_the_same_borders(states, half_turns):
    turned = states.copy()
    turned[:, 1] += np.pi * half_turns
    if half_turns % 2:
        turned[:, [0, 3, 4, 7]] *= -1
    before, after = project_borders(states), project_borders(turned)
    for side in (0, 1):
        other = 1 - side if half_turns % 2 else side
        distances = distance_to(after, other, points_on(before, side))
        np.testing.assert_allclose(distances, 0.0, atol=1e-8)
    once, again = wrap_states(states), wrap_states(turned)
    apart = np.abs(once[0, 1] - again[0, 1])
    if apart < 1:  # Beside the wrap rounding may write a line either way.
        np.testing.assert_allclose(again, once, atol=1e-8)


@given(cables())
def test_wrapping_keeps_what_is_wrapped(states):
    once = wrap_states(states)
    others = [0, 2, 3, 4, 5, 6, 7]
    np.testing.assert_array_equal(wrap_states(once)[:, others], once[:, others])
    assert -np.pi / 2 < once[0, 1] <= np.pi / 2
    assert once[0, 2] == states[0, 2]
    assert once[0, 5] == states[0, 5]


@given(cables(), ANGLES)
def test_in_a_chart_angles_are_near_its_centre_and_the_line_is_the_same(states, reference):
    chart = states_in_chart(states, reference)
    assert abs(chart[0, 1] - reference) <= np.pi / 2 + 1e-9
    back, wanted = wrap_states(chart), wrap_states(states)
    if abs(back[0, 1] - wanted[0, 1]) < 1:
        np.testing.assert_allclose(back, wanted, atol=1e-8)


def test_the_states_given_are_not_changed():
    states = np.array([[10.0, 3.0, 20.0, 0.1, 1.0, 0.1, 2.0, 0.05]])
    before = states.copy()
    wrap_states(states)
    states_in_chart(states, 1.0)
    np.testing.assert_array_equal(states, before)


def test_points_on_lines_are_counted_upwards_from_the_foot_points():
    angles, offsets = np.array([[0.0, np.pi / 2]]), np.array([[20.0, -10.0]])
    points = points_on_lines(angles, offsets, np.array([0.0, 5.0, -7.0]))
    assert points.shape == (1, 2, 3, 2)
    np.testing.assert_allclose(points[0, 0], [[20, 0], [20, 5], [20, -7]], atol=1e-12)
    np.testing.assert_allclose(points[0, 1], [[0, -10], [-5, -10], [7, -10]], atol=1e-12)


@given(ANGLES, st.floats(-300, 300))
def test_a_clipped_line_ends_on_the_edge_of_the_image(angle, offset):
    segment = segment_inside(angle, offset, SIZE)
    if segment is None:
        # Then the corners lie all on one side.
        corners = np.array([[x, y] for x in (-159.5, 159.5) for y in (-119.5, 119.5)])
        sides = corners @ [np.cos(angle), np.sin(angle)] - offset
        assert (sides >= -1e-6).all() or (sides <= 1e-6).all()
        return
    for x, y in segment:
        assert x * np.cos(angle) + y * np.sin(angle) == pytest.approx(offset, abs=1e-6)
        assert max(abs(x) / 159.5, abs(y) / 119.5) == pytest.approx(1.0, abs=1e-6)
    lower, upper = segment
    assert np.dot(np.subtract(upper, lower), [-np.sin(angle), np.cos(angle)]) > 0


def test_lines_along_the_axes_are_clipped():
    assert segment_inside(0.0, 20.0, SIZE) == ((20.0, -119.5), (20.0, 119.5))
    (right, _), (left, _) = segment_inside(np.pi / 2, 0.0, SIZE)
    assert (left, right) == pytest.approx((-159.5, 159.5))
    assert segment_inside(0.0, 160.0, SIZE) is None
    assert segment_inside(np.pi / 2, -120.0, SIZE) is None


@given(ANGLES, st.floats(-300, 300))
@example(0.0, 0.0)
@example(np.pi / 2, 10.0)
@example(0.0, 200.0)
def test_the_length_inside_is_that_of_the_clipped_line(angle, offset):
    segment = segment_inside(angle, offset, SIZE)
    length = 0.0 if segment is None else math.dist(*segment)
    assert lengths_inside(np.array([angle]), np.array([offset]), SIZE) == pytest.approx([length])


def test_the_foot_point_is_the_nearest_to_the_centre():
    assert foot_point(-10.0, np.pi / 2) == pytest.approx((0.0, -10.0), abs=1e-9)
    assert foot_point(10.0, np.pi / 6) == pytest.approx((8.660254, 5.0))


@pytest.mark.parametrize("turns", range(-3, 4))
def test_no_rounding_leaves_an_angle_outside_the_range(turns):
    right = np.pi / 2 + turns * np.pi
    for angle in (np.nextafter(right, -100.0), right, np.nextafter(right, 100.0)):
        wrapped = wrap_angles(np.array([angle]))[0]
        assert -np.pi / 2 < wrapped <= np.pi / 2
        assert wrapped == wrap_angle(angle)


@pytest.mark.parametrize("shape", [(3, 4), (8,), (2, 9), (2, 2, 8)])
def test_states_of_another_shape_are_refused_before_compiled_code_sees_them(shape):
    with pytest.raises(ValueError, match="shape"):
        states_in_chart(np.zeros(shape), 0.0)


@given(st.floats(-10, 10), ANGLES)
def test_a_direction_is_written_within_a_quarter_turn_of_its_reference(angle, reference):
    difference, sign = relative_direction(angle, reference)
    assert -np.pi / 2 <= difference <= np.pi / 2
    normals = np.array([[np.cos(a), np.sin(a)] for a in (angle, reference + difference)])
    np.testing.assert_allclose(sign * normals[0], normals[1], atol=1e-12)


@pytest.mark.parametrize(("turns", "sign"), [(-1, -1.0), (0, 1.0), (1, -1.0), (2, 1.0)])
def test_an_estimate_that_is_turned_round_has_its_covariances_turned_too(turns, sign):
    mean = np.array([20.0, 0.3 + turns * np.pi, 30.0, 0.1, 4.0, 0.1, 1.0, 0.03])
    wrapped, covariance = wrapped_estimate(mean, np.ones((8, 8)))
    np.testing.assert_allclose(wrapped[:4], [sign * 20.0, 0.3, 30.0, sign * 0.1])
    assert covariance[0, 1] == sign
    assert covariance[0, 3] == covariance[1, 2] == 1.0


def tapering(length: float, skew: float, angle: float = 0.0, distance: float = 0.0) -> np.ndarray:
    """A pose whose borders meet so far up the centreline [px], and turn by a skew [deg]."""
    width = 2.0 * length * math.tan(math.radians(skew))
    return np.array([distance, angle, width, math.radians(skew)])


def test_parallel_borders_and_those_that_meet_outside_the_picture_are_of_a_cable():
    assert not borders_cross_inside(np.array([0.0, 0.0, 20.0, 0.0]), SIZE)
    assert not borders_cross_inside(tapering(121.0, 20.0), SIZE)


def test_borders_that_meet_well_inside_the_picture_are_of_no_cable():
    assert borders_cross_inside(tapering(80.0, 3.0), SIZE)


def test_a_cable_may_vanish_towards_an_edge_of_the_picture():
    # The picture is 240 px high: tips up to 36 px from its edge are near enough.
    assert not borders_cross_inside(tapering(86.0, 3.0), SIZE)
    assert not borders_cross_inside(tapering(114.0, 3.0, angle=math.pi / 2), SIZE)


def test_a_wide_wedge_and_one_in_a_corner_are_no_cables_that_vanish():
    assert borders_cross_inside(tapering(86.0, 8.0), SIZE)
    assert borders_cross_inside(tapering(40.0, 3.0, distance=140.0), SIZE)


@given(
    skew=st.floats(1.0, 20.0),
    length=st.floats(10.0, 250.0),
    angle=ANGLES,
    distance=st.floats(-100.0, 100.0),
)
def test_a_half_turn_does_not_change_whether_borders_meet_inside(skew, length, angle, distance):
    pose = tapering(length, skew, angle, distance)
    turned = pose * [-1.0, 1.0, 1.0, -1.0] + [0.0, np.pi, 0.0, 0.0]
    found = borders_cross_inside(pose, SIZE)
    # Where a tip lies on a limit, rounding decides.
    near = borders_cross_inside(pose, (319.9, 239.9)) != borders_cross_inside(pose, (320.1, 240.1))
    assert near or borders_cross_inside(turned, SIZE) == found


def test_the_middle_of_a_line_is_that_of_what_is_in_view():
    np.testing.assert_allclose(middle_inside(0.0, 50.0, (320, 240)), [50.0, 0.0], atol=1e-9)
    assert middle_inside(0.0, 500.0, (320, 240)) is None
