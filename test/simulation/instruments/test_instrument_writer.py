import numpy as np
import pytest

from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.simulation.instruments.instrument_writer import ORIGIN, fix_at, vehicle_text


def test_the_origin_of_the_world_lies_where_it_is_said_to():
    fix = fix_at(LocalFrame(*ORIGIN), np.zeros(2), 0.0)
    assert (fix.latitude, fix.longitude) == pytest.approx(ORIGIN, abs=1e-9)
    assert fix.height == pytest.approx(0.0, abs=1e-6)


def test_the_height_of_the_cable_is_written_with_sensible_digits():
    assert "\ncable_height: 0.056\n" in vehicle_text(0.055999999999999994)
