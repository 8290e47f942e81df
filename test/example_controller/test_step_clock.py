import pytest

from cable_tracker.example_controller.step_clock import LONGEST_STEP, StepClock


def test_time_adds_up_from_step_to_step():
    clock = StepClock()
    assert [clock.advance(time) for time in (5.0, 5.25, 5.5)] == [0.0, 0.25, 0.25]
    assert clock.now == 0.5


def test_what_a_clock_is_set_back_by_does_not_count():
    clock = StepClock()
    steps = [
        (clock.advance(time), clock.was_set_back) for time in (1000.0, 1000.5, 10.0, 10.25, 10.25)
    ]
    assert steps == [(0.0, False), (0.5, False), (0.0, True), (0.25, False), (0.0, False)]
    assert clock.now == 0.75


def test_a_long_gap_passes_but_is_not_integrated():
    clock = StepClock()
    clock.advance(0.0)
    assert clock.advance(30.0) == LONGEST_STEP
    assert clock.now == pytest.approx(30.0)
