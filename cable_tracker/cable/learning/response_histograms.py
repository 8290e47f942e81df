"""Counts of what is measured at points, and the tables that come of them."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray, IndexArray
from cable_tracker.cable.learning.point_measures import PointMeasures
from cable_tracker.cable.measure.borders.response_table import (
    CONTRAST_SHAPE,
    EDGE_SHAPE,
    RATIO_LIMIT,
    ResponseTable,
)
from cable_tracker.errors import ParameterError

STRAY_SHARE = 0.1
"""Share of border points that are taken to look like anything: growth that no example has shown."""

ACCIDENT_SHARE = 0.1
"""Share of points elsewhere that are taken to look like a border, for any bottom has some."""

PRIOR_COUNT = 1e-5
"""Added to every cell of a histogram, in units of the mean cell: no cell is impossible."""

EDGE_SMOOTHING = (2.0, 0.7)
CONTRAST_SMOOTHING = (0.7, 1.0)
"""Sigma of the Gaussian that smooths a histogram, along its rows' and its columns' axis [bins]."""


class ResponseHistograms:
    """How often each cell of the tables was met, on borders or elsewhere."""

    def __init__(self) -> None:
        self.edges = np.zeros(EDGE_SHAPE)
        self.contrasts = np.zeros(CONTRAST_SHAPE)

    def add(self, points: PointMeasures) -> None:
        """Count some points."""
        edges, contrasts = points.cells()
        self.edges += _counts(edges, EDGE_SHAPE)
        self.contrasts += _counts(contrasts, CONTRAST_SHAPE)


def _counts(cells: IndexArray, shape: tuple[int, int]) -> FloatArray:
    counts = np.bincount(cells.reshape(-1), minlength=shape[0] * shape[1])
    return counts.reshape(shape).astype(np.float64)


def table_from_histograms(
    borders: Sequence[ResponseHistograms], background: ResponseHistograms, source: str
) -> ResponseTable:
    """Make the tables from what was counted on borders of bright cables, and elsewhere.

    Parameters
    ----------
    borders : sequence of ResponseHistograms
        Histograms of each class of strength. An empty class is filled in with the nearest one that
        is not.
    background : ResponseHistograms
        Histograms of points elsewhere.
    source : str
        Description of the recordings that they were counted in.

    Raises
    ------
    ParameterError
        There is no border, or nothing else.
    """
    met = [index for index, border in enumerate(borders) if border.edges.sum() > 0]
    if not met or background.edges.sum() <= 0:
        raise ParameterError("there is nothing to learn from: no labelled frame shows a border")
    nearest = [min(met, key=lambda other: abs(other - index)) for index in range(len(borders))]
    edges = np.stack(
        [
            _log_ratios(
                _density(borders[index].edges, EDGE_SMOOTHING),
                _density(background.edges, EDGE_SMOOTHING),
            )
            for index in nearest
        ]
    )
    contrasts = np.stack(
        [
            _log_ratios(
                _given_row(_density(borders[index].contrasts, CONTRAST_SMOOTHING)),
                _given_row(_density(background.contrasts, CONTRAST_SMOOTHING)),
            )
            for index in nearest
        ]
    )
    return ResponseTable(edges, contrasts, source)


def _density(counts: FloatArray, smoothing: tuple[float, float]) -> FloatArray:
    smooth = cv2.GaussianBlur(
        counts,
        (0, 0),
        sigmaX=smoothing[1],
        sigmaY=smoothing[0],
        borderType=cv2.BORDER_REPLICATE,
    )
    density = np.asarray(smooth, np.float64) / float(np.sum(smooth))
    return density + PRIOR_COUNT / counts.size


def _given_row(joint: FloatArray) -> FloatArray:
    conditional: FloatArray = joint / joint.sum(axis=1, keepdims=True)
    return conditional


def _log_ratios(on_border: FloatArray, elsewhere: FloatArray) -> Float32Array:
    mixed = (1.0 - STRAY_SHARE) * on_border + STRAY_SHARE * elsewhere
    ratios = np.log(mixed / ((1.0 - ACCIDENT_SHARE) * elsewhere + ACCIDENT_SHARE * mixed))
    return np.clip(ratios, -RATIO_LIMIT, RATIO_LIMIT).astype(np.float32)
