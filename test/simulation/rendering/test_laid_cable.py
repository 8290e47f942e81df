import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.simulation.rendering.appearance import Skin
from cable_tracker.simulation.rendering.laid_cable import (
    Bend,
    BuriedStretch,
    LaidCable,
    Tube,
    random_bends,
)
from cable_tracker.simulation.rendering.seabed import make_cable

BENT = Tube(0.08, (Bend(0.05, 0.5, 0.3),))
CROSSING = Tube(0.06, (), (1.0, 2.0), 0.9)


@pytest.mark.parametrize("tube", [Tube(0.08), BENT, CROSSING], ids=["straight", "bent", "crossing"])
@given(x=st.floats(-0.4, 0.4), z=st.floats(0.6, 2.0), ahead=st.floats(-0.5, 1.5))
def test_lines_of_sight_to_the_silhouette_pass_at_one_radius(tube, x, z, ahead):
    points, _ = tube.axis(np.array([0.0]))
    eye = points[0] + (x, 0.0, z)
    borders = tube.silhouette(eye[None], np.array([[ahead]]))[0]
    approach = tube.closest_approach(eye, (borders - eye).reshape(2, 3).T)
    np.testing.assert_allclose(approach.p, [-1.0, 1.0], atol=2e-3)
    np.testing.assert_allclose((approach.q + approach.start) * tube.radius, ahead, atol=0.03)


def test_the_silhouette_lies_on_the_tube():
    along = np.linspace(-2, 2, 9)
    borders = BENT.silhouette(np.array([[0.3, 0.0, 1.5]]), along[None])[0]
    centres, _ = BENT.axis(along)
    np.testing.assert_allclose(np.linalg.norm(borders - centres, axis=-1), 0.08)


def test_the_top_is_hit_before_the_axis():
    """From behind and above, the top of the tube is met nearer than the axis below it."""
    ray = np.array([[0.0], [1.0], [-1.0]])
    eye = np.array([0.0, 0.0, 1.0])
    approach = Tube(0.1).closest_approach(eye, ray)
    assert approach.p[0] == pytest.approx(0.0, abs=1e-12)
    assert approach.q[0] * 0.1 == pytest.approx(1.0 - 0.07 - 0.1, abs=1e-9)


def test_directions_are_derivatives():
    along = np.array([1.0 - 1e-5, 1.0 + 1e-5])
    points, directions = BENT.axis(along)
    step = points[1] - points[0]
    np.testing.assert_allclose(step / np.linalg.norm(step), directions[0], atol=1e-5)


@given(st.integers(0, 1000))
def test_random_bends_are_gentle(seed):
    bends = random_bends(0.01, (10.0, 20.0), np.random.default_rng(seed))
    assert sum(bend.amplitude * bend.wavenumber**2 for bend in bends) <= 0.01 + 1e-12


def test_where_buried_stretches_overlap_nothing_is_seen_of_the_growth():
    tube = Tube(0.08)
    texture = make_cable(8, Skin(cover=1.0), np.random.default_rng(1))
    ahead = np.linspace(-0.5, 0.5, 101, dtype=np.float32)
    rays = np.stack(np.broadcast_arrays(np.float32(0.05), ahead, np.float32(-1.0)))[:, None]
    approach = tube.closest_approach(np.array([0.0, 1.0, 1.0]), rays)
    footprint = np.full(approach.p.shape, 0.1, np.float32)
    stretch, gap = BuriedStretch(-5.0, 5.0, 0.3), BuriedStretch(0.5, 1.5, 0.02)
    assert LaidCable(tube, texture).skin(approach, footprint).growth.max() > 0.5
    skin = LaidCable(tube, texture, (stretch, gap)).skin(approach, footprint)
    assert (skin.growth == 0.0).all()
