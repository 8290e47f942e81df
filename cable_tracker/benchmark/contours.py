"""How long a contour takes from a wrong start, beside scikit-image's at the same result."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray
from cable_tracker.contour.evolution import ContourSettings, evolve

WIDTH, HEIGHT = 320, 240

INSIDE, OUTSIDE, NOISE = 0.7, 0.35, 0.08
"""Intensities of target and water, and the standard deviation of the noise."""

REPETITIONS = 101

AS_GOOD = 0.005
"""An overlap that is less by no more is as good."""

MOST_RIVAL_ITERATIONS = 320
"""Largest number of iterations of the rival, tried to reach an equal overlap."""


@dataclass(frozen=True, slots=True)
class ContourTiming:
    """Time of a contour on 320x240, from a start that is wrong by a third of its area.

    Attributes
    ----------
    ms : float
        Median time of the processor [ms].
    overlap : float
        Intersection over union with the truth.
    iterations : int
        Number of iterations done.
    rival_ms, rival_overlap : float or None
        Time [ms] and overlap of scikit-image's morphological_chan_vese, with the fewest
        iterations, in powers of two times ten, that overlap as well, or else the most that
        are tried; None if it is not installed.
    rival_iterations : int or None
        Number of these iterations.
    """

    ms: float
    overlap: float
    iterations: int
    rival_ms: float | None = None
    rival_overlap: float | None = None
    rival_iterations: int | None = None

    @property
    def ratio(self) -> float | None:
        """How many times as long the other one takes."""
        return None if self.rival_ms is None else self.rival_ms / self.ms


def measure_contour() -> ContourTiming:
    """Let contours evolve on a noisy ellipse, ours several times, scikit-image's once."""
    picture, truth, start = _scene()
    settings = ContourSettings()
    # The first is compiled.
    contour = evolve(picture, start, settings, by_means=True)
    times = [
        _milliseconds(lambda: evolve(picture, start, settings, by_means=True))
        for _ in range(REPETITIONS)
    ]
    own = overlap_of(contour.mask, truth)
    ms = float(np.median(times))
    if find_spec("skimage") is None:
        return ContourTiming(ms, own, contour.iterations)
    from skimage.segmentation import morphological_chan_vese  # noqa: PLC0415

    iterations, rival_ms, rival = 5, 0.0, 0.0
    while rival < own - AS_GOOD and iterations < MOST_RIVAL_ITERATIONS:
        iterations *= 2
        found: list[BoolArray] = []

        def evolve_rival(count: int = iterations, found: list[BoolArray] = found) -> None:
            given = picture.astype(np.float64)
            found.append(morphological_chan_vese(given, count, init_level_set=start) > 0)

        rival_ms = _milliseconds(evolve_rival)
        # It does not define which side is the inside.
        rival = max(overlap_of(found[0], truth), overlap_of(~found[0], truth))
    return ContourTiming(ms, own, contour.iterations, rival_ms, rival, iterations)


def overlap_of(one: BoolArray, two: BoolArray) -> float:
    """Return intersection over union of two masks (H, W), 0 to 1."""
    return float((one & two).sum() / max((one | two).sum(), 1))


def _milliseconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return (time.process_time() - begin) * 1e3


def _scene() -> tuple[NDArray[np.float32], BoolArray, BoolArray]:
    """Return a noisy picture, the true inside and the start."""
    drawn = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.ellipse(drawn, (170, 120), (60, 35), 25.0, 0.0, 360.0, 1.0, -1)
    truth: BoolArray = drawn > 0
    rng = np.random.default_rng(0)
    clean = np.where(truth, INSIDE, OUTSIDE)
    noisy = np.clip(clean + rng.normal(0.0, NOISE, truth.shape), 0.0, 1.0).astype(np.float32)
    picture = np.asarray(cv2.GaussianBlur(noisy, (0, 0), 1.0), dtype=np.float32)
    start = np.zeros((HEIGHT, WIDTH), bool)
    start[60:180, 80:240] = True
    return picture, truth, start
