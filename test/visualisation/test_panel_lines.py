import numpy as np
from matplotlib.figure import Figure

from cable_tracker.visualisation.panel_lines import broken_at_wraps, draw_line


def test_what_wraps_is_broken_between_two_values_and_loses_none():
    angles = np.deg2rad([88.0, 89.0, -89.0])
    places, values = broken_at_wraps(np.arange(3.0), angles, np.array([5.0, 6.0, -6.0]))
    np.testing.assert_array_equal(places, [0.0, 1.0, np.nan, 2.0])
    np.testing.assert_array_equal(values, [5.0, 6.0, np.nan, -6.0])


def test_values_without_neighbours_are_dots():
    axis = Figure().subplots()
    draw_line(axis, np.arange(6.0), np.array([1.0, np.nan, 3.0, 4.0, np.nan, 6.0]), "0.5")
    line, dots = axis.lines
    assert len(line.get_xdata()) == 6
    assert dots.get_xdata().tolist() == [0.0, 5.0]
