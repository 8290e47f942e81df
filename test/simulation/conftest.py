from collections.abc import Callable

import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.simulation.rendering.renderer import SceneRenderer


@pytest.fixture
def pixels_of() -> Callable[[Frame], Image]:
    def decode(frame: Frame) -> Image:
        image = frame.image
        assert isinstance(image, RawImage)
        return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width)

    return decode


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures of dives black: where the cable is and what hides it does not need them.

    To draw them takes most of the time of tests that look at many frames.
    """

    def black(renderer: SceneRenderer, *_: object) -> Image:
        return np.zeros(renderer._camera.image_size[::-1], np.uint8)

    monkeypatch.setattr(SceneRenderer, "render", black)
