from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cable_tracker.errors import FrameError
from cable_tracker.ros.rigs.soak.faults import (
    CHANGES,
    COMPRESSED_CHANGES,
    REFUSED,
    Fault,
    draw_fault,
)
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.messages.images import read_compressed_image, read_image
from cable_tracker.tracking.succession import check_frame


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def see(image: Any) -> None:
    """Do what the node does with a frame before it tracks."""
    check_frame(decode_grey(image))


@pytest.mark.parametrize("fault", sorted(CHANGES.keys() & REFUSED))
def test_a_bad_frame_cannot_be_used(image_message: Callable[..., Any], fault: Fault):
    for seed in range(5):
        message = image_message()
        CHANGES[fault](message, np.random.default_rng(seed))
        with pytest.raises(FrameError):
            see(read_image(message))


@pytest.mark.parametrize("fault", sorted(CHANGES.keys() - REFUSED))
def test_a_strange_frame_can_be_used(image_message, rng, fault):
    message = image_message()
    before = bytes(message.data)
    CHANGES[fault](message, rng)
    see(read_image(message))
    assert bytes(message.data) != before


@pytest.mark.parametrize("fault", sorted(COMPRESSED_CHANGES.keys() & REFUSED))
def test_a_bad_picture_cannot_be_used(compressed_message, fault):
    for seed in range(5):
        message = compressed_message()
        COMPRESSED_CHANGES[fault](message, np.random.default_rng(seed))
        with pytest.raises(FrameError):
            see(read_compressed_image(message))


def test_every_possible_fault_is_drawn(rng):
    assert {draw_fault(rng, Fault) for _ in range(5000)} == set(Fault)


def test_only_possible_faults_are_drawn(rng):
    assert {draw_fault(rng, CHANGES) for _ in range(500)} == set(CHANGES)
