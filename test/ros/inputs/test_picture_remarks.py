from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.ros.inputs.picture_remarks import remark_on


def with_a_corner(ground: int, corner: int) -> np.ndarray:
    picture = np.full((40, 60), ground, np.uint8)
    picture[:4, :4] = corner
    return picture


@pytest.mark.parametrize(
    ("picture", "words"),
    [
        (np.zeros((40, 60), np.uint8), "all pixels are the same (0 of 255)"),
        (np.full((40, 60), 255, np.uint8), "all pixels are the same (255 of 255)"),
        (with_a_corner(0, 200), "black: 99 % of the pixels"),
        (with_a_corner(255, 10), "saturated: 99 % of the pixels are white"),
        (with_a_corner(90, 120), ""),
        (np.linspace(0.1, 0.9, 40 * 60, dtype=np.float32).reshape(40, 60), ""),
        (None, ""),
    ],
)
def test_what_is_odd_is_named(picture: np.ndarray | None, words: str) -> None:
    assert remark_on(picture) == words
