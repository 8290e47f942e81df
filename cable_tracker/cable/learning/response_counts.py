"""Learn the tables of the likelihood ratio from frames in which the cable is labelled."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import BoolArray, Float32Array, FloatArray
from cable_tracker.cable.learning.point_measures import PointMeasures
from cable_tracker.cable.learning.recorded_points import measure_points
from cable_tracker.cable.learning.response_histograms import (
    ResponseHistograms,
    table_from_histograms,
)
from cable_tracker.cable.measure.borders.response_table import (
    CLASSES,
    STRENGTHS,
    ResponseTable,
)
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.model.geometry import image_reaches
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, STATE_SIZE, WIDTH, CableState

RANDOM_CABLES = 20
"""Cables drawn through each frame for what is not a border; a few meet one by chance."""

SHIFTED_CABLES = 6
"""Cables per frame that share one border with the true one: the mistakes that lie nearest."""

WIDTHS = (4.0, 200.0)
"""Widths of random cables [px at the reference width]."""

MOST_SKEW = float(np.deg2rad(25.0))

SHIFTS = (0.3, 1.2)
"""How far the other border of a shifted cable is from where it should be [widths]."""


class ResponseCounts:
    """Histograms of what is measured on borders and elsewhere.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws what is elsewhere.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._borders = [ResponseHistograms() for _ in range(CLASSES)]
        self._background = ResponseHistograms()
        self.frames = 0

    @property
    def border_points(self) -> int:
        """Number of points on borders."""
        return round(sum(float(border.edges.sum()) for border in self._borders))

    @property
    def background_points(self) -> int:
        """Number of points elsewhere."""
        return round(float(self._background.edges.sum()))

    def add(
        self, image: WorkingImage, state: CableState, is_bright: bool | None = None
    ) -> bool | None:
        """Count one labelled frame; one whose cable lies outside the image does not count.

        Each border counts in the class of its strength.

        Parameters
        ----------
        image : WorkingImage
            The frame.
        state : CableState
            Where the cable runs in it.
        is_bright : bool or None
            Polarity of the cable; None: that which most of its border speaks for.

        Returns
        -------
        bool or None
            The polarity; None if the frame does not count.
        """
        true = state.to_array()[None, :]
        crossed = measure_points(true, image)
        points = crossed.measures
        if not len(points.responses):
            return None
        if is_bright is None:
            is_bright = float(points.responses.sum() + points.contrasts.sum()) >= 0.0
        points = points if is_bright else points.negative()
        for border in range(2):
            own = _chosen(points, crossed.borders == border)
            strength = strength_class(border_strength(own.responses))
            if strength >= 0:
                self._borders[strength].add(own)
        self.add_background(image)
        self._count_shifted(true[0], image, is_bright)
        self.frames += 1
        return is_bright

    def add_background(self, image: WorkingImage) -> None:
        """Count what random cables in a frame meet; rarely a true one, if there is any."""
        self._count_elsewhere(self._random_cables(image), image)

    def table(self, source: str) -> ResponseTable:
        """Return the tables learnt from the frames that were added.

        Raises
        ------
        ParameterError
            No frame with a border has been counted.
        """
        return table_from_histograms(self._borders, self._background, source)

    def _count_elsewhere(self, states: FloatArray, image: WorkingImage) -> None:
        points = measure_points(states, image).measures
        # A line has no polarity of its own.
        self._background.add(points)
        self._background.add(points.negative())

    def _count_shifted(self, true: FloatArray, image: WorkingImage, is_bright: bool) -> None:
        """Count the wrong borders of cables that have one border right."""
        share = self._rng.uniform(*SHIFTS, SHIFTED_CABLES)
        moved = np.arange(SHIFTED_CABLES) % 2  # 0: the left border is wrong, 1: the right one.
        states = np.tile(true, (SHIFTED_CABLES, 1))
        states[:, WIDTH] += share * true[WIDTH]
        outward = np.where(moved == 0, -0.5, 0.5)
        states[:, DISTANCE] += outward * share * true[WIDTH]
        crossed = measure_points(states, image)
        wrong = crossed.borders % 2 == moved[crossed.borders // 2]
        chosen = _chosen(crossed.measures, wrong)
        self._background.add(chosen if is_bright else chosen.negative())

    def _random_cables(self, image: WorkingImage) -> FloatArray:
        scale = image.frame_scale
        states = np.zeros((RANDOM_CABLES, STATE_SIZE))
        angles = self._rng.uniform(-np.pi / 2, np.pi / 2, RANDOM_CABLES)
        reach = image_reaches(angles, image.frame_size)
        states[:, ANGLE] = angles
        states[:, DISTANCE] = reach * self._rng.uniform(-1.0, 1.0, RANDOM_CABLES)
        states[:, WIDTH] = scale * self._rng.uniform(*WIDTHS, RANDOM_CABLES)
        states[:, SKEW] = self._rng.uniform(-MOST_SKEW, MOST_SKEW, RANDOM_CABLES)
        return states


def _chosen(points: PointMeasures, chosen: BoolArray) -> PointMeasures:
    """Return the points of a mask of shape (P,)."""
    return PointMeasures(points.responses[chosen], points.slopes[chosen], points.contrasts[chosen])


def border_strength(responses: Float32Array) -> float:
    """Return how strong a border is: the mean of the upper half of its responses (P,), signed."""
    highest = np.sort(responses)[::-1][: (len(responses) + 1) // 2]
    return float(highest.mean()) if len(highest) else 0.0


def strength_class(strength: float) -> int:
    """Return the class of a strength, -1 for one that is too faint for any."""
    return int(np.searchsorted(STRENGTHS, strength, side="right")) - 1
