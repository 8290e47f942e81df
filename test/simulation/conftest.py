from collections.abc import Callable

import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.sequences.frame import Frame, RawImage


@pytest.fixture
def pixels_of() -> Callable[[Frame], Image]:
    def decode(frame: Frame) -> Image:
        image = frame.image
        assert isinstance(image, RawImage)
        return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width)

    return decode
