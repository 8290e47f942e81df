import pytest

from cable_tracker.example_controller.step_clock import LATE, LONGEST_STEP, StepClock
from cable_tracker.tracking import succession


def test_time_adds_up_from_step_to_step():
    clock = StepClock()
    assert [clock.advance(time) for time in (5.0, 5.25, 5.5)] == [0.0, 0.25, 0.25]
    assert clock.now == 0.5


def test_the_step_clock_ignores_a_clock_that_is_set_back():
    clock = StepClock()
    steps = [
        (clock.advance(time), clock.was_set_back) for time in (1000.0, 1000.5, 10.0, 10.25, 10.25)
    ]
    assert steps == [(0.0, False), (0.5, False), (0.0, True), (0.25, False), (0.0, False)]
    assert clock.now == 0.75


def test_late_is_what_is_late_for_the_tracker():
    assert LATE == succession.LATE


@pytest.mark.parametrize("late", [0.04, LATE])
@pytest.mark.parametrize("start", [1000.0, 1.7e9])
def test_a_frame_that_was_overtaken_sets_no_clock_back_and_lets_time_stand_still(start, late):
    clock = StepClock()
    steps = []
    for time in (start, start + 0.5, start + 0.5 - late, start + 0.6):
        steps.append(clock.advance(time))
        assert not clock.was_set_back
    assert steps == pytest.approx([0.0, 0.5, 0.0, 0.1], abs=1e-6)
    assert clock.now == pytest.approx(0.6, abs=1e-6)


def test_a_long_gap_passes_but_is_not_integrated():
    clock = StepClock()
    clock.advance(0.0)
    assert clock.advance(30.0) == LONGEST_STEP
    assert clock.now == pytest.approx(30.0)
