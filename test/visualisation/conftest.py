import numpy as np
import pytest

from cable_tracker.arrays import Image


@pytest.fixture
def grey() -> Image:
    """A smooth grey picture of 320x240."""
    y, x = np.mgrid[0:240, 0:320]
    return (60 + 40 * np.sin(x / 50) * np.cos(y / 40)).astype(np.uint8)
