from __future__ import annotations

import cv2
import numpy as np
import pytest

from cable_tracker.evaluation.loop_figures import MapPanel, plot_errors, plot_way
from cable_tracker.evaluation.loop_table import LoopRow
from cable_tracker.simulation.rendering.laid_cable import Stretch
from cable_tracker.visualisation.palette import STRAW, WHITE, to_bgr

COURSE = np.stack((np.linspace(-5, 25, 200), np.zeros(200), np.zeros(200)), axis=1)
BURIAL = Stretch(9.0, 11.0)


@pytest.fixture
def rows() -> list[LoopRow]:
    modes = ["WAITING"] * 2 + ["FOLLOWING"] * 10 + ["STOPPED", "SEARCHING", "GIVEN UP"]
    return [
        LoopRow(k, k, 0.1, 2.0, 0.0, 0.5, "TRACKING", mode, 0.1, 0.0, 0.1, 0.1, 0.0, 0.01)
        for k, mode in enumerate(modes)
    ]


@pytest.mark.parametrize("burial", [None, BURIAL])
def test_plots_are_the_same_each_time(tmp_path, rows, burial):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        plot_way(tmp_path / folder / "way.png", rows, COURSE, burial)
        plot_errors(tmp_path / folder / "errors.png", rows, burial)
    for name in ("way.png", "errors.png"):
        first, second = ((tmp_path / folder / name).read_bytes() for folder in ("a", "b"))
        assert first == second
        assert cv2.imdecode(np.frombuffer(first, np.uint8), cv2.IMREAD_COLOR).std() > 5.0


def columns_of(picture: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    return np.flatnonzero((picture == to_bgr(colour)).all(axis=2).any(axis=0))


def test_a_cable_to_the_left_is_on_the_left_of_the_map():
    for y, side in ((-2.0, -1), (2.0, 1)):
        panel = MapPanel(COURSE, None).draw((2.0, y), 0.0, ())
        found = columns_of(panel, WHITE)
        assert np.sign(np.median(found) - panel.shape[1] / 2) == side


def test_the_stretch_under_sand_has_a_colour_of_its_own():
    assert columns_of(MapPanel(COURSE, BURIAL).draw((10.0, 1.0), 0.0, ()), STRAW).size
    assert not columns_of(MapPanel(COURSE, None).draw((10.0, 1.0), 0.0, ()), STRAW).size
