import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from map_pictures import ray_casting

DOWN = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
FOCAL_LENGTH = 300.0


def upright_tube(*, radius, height):
    skin = np.full((ray_casting.SIDE, ray_casting.SIDE), 0.3, np.float32)
    return ray_casting.Tube((0.0, 0.0, height), (0.0, 1.0, 0.0), radius, skin, 0.0)


def scene(tube, *lamps):
    flat = np.zeros((ray_casting.SIDE, ray_casting.SIDE), np.float32)
    return ray_casting.Scene(
        view=DOWN,
        focal_length=FOCAL_LENGTH,
        relief=flat,
        albedo=np.full_like(flat, 0.3),
        tube=tube,
        lamps=np.array([[*place, 1.0, 0.001] for place in lamps]),
        ambient=0.05,
        absorption=0.0,
        scattering=0.0,
        beam=0.0,
    )


LEFT_OF_IT = (-1.0, 0.0, 0.6)
ABOVE = (0.0, 0.0, 1.0)


@settings(max_examples=10, deadline=None)
@given(radius=st.floats(0.03, 0.2), height=st.floats(0.0, 0.4))
def test_a_cable_is_as_wide_as_its_silhouette(radius, height):
    _, cable = ray_casting.render_scene(scene(upright_tube(radius=radius, height=height), ABOVE))
    away = 1.0 - height
    if height >= radius:
        half = radius / math.sqrt(away**2 - radius**2)
    else:
        # The bottom hides the widest part of what is buried by more than its half.
        touched = radius / math.sqrt(away**2 - radius**2)
        lowest = 1.0 - math.sqrt(away**2 - radius**2) * math.cos(math.asin(radius / away))
        half = touched if lowest >= 0.0 else math.sqrt(radius**2 - height**2)
    assert cable.sum(1) == pytest.approx(2.0 * FOCAL_LENGTH * half, abs=2.0)


def test_the_shadow_lies_on_the_side_away_from_the_lamp():
    with_it, cable = ray_casting.render_scene(
        scene(upright_tube(radius=0.05, height=0.05), LEFT_OF_IT)
    )
    without_it, _ = ray_casting.render_scene(scene(None, LEFT_OF_IT))
    darker = np.flatnonzero(((with_it < 0.4 * without_it) & (cable == 0.0))[120])
    assert darker.size > 5
    assert darker.min() > 160
