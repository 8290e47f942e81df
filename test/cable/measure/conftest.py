from __future__ import annotations

import cv2
import numpy as np
import pytest


@pytest.fixture
def bottom() -> np.ndarray:
    """Grain of a few pixels on an even bottom, shape (240, 320)."""
    grain = np.random.default_rng(3).normal(0.0, 1.0, (240, 320)).astype(np.float32)
    return 100.0 + 40.0 * cv2.GaussianBlur(grain, (0, 0), 1.5)
