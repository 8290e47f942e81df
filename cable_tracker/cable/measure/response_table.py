"""How likely it is that a point lies on the border of a cable: two learnt tables.

The first is of the response across the border and of its slope: is there an edge, and is it here?
The second is of the contrast between what lies inside the border and outside, a few pixels away
from it, given the response: is it the edge of something, or a mere line? Both are of likelihood
ratios, points on borders against points elsewhere.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.errors import ParameterError

RESPONSE_LIMIT = 12.0
"""Responses beyond this many robust scales are taken for this one."""

RESPONSE_BINS = 96

SLOPE_LIMIT = 0.75
"""Slopes beyond this [1/px] are taken for this one: the edge is more than 2 px away."""

SLOPE_BINS = 15

CONTRAST_LIMIT = 12.0
"""Contrasts beyond this many scales of the contrast are taken for this one."""

CONTRAST_BINS = 25
"""An odd number: a contrast of nothing at all, which is frequent, lies in the middle of a bin."""

COARSE = 4
"""So many bins of the response are one where it stands beside the contrast."""

EDGE_SHAPE = (RESPONSE_BINS, SLOPE_BINS)
CONTRAST_SHAPE = (RESPONSE_BINS // COARSE, CONTRAST_BINS)

RATIO_LIMIT = 6.0
"""No single point may say more than this for or against a border."""

STRAY_SHARE = 0.05
"""Share of border points that are taken to look like anything: growth that no example has shown."""

PRIOR_COUNT = 1e-5
"""Added to every cell of a histogram, in units of the mean cell: no cell is impossible."""

EDGE_SMOOTHING = (2.0, 0.7)
CONTRAST_SMOOTHING = (0.7, 1.0)
"""Sigma of the Gaussian that smooths a histogram, along its rows' and its columns' axis [bins]."""

SHIPPED = "border_responses.json"


@dataclass(frozen=True, slots=True, eq=False)
class PointMeasures:
    """What is measured at P points of borders, all float32, of one shape.

    Attributes
    ----------
    responses : Image
        Response across the border [`ScannedFrame.scale`], positive where the inside is brighter.
    slopes : Image
        Slope of the gradient's modulus over the response [1/px at the reference width]; zero on the
        ridge of an edge. Only its size counts.
    contrasts : Image
        Inside minus outside, smoothed [`ScannedFrame.contrast_scale`].
    """

    responses: Image
    slopes: Image
    contrasts: Image

    def negative(self) -> PointMeasures:
        """Return what would be measured in a negative of the picture."""
        return PointMeasures(-self.responses, self.slopes, -self.contrasts)

    def edge_cells(self) -> Image:
        """Return flat indices into the table of edges, int32."""
        rows = _bins(self.responses, RESPONSE_LIMIT, RESPONSE_BINS)
        columns = np.abs(self.slopes) * np.float32(SLOPE_BINS / SLOPE_LIMIT)
        cells: Image = rows * SLOPE_BINS + np.minimum(columns, SLOPE_BINS - 1).astype(np.int32)
        return cells

    def contrast_cells(self) -> Image:
        """Return flat indices into the table of contrasts, int32."""
        rows = _bins(self.responses, RESPONSE_LIMIT, CONTRAST_SHAPE[0])
        cells: Image = rows * CONTRAST_BINS + _bins(self.contrasts, CONTRAST_LIMIT, CONTRAST_BINS)
        return cells


def _bins(values: Image, limit: float, count: int) -> Image:
    scaled = (values + np.float32(limit)) * np.float32(count / (2 * limit))
    bins: Image = np.clip(scaled, 0, count - 1).astype(np.int32)
    return bins


@dataclass(frozen=True, slots=True, eq=False)
class ResponseTable:
    """Log-likelihood ratios, border against background, of what is measured at one point.

    Attributes
    ----------
    edges : Image
        float32, shape (96, 15): response from -12 to 12 robust scales; slope from 0 to 0.75 per px.
    contrasts : Image
        float32, shape (24, 25): response from -12 to 12, contrast from -12 to 12 of its scales; the
        ratio of the contrast, given the response.
    source : str
        What they were learnt from, for people.
    """

    edges: Image
    contrasts: Image
    source: str

    @property
    def absent(self) -> float:
        """Log-likelihood ratio of a point that shows nothing at all."""
        nothing = np.zeros(1, np.float32)
        return float(self.look_up(PointMeasures(nothing, nothing, nothing)).mean())

    @property
    def edges_of_both(self) -> Image:
        """The table of edges for bright and, turned round, for dark cables: (96, 15, 2)."""
        return np.ascontiguousarray(np.stack((self.edges, self.edges[::-1]), axis=-1))

    @property
    def contrasts_of_both(self) -> Image:
        """The table of contrasts for bright and for dark cables, shape (24, 25, 2)."""
        both = np.stack((self.contrasts, self.contrasts[::-1, ::-1]), axis=-1)
        return np.ascontiguousarray(both)

    def look_up(self, points: PointMeasures) -> Image:
        """Return the ratios of P points on borders of a bright and of a dark cable.

        float32, shape (P, 2).
        """
        ratios: Image = (
            self.edges_of_both.reshape(-1, 2)[points.edge_cells()]
            + self.contrasts_of_both.reshape(-1, 2)[points.contrast_cells()]
        )
        return ratios

    def save(self, path: Path) -> None:
        """Write the tables as JSON.

        Raises
        ------
        OSError
            It cannot be written.
        """
        content = [
            f'"source": {json.dumps(self.source)}',
            *(f'"{name}": {value}' for name, value in _LIMITS.items()),
            *(f'"{name}": [\n{_lines(getattr(self, name))}\n]' for name in _SHAPES),
        ]
        path.write_text("{" + ",\n ".join(content) + "}\n", encoding="utf-8")


_LIMITS = {
    "response_limit": RESPONSE_LIMIT,
    "slope_limit": SLOPE_LIMIT,
    "contrast_limit": CONTRAST_LIMIT,
}
_SHAPES = {"edges": EDGE_SHAPE, "contrasts": CONTRAST_SHAPE}


def _lines(table: Image) -> str:
    rows = ([round(float(value), 3) for value in row] for row in table)
    return ",\n".join("  " + json.dumps(row) for row in rows)


class ResponseHistograms:
    """How often each cell of the tables was met, on borders or elsewhere."""

    def __init__(self) -> None:
        self.edges = np.zeros(EDGE_SHAPE)
        self.contrasts = np.zeros(CONTRAST_SHAPE)

    def add(self, points: PointMeasures) -> None:
        """Count some points."""
        self.edges += _counts(points.edge_cells(), EDGE_SHAPE)
        self.contrasts += _counts(points.contrast_cells(), CONTRAST_SHAPE)


def _counts(cells: Image, shape: tuple[int, int]) -> FloatArray:
    counts = np.bincount(cells.reshape(-1), minlength=shape[0] * shape[1])
    return counts.reshape(shape).astype(np.float64)


def table_from_histograms(
    border: ResponseHistograms, background: ResponseHistograms, source: str
) -> ResponseTable:
    """Make the tables from what was counted on borders of bright cables, and elsewhere.

    Raises
    ------
    ParameterError
        One of the histograms is empty.
    """
    if border.edges.sum() <= 0 or background.edges.sum() <= 0:
        raise ParameterError("there is nothing to learn from: no labelled frame shows a border")
    edges = _log_ratios(
        _density(border.edges, EDGE_SMOOTHING), _density(background.edges, EDGE_SMOOTHING)
    )
    contrasts = _log_ratios(
        _given_row(_density(border.contrasts, CONTRAST_SMOOTHING)),
        _given_row(_density(background.contrasts, CONTRAST_SMOOTHING)),
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


def _log_ratios(on_border: FloatArray, elsewhere: FloatArray) -> Image:
    mixed = (1.0 - STRAY_SHARE) * on_border + STRAY_SHARE * elsewhere
    ratios = np.log(mixed / elsewhere)
    return np.clip(ratios, -RATIO_LIMIT, RATIO_LIMIT).astype(np.float32)


def load_table(path: str) -> ResponseTable:
    """Read the tables from a file; those of the package for an empty path.

    Raises
    ------
    ParameterError
        The file is missing or is none that `cable-tracker learn` writes.
    """
    if not path:
        return _shipped_table()
    try:
        text = Path(path).expanduser().read_text(encoding="utf-8")
    except (OSError, ValueError, RuntimeError) as error:
        raise ParameterError(f"response_table: {path} cannot be read ({error})") from error
    return parse_table(text, path)


@cache
def _shipped_table() -> ResponseTable:
    text = files("cable_tracker.cable.measure").joinpath(SHIPPED).read_text(encoding="utf-8")
    return parse_table(text, SHIPPED)


def parse_table(text: str, name: str) -> ResponseTable:
    """Read the tables from JSON; `name` stands in messages.

    Raises
    ------
    ParameterError
        The text is none that `ResponseTable.save` writes.
    """
    try:
        content = json.loads(text)
        source = str(content["source"])
        limits = {key: float(content[key]) for key in _LIMITS}
        with np.errstate(over="ignore"):  # What is beyond float32 is refused as infinite.
            tables = {key: np.asarray(content[key], dtype=np.float32) for key in _SHAPES}
    except (ValueError, TypeError, KeyError, RecursionError, OverflowError) as error:
        raise ParameterError(
            f"response_table: {name} is no table that `cable-tracker learn` writes ({error})"
        ) from error
    _check_tables(tables, limits, name)
    return ResponseTable(tables["edges"], tables["contrasts"], source)


def is_table(path: Path) -> bool:
    """Tell whether a file holds tables of this kind, of any version."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(content, dict) and "source" in content and "response_limit" in content


def _check_tables(tables: dict[str, Any], limits: dict[str, float], name: str) -> None:
    shapes = {key: table.shape for key, table in tables.items()}
    if shapes != _SHAPES or limits != _LIMITS:
        raise ParameterError(f"response_table: {name} is of another version; learn it anew")
    for table in tables.values():
        if not (np.isfinite(table).all() and np.abs(table).max() <= RATIO_LIMIT + 1e-3):
            raise ParameterError(
                f"response_table: {name} has ratios that are not finite or beyond {RATIO_LIMIT:g}"
            )
