from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.example_controller.cable_memory import (
    FEWEST,
    REMEMBERED,
    CableMemory,
    Pose,
    RememberedLine,
)
from cable_tracker.example_controller.line_of_sight import CableLine


def memory_of(line: RememberedLine, poses: list[Pose]) -> CableMemory:
    memory = CableMemory()
    for pose in poses:
        memory.add(line.relative_to(pose), pose)
    return memory


def walk(direction: float, count: int, step: float = 0.05) -> list[Pose]:
    return [
        Pose(step * k * math.cos(direction), step * k * math.sin(direction), direction)
        for k in range(count)
    ]


def test_a_few_sightings_are_no_line():
    line = RememberedLine(0.0, 0.3, 0.0)
    assert memory_of(line, walk(0.0, FEWEST - 1)).line() is None
    assert memory_of(line, walk(0.0, FEWEST)).line() is not None


@given(st.floats(-3.0, 3.0), st.floats(-1.0, 1.0), st.floats(-0.8, 0.8))
def test_a_straight_cable_is_remembered_as_it_was_seen(direction, aside, turned):
    left = (-math.sin(direction) * aside, math.cos(direction) * aside)
    line = RememberedLine(*left, direction)
    poses = [Pose(each.x, each.y, direction + turned) for each in walk(direction, 20)]
    remembered = memory_of(line, poses).line()
    assert remembered is not None
    here = Pose(3.0 * math.cos(direction), 3.0 * math.sin(direction), direction + turned)
    seen, expected = remembered.relative_to(here), line.relative_to(here)
    assert seen.offset == pytest.approx(expected.offset, abs=1e-9)
    assert seen.heading == pytest.approx(expected.heading, abs=1e-9)


def test_the_way_is_that_of_the_sightings_that_count():
    assert CableMemory().way == 0.0
    line = RememberedLine(0.0, 0.3, 0.0)
    assert memory_of(line, walk(0.0, 21)).way == pytest.approx(1.0)
    assert memory_of(line, walk(0.0, 201)).way == pytest.approx(REMEMBERED)


def test_a_line_to_the_left_is_seen_to_the_left():
    line = RememberedLine(0.0, 1.0, 0.0)
    assert line.relative_to(Pose(0.0, 0.0, 0.0)) == CableLine(1.0, 0.0)
    assert line.relative_to(Pose(0.0, 0.0, 0.0), shift=0.5) == CableLine(1.5, 0.0)
    assert line.relative_to(Pose(5.0, 0.0, 0.2)).heading == pytest.approx(-0.2)


@pytest.mark.parametrize("turned", [80.0, 100.0, 180.0, -120.0])
def test_a_vehicle_that_is_turned_away_knows_on_which_side_the_line_is(turned):
    yaw = math.radians(turned)
    seen = RememberedLine(0.0, 0.0, 0.0).relative_to(Pose(0.0, -1.0, yaw))
    assert seen.offset == pytest.approx(1.0 / math.cos(yaw))
    assert seen.offset * math.cos(seen.heading) == pytest.approx(1.0)


def test_a_line_right_across_has_an_offset():
    seen = RememberedLine(0.0, 0.0, 0.0).relative_to(Pose(0.0, -1.0, math.pi / 2))
    assert abs(seen.offset) == pytest.approx(10.0)


def test_the_last_sightings_do_not_turn_the_line_away():
    line = RememberedLine(0.0, 0.0, 0.0)
    poses = walk(0.0, 40)
    memory = memory_of(line, poses)
    for pose in walk(0.0, 45)[40:]:
        memory.add(CableLine(0.6, 0.7), pose)
    remembered = memory.line()
    assert remembered is not None
    assert remembered.direction == pytest.approx(0.0, abs=0.01)
    assert abs(remembered.relative_to(poses[-1]).offset) < 0.01


def test_only_the_last_metres_count():
    memory = memory_of(RememberedLine(0.0, 0.0, 0.0), walk(0.0, 20))
    later = [Pose(1.0 + REMEMBERED + pose.x, 0.0, 0.0) for pose in walk(0.0, 20)]
    for pose in later:
        memory.add(CableLine(1.0, 0.0), pose)
    remembered = memory.line()
    assert remembered is not None
    assert remembered.relative_to(later[-1]).offset == pytest.approx(1.0)


def on_a_circle(angle: float, radius: float) -> Pose:
    """Return a pose on a circle to the left of the x axis, which it touches at the origin."""
    return Pose(radius * math.sin(angle), radius * (1 - math.cos(angle)), angle)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_bend_goes_on_where_the_cable_is_not_seen(side):
    radius = 25.0 * side
    memory = CableMemory()
    for step in range(100):
        memory.add(CableLine(0.0, 0.0), on_a_circle(0.05 * step / radius, radius))
    line = memory.line()
    assert line is not None
    assert line.curvature == pytest.approx(1 / radius, rel=0.05)
    later = on_a_circle((5.0 + 4.0) / radius, radius)
    assert abs(line.relative_to(later).offset) < 0.05
    assert abs(line.relative_to(later).heading) < 0.03


def test_a_vehicle_that_hovers_remembers_little():
    line = RememberedLine(0.0, 0.0, 0.0)
    memory = memory_of(line, [*walk(0.0, FEWEST), *[Pose(0.05 * FEWEST, 0.0, 0.0)] * 1000])
    assert len(memory._observations) <= FEWEST + 2
    assert memory.line() is not None
