import numpy as np

from cable_tracker.simulation.rendering.appearance import Skin
from cable_tracker.simulation.rendering.laid_cable import BuriedStretch, LaidCable
from cable_tracker.simulation.rendering.seabed import make_cable
from cable_tracker.simulation.rendering.tube import Tube


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
