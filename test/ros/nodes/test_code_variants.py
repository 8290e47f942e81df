from __future__ import annotations

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.ros.nodes.code_variants import few_particles, variant_of


def test_words_choose_the_code_and_numbers_do_not() -> None:
    default = TrackerParameters()
    assert variant_of(TrackerParameters(particle_count=70, seed=3)) == variant_of(default)
    assert variant_of(TrackerParameters(filter="bootstrap")) != variant_of(default)
    assert variant_of(TrackerParameters(detector="none")) != variant_of(default)


def test_few_particles_stay_few() -> None:
    assert few_particles(TrackerParameters(particle_count=50)).particle_count == 50
    assert few_particles(TrackerParameters(particle_count=5000)).particle_count < 1000
