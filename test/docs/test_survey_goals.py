import math
from dataclasses import replace

import numpy as np
import pytest
from survey_goals import SeaBed, crossings_of

from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings
from cable_tracker.simulation.rendering.clutter import Streak
from cable_tracker.simulation.rendering.laid_cable import Bend, Tube

BENT = Tube(0.08, (Bend(1.0, 0.2, 0.3),))


def rope(angle: float, beside: float = 0.0, half_length: float = 30.0) -> Streak:
    """Return a rope whose middle lies 5 m along the cable, turned from it [deg], [radii]."""
    (point,), (direction,) = BENT.axis(np.array([5.0]))
    turn = math.atan2(-direction[0], direction[1]) + math.radians(angle)
    p, q = point[:2] / BENT.radius
    return Streak(
        p + beside, q, turn, half_width=0.1, half_length=half_length, tone=0.2, opacity=0.8,
        twist=0.0, on_top=True,
    )  # fmt: skip


@pytest.mark.parametrize("angle", [40.0, -70.0])
def test_a_rope_meets_the_bent_cable_where_that_runs(angle):
    lying = rope(angle)
    away = -7.0 * math.sin(lying.angle), 7.0 * math.cos(lying.angle)
    shifted = replace(lying, p=lying.p + away[0], q=lying.q + away[1])
    assert crossings_of(BENT, shifted) == pytest.approx([5.0], abs=0.002)


def test_a_rope_that_ends_before_the_cable_or_runs_along_it_does_not_lie_across():
    assert crossings_of(BENT, rope(90.0, beside=12.0, half_length=6.0)).size == 0
    assert crossings_of(BENT, rope(5.0)).size == 0


def test_other_cables_are_among_the_lines_across_in_their_order():
    settings = SurveyDiveSettings(seed=3, cable_seed=4, length=60.0, crossings=(31.0,))
    across = SeaBed(settings).lines_across()
    assert 31.0 in across and len(across) > 1
    assert (np.diff(across) >= 0.0).all()
