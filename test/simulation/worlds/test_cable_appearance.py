"""Surface of a cable in a world."""

from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.simulation.worlds.cable_appearance import CableCoat, random_coat
from cable_tracker.simulation.worlds.catalogue import Coat, Split

PLAIN = CableCoat(
    roughness=0.0,
    roundness=0.0,
    limbs=0.0,
    lamp=0.0,
    armour=0.0,
    collared=False,
    pitch=1.0,
    lay=0.0,
    waves=np.zeros((2, 4, 3)),
)


def tone(coat: CableCoat, u: np.ndarray, v: np.ndarray | float = 0.0) -> np.ndarray:
    u = np.asarray(u, np.float32)
    v = np.broadcast_to(np.asarray(v, np.float32), u.shape)
    return coat.tone(u, v, np.full(u.shape, 2.0, np.float32), np.ones_like(u))


def test_a_plain_coat_shows_its_contrast_alone():
    np.testing.assert_array_equal(tone(PLAIN, [-0.9, 0.0, 0.5]), 2.0)


def test_roughness_is_the_weight_of_the_skin():
    np.testing.assert_allclose(tone(replace(PLAIN, roughness=0.5), [0.0, 0.5]), 2.5)


def test_limbs_are_darker_than_the_line_that_faces_the_lamp():
    lit = tone(replace(PLAIN, limbs=3.0, lamp=0.5), [-1.0, 0.0, 0.5, 1.0])
    assert lit[2] == pytest.approx(2.0)
    assert lit[0] == pytest.approx(-1.0)
    assert lit[0] < lit[1] < lit[2]
    assert lit[1] == pytest.approx(lit[3])


def test_wires_repeat_along_the_cable_and_run_aslant():
    wires = replace(PLAIN, armour=1.0, pitch=0.8, lay=0.4)
    along = np.arange(0.0, 4.0, 0.1, np.float32)
    axis, border = (tone(wires, np.full_like(along, u), along) for u in (0.0, 1.0))
    np.testing.assert_allclose(axis[8:], axis[:-8], atol=1e-4)
    np.testing.assert_allclose(border[:-4], axis[4:], atol=1e-4)


def test_collars_cover_a_quarter_of_the_cable():
    collars = replace(PLAIN, armour=1.0, collared=True, pitch=0.5)
    along = np.arange(0.0, 20.0, 0.01, np.float32)
    raised = tone(collars, np.zeros_like(along), along) > 2.5
    assert raised.mean() == pytest.approx(0.25, abs=0.02)


def test_ragged_borders_leave_the_straight_ones_as_far_as_asked_for():
    coat = random_coat(Coat(raggedness=(0.08, 0.08)), Split.TUNE, np.random.default_rng(3))
    along = np.arange(0.0, 900.0, 0.05, np.float32)
    for side in (-1.0, 1.0):
        edge = coat.edge(np.full_like(along, side), along)
        assert edge.mean() == pytest.approx(1.0, abs=0.01)
        assert edge.std() == pytest.approx(0.08, rel=0.05)
        assert edge.max() < coat.reach


def test_a_range_below_0_stands_for_nothing():
    coat = random_coat(
        Coat(limbs=(-2.0, -1.0), armour=(-1.0, -0.5), raggedness=(-1.0, -0.1)),
        Split.REPORT,
        np.random.default_rng(0),
    )
    assert coat.limbs == coat.armour == 0.0
    assert coat.edge(np.zeros(3, np.float32), np.zeros(3, np.float32)) == 1.0
    assert coat.collared


def test_what_is_drawn_after_a_coat_does_not_depend_on_it():
    after = []
    for coat in (Coat(), Coat(limbs=(0.0, 4.0), raggedness=(0.0, 0.1))):
        rng = np.random.default_rng(7)
        random_coat(coat, Split.TUNE, rng)
        after.append(rng.random())
    assert after[0] == after[1]
