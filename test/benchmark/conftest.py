import pytest

from cable_tracker.benchmark.footage import Footage, footage
from cable_tracker.benchmark.yardstick import Yardstick, make_yardstick

FRAMES = 30


@pytest.fixture(scope="session")
def shown() -> Footage:
    """The first frames of the dive at 320x240."""
    return footage(FRAMES, (320, 240))


@pytest.fixture(scope="session")
def yardstick(shown: Footage) -> Yardstick:
    return make_yardstick(shown.images[0], shown.truths[0])
