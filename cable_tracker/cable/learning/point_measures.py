"""What is measured at points of borders, and the cells of the tables that it is counted in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import Float32Array, IndexArray
from cable_tracker.cable.measure.borders.response_table import contrast_cell, edge_cell
from cable_tracker.compilation import compiled


@dataclass(frozen=True, slots=True, eq=False)
class PointMeasures:
    """What is measured at P points of borders, all float32, shape (P,).

    Attributes
    ----------
    responses : Float32Array
        Response across the border [`ScanInputs.gradient_scale`], positive where the inside is
        brighter.
    slopes : Float32Array
        Slope of the gradient's modulus over the response [1/px at the reference width]; zero on the
        ridge of an edge. Only its size counts.
    contrasts : Float32Array
        Inside minus outside, smoothed, see `ScanLines.smooth`.
    """

    responses: Float32Array
    slopes: Float32Array
    contrasts: Float32Array

    def negative(self) -> PointMeasures:
        """Return what would be measured in a negative of the picture."""
        return PointMeasures(-self.responses, self.slopes, -self.contrasts)

    def cells(self) -> tuple[IndexArray, IndexArray]:
        """Return flat indices into the tables of edges and of contrasts, shapes (P,)."""
        columns = (self.responses, self.slopes, self.contrasts)
        # Copies of one kind of array: for every kind, Numba compiles anew.
        return _cells_of(*(np.array(each, np.float32) for each in columns))


@compiled
def _cells_of(
    responses: Float32Array, slopes: Float32Array, contrasts: Float32Array
) -> tuple[IndexArray, IndexArray]:
    """Return the rows (P,) of both tables; all are float32 of shape (P,)."""
    edges, contrast_cells = np.empty(len(responses), np.int64), np.empty(len(responses), np.int64)
    for point in range(len(responses)):
        edges[point] = edge_cell(responses[point], abs(slopes[point]))
        contrast_cells[point] = contrast_cell(responses[point], contrasts[point])
    return edges, contrast_cells
