"""Frames of the benchmark: a simulated dive, rendered once, in any size.

Larger frames are enlarged ones: their fine texture is missing, which nothing that is timed here
depends on.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.evaluation_sequences import EvaluationFrame, ScenarioSequence
from cable_tracker.evaluation.methods import Method
from cable_tracker.stamps import FIRST_STAMP

SCENARIO = "S1"
SEED = 0
"""A dive whose first frames `default` and `thesis` follow."""

RENDERED_SIZE = (320, 240)
FRAME_STEP = 40_000_000
"""Time from one frame to the next [ns]."""


@dataclass(frozen=True, slots=True, eq=False)
class Footage:
    """Frames of one size, played forwards and backwards for ever, so that the cable never jumps.

    Attributes
    ----------
    images : tuple of Image
        Grey levels, uint8, shape (H, W).
    truths : tuple of CableState
        True state of the cable in each frame [px, rad].
    """

    images: tuple[Image, ...]
    truths: tuple[CableState, ...]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        height, width = self.images[0].shape
        return width, height

    @property
    def period(self) -> int:
        """Number of frames until the first one is shown again."""
        return max(2 * len(self.images) - 2, 1)

    def index_at(self, number: int) -> int:
        """Return the index of the image that is played as the `number`-th, from 0 on."""
        place = number % self.period
        return place if place < len(self.images) else self.period - place


@functools.cache
def rendered_frames(count: int) -> tuple[EvaluationFrame, ...]:
    """Render the first frames of the dive."""
    frames = tuple(ScenarioSequence(SCENARIO, count).frames(SEED))
    assert all(frame.truth is not None for frame in frames)
    return frames


@functools.cache
def footage(count: int, size: tuple[int, int]) -> Footage:
    """Return the first frames of the dive in a size (width, height) [px].

    Other shapes than 4:3 show the middle part of the picture.
    """
    frames = rendered_frames(count)
    images = tuple(enlarged(frame.image, size) for frame in frames)
    scale = size[0] / RENDERED_SIZE[0]
    truths = tuple(
        frame.truth.scaled(scale).at_rest() for frame in frames if frame.truth is not None
    )
    return Footage(images, truths)


def enlarged(image: Image, size: tuple[int, int]) -> Image:
    """Return the middle of a picture in another size (width, height), uint8."""
    width, height = size
    if (image.shape[1], image.shape[0]) == size:
        return image
    whole_height = max(round(width * image.shape[0] / image.shape[1]), height)
    whole = cv2.resize(image, (width, whole_height), interpolation=cv2.INTER_CUBIC)
    top = (whole_height - height) // 2
    return np.ascontiguousarray(whole[top : top + height])


class FrameLoop:
    """A method that tracks footage for ever, one frame a call.

    It is initialised by the truth whenever the first frame comes, so that tracking is timed, not
    searching.

    Parameters
    ----------
    method : Method
        Method in its initial state.

    Attributes
    ----------
    frames, claimed : int
        Number of frames, and of those in which a cable was claimed.
    """

    def __init__(self, method: Method, shown: Footage) -> None:
        self._method = method
        self._numbers = self._endless(shown)
        self.frames = 0
        self.claimed = 0

    def _endless(self, shown: Footage) -> Iterator[tuple[Image, int]]:
        number = 0
        while True:
            index = shown.index_at(number)
            if number % shown.period == 0:
                self._method.initialise(GivenState.around(shown.truths[0]))
            yield shown.images[index], FIRST_STAMP + number * FRAME_STEP
            number += 1

    def __call__(self) -> None:
        """Process the next frame."""
        image, stamp = next(self._numbers)
        estimate = self._method.process(image, stamp)
        self.frames += 1
        self.claimed += estimate.is_claimed
