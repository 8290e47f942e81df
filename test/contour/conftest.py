import numpy as np
import pytest


def disc(height, width, centre, radius):
    rows, columns = np.mgrid[:height, :width]
    return (columns - centre[0]) ** 2 + (rows - centre[1]) ** 2 <= radius**2


@pytest.fixture
def draw_disc():
    return disc
