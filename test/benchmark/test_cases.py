import math

import numpy as np
import pytest

from cable_tracker.benchmark import cases
from cable_tracker.benchmark.cases import (
    FilterSteps,
    copy_cases,
    frame_cases,
    moment_of,
    points_of_a_cable,
    rival_cases,
    spacing_cases,
    step_cases,
    yardstick_case,
)
from cable_tracker.benchmark.footage import FrameLoop, footage
from cable_tracker.benchmark.round_robin import SECTIONS
from cable_tracker.cable.parameters.presets import preset


def test_every_step_of_both_presets_can_be_called_again_and_again(shown):
    for each in step_cases(shown):
        step = each.prepare()
        assert step() is not None
        assert step() is not None


def test_the_steps_of_a_frame_are_named_in_their_order(shown):
    for name, last in (("thesis", "evidence"), ("default", "measure")):
        names = list(FilterSteps(preset(name), shown).steps())
        assert names[0] == "working image"
        assert names.index("predict") < names.index("measure")
        assert names[-1] == last


def test_what_the_filter_reads_of_a_picture_is_worked_out_anew_at_every_call(shown):
    steps = FilterSteps(preset("default"), shown).picture_steps()
    assert steps
    kept = [(step(), step()) for step in steps.values()]
    assert any(first is not second for first, second in kept if not isinstance(first, float))


def test_the_grid_has_every_combination_the_fewest_particles_first(shown):
    grid = [each.label for each in frame_cases([shown, footage(2, (64, 48))], (500, 300))]
    assert len(grid) == len(set(grid)) == 2 * len(cases.TIMED_PRESETS) * 2
    assert [label.particles for label in grid[:2]] == [300, 500]


def test_rivals_are_baselines_and_libraries(shown):
    names = [each.label.name for each in rival_cases(shown)]
    assert names[:4] == ["hough", "segmentation", "lsd", "texture"]
    assert set(names[4:]) <= {"particles", "filterpy"}


def test_a_library_that_is_absent_is_left_out(shown, monkeypatch):
    monkeypatch.setattr(cases, "is_installed", lambda name: name == "filterpy")
    names = [each.label.name for each in rival_cases(shown)]
    assert "filterpy" in names
    assert "particles" not in names


def test_what_is_timed_goes_through_the_frames(shown):
    (first, *_) = frame_cases([shown], (20,))
    loop = first.prepare()
    assert isinstance(loop, FrameLoop)
    loop()
    assert loop.frames == 1


def test_half_the_spacing_is_twice_the_points(shown):
    assert points_of_a_cable(shown, 5.0) == pytest.approx(
        2 * points_of_a_cable(shown, 10.0), rel=0.1
    )
    amounts = [each.label.amount for each in spacing_cases(shown)]
    assert amounts[:4] == sorted(amounts[:4], reverse=True)


def test_points_do_not_depend_on_the_size_of_the_frame(shown):
    large = footage(len(shown.images), (640, 480))
    assert points_of_a_cable(large, 10.0) == pytest.approx(points_of_a_cable(shown, 10.0), rel=0.02)


def test_copies_name_their_bytes(shown, yardstick):
    frame, touched = copy_cases(yardstick, [shown])
    assert frame.label.amount == 320 * 240
    assert touched.label.amount == 4 * yardstick.pixels_touched()
    frame.prepare()()


def test_sections_are_known(shown, yardstick):
    all_of_them = [
        yardstick_case(yardstick),
        *copy_cases(yardstick, [shown]),
        *step_cases(shown),
        *rival_cases(shown),
        *spacing_cases(shown),
        *frame_cases([shown], (500,)),
    ]
    assert {each.label.section for each in all_of_them} <= set(SECTIONS)


def test_particles_are_about_the_cable(shown):
    particles = moment_of(preset("thesis"), shown, 3).particles
    mean = particles.weights @ particles.states
    assert math.isclose(float(np.sum(particles.weights)), 1.0)
    assert mean[0] == pytest.approx(shown.truths[2].distance, abs=10.0)
