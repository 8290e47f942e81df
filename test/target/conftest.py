import cv2
import numpy as np
import pytest

WATER, RED = (90, 80, 40), (30, 30, 200)


def scene(centre=(160, 120), axes=(22, 14), size=(320, 240), seed=0, colour=RED, tilt=0):
    """A red ellipse in even, noisy water, and its mask."""
    rng = np.random.default_rng(seed)
    picture = np.full((size[1], size[0], 3), WATER, np.uint8)
    mask = np.zeros((size[1], size[0]), np.uint8)
    if centre is not None:
        cv2.ellipse(mask, centre, axes, -tilt, 0, 360, 1, -1)
    picture[mask > 0] = colour
    noisy = picture + rng.normal(0.0, 5.0, picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8), mask > 0


@pytest.fixture
def draw():
    return scene
