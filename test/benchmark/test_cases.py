import math

import numpy as np
import pytest

from cable_tracker.benchmark import cases
from cable_tracker.benchmark.cases import (
    FilterSteps,
    moment_of,
    points_of_a_cable,
    rival_cases,
    spacing_cases,
)
from cable_tracker.benchmark.footage import footage
from cable_tracker.cable.parameters.presets import preset


def test_what_the_filter_reads_of_a_picture_is_worked_out_anew_at_every_call(shown):
    steps = FilterSteps(preset("default"), shown).picture_steps()
    assert steps
    kept = [(step(), step()) for step in steps.values()]
    assert any(first is not second for first, second in kept if not isinstance(first, float))


def test_a_library_that_is_absent_is_left_out(shown, monkeypatch):
    monkeypatch.setattr(cases, "is_installed", lambda name: name == "filterpy")
    names = [each.label.name for each in rival_cases(shown)]
    assert "filterpy" in names
    assert "particles" not in names


def test_half_the_spacing_is_twice_the_points(shown):
    assert points_of_a_cable(shown, 5.0) == pytest.approx(
        2 * points_of_a_cable(shown, 10.0), rel=0.1
    )
    amounts = [each.label.amount for each in spacing_cases(shown)]
    assert amounts[:4] == sorted(amounts[:4], reverse=True)


def test_points_do_not_depend_on_the_size_of_the_frame(shown):
    large = footage(len(shown.images), (640, 480))
    assert points_of_a_cable(large, 10.0) == pytest.approx(points_of_a_cable(shown, 10.0), rel=0.02)


def test_particles_are_about_the_cable(shown):
    particles = moment_of(preset("thesis"), shown, 3).particles
    mean = particles.weights @ particles.states
    assert math.isclose(float(np.sum(particles.weights)), 1.0)
    assert mean[0] == pytest.approx(shown.truths[2].distance, abs=10.0)
