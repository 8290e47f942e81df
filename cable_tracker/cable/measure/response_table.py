"""How likely it is that a point lies on the border of a cable: two learnt tables.

The first is of the response across the border and of its slope: is there an edge, and is it here?
The second is of the contrast between what lies inside the border and outside, a few pixels away
from it, given the response: is it the edge of something, or a mere line? Both are of likelihood
ratios, points on borders against points elsewhere.

How strong a border is, is not known beforehand: there is a pair of tables for each of some classes
of strength, all against the same background, and a faint border is none the worse for not being a
strong one.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.compilation import compiled, compiled_inside
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

RESPONSE_MIDDLE, CONTRAST_MIDDLE = np.float32(RESPONSE_LIMIT), np.float32(CONTRAST_LIMIT)
RESPONSE_FACTOR = np.float32(RESPONSE_BINS / (2 * RESPONSE_LIMIT))
SLOPE_FACTOR = np.float32(SLOPE_BINS / SLOPE_LIMIT)
CONTRAST_FACTOR = np.float32(CONTRAST_BINS / (2 * CONTRAST_LIMIT))
"""What numbers are shifted by, and bins per unit, in single precision as in the kernels."""

STRENGTHS = (1.2, 1.8, 2.7, 4.0)
"""Smallest strength of the borders of each class; see `border_strength`. Fainter ones, which cannot
be told from the bottom, are not learnt from."""

CLASSES = len(STRENGTHS)

EDGE_SHAPE = (RESPONSE_BINS, SLOPE_BINS)
CONTRAST_SHAPE = (RESPONSE_BINS // COARSE, CONTRAST_BINS)

RATIO_LIMIT = 6.0
"""No entry of a table is beyond this, of either sign."""

LARGEST_RATIO = np.float32(2.4)
"""No single point may say more than this for a border, both tables together."""

STRAY_SHARE = 0.1
"""Share of border points that are taken to look like anything: growth that no example has shown."""

ACCIDENT_SHARE = 0.1
"""Share of points elsewhere that are taken to look like a border, for any bottom has some."""

PRIOR_COUNT = 1e-5
"""Added to every cell of a histogram, in units of the mean cell: no cell is impossible."""

EDGE_SMOOTHING = (2.0, 0.7)
CONTRAST_SMOOTHING = (0.7, 1.0)
"""Sigma of the Gaussian that smooths a histogram, along its rows' and its columns' axis [bins]."""

SHIPPED = "response_table.json"


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

    def cells(self) -> tuple[IndexArray, IndexArray]:
        """Return flat indices into the tables of edges and of contrasts, of the points' shape."""
        shape = np.shape(self.responses)
        edges, contrasts = _cells_of(
            *(np.array(each, np.float32).ravel() for each in self._columns())
        )
        return edges.reshape(shape), contrasts.reshape(shape)

    def _columns(self) -> tuple[Image, Image, Image]:
        return self.responses, self.slopes, self.contrasts


@compiled_inside
def _bin(value: np.float32, shift: np.float32, factor: np.float32, count: int) -> np.uint64:
    scaled = (value + shift) * factor
    return np.uint64(np.int32(min(max(scaled, np.float32(0.0)), np.float32(count - 1))))


@compiled_inside
def response_bin(response: np.float32) -> np.uint64:
    """Return the row of a response in the table of edges; over `COARSE`, in that of contrasts."""
    return _bin(response, RESPONSE_MIDDLE, RESPONSE_FACTOR, RESPONSE_BINS)


@compiled_inside
def slope_bin(slope: np.float32) -> np.uint64:
    """Return the column of the size of a slope in the table of edges."""
    return _bin(slope, np.float32(0.0), SLOPE_FACTOR, SLOPE_BINS)


@compiled_inside
def contrast_bin(contrast: np.float32) -> np.uint64:
    """Return the column of a contrast in the table of contrasts."""
    return _bin(contrast, CONTRAST_MIDDLE, CONTRAST_FACTOR, CONTRAST_BINS)


@compiled
def _cells_of(responses: Image, slopes: Image, contrasts: Image) -> tuple[IndexArray, IndexArray]:
    """Return flat indices (P,) into both tables; all are float32 of shape (P,)."""
    edges, contrast_cells = np.empty(len(responses), np.int64), np.empty(len(responses), np.int64)
    for point in range(len(responses)):
        row = np.int64(response_bin(responses[point]))
        edges[point] = row * SLOPE_BINS + np.int64(slope_bin(abs(slopes[point])))
        contrast_cells[point] = (row // COARSE) * CONTRAST_BINS + np.int64(
            contrast_bin(contrasts[point])
        )
    return edges, contrast_cells


@dataclass(frozen=True, slots=True, eq=False)
class ResponseTable:
    """Log-likelihood ratios, border against background, of what is measured at one point.

    Attributes
    ----------
    edges : Image
        float32, shape (4, 96, 15): class of strength; response from -12 to 12 robust scales; slope
        from 0 to 0.75 per px.
    contrasts : Image
        float32, shape (4, 24, 25): class; response from -12 to 12, contrast from -12 to 12 of its
        scales; the ratio of the contrast, given the response.
    source : str
        What they were learnt from, for people.
    """

    edges: Image
    contrasts: Image
    source: str

    @property
    def absent(self) -> FloatArray:
        """Log-likelihood ratios of a point that shows nothing at all, by class, shape (4,)."""
        # In Python: a tracker needs no machine code for many points then.
        nothing = np.float32(0.0)
        # Integers: before NumPy 2 an unsigned number of NumPy divided by one of Python is a float.
        row, column = int(response_bin(nothing)), int(slope_bin(nothing))
        cell = int(contrast_bin(nothing))
        edges, contrasts = self.edges_of_both[row, column], self.contrasts_of_both[row // COARSE]
        ratios = np.minimum(edges + contrasts[cell], LARGEST_RATIO)
        means: FloatArray = ratios.reshape(2, CLASSES).mean(axis=0).astype(np.float64)
        return means

    @property
    def limited_contrasts(self) -> Image:
        """The table of contrasts so that no point says more than `LARGEST_RATIO` with any slope.

        What is too much is taken off the same for all slopes: how exactly an edge lies here still
        counts where it is strong.
        """
        most = self.edges.max(axis=2).reshape(CLASSES, -1, COARSE).max(axis=2)
        limited: Image = np.minimum(self.contrasts, LARGEST_RATIO - most[..., None])
        return limited

    @property
    def edges_of_both(self) -> Image:
        """The tables of edges for bright and, turned round, for dark cables: (96, 15, 8)."""
        both = np.concatenate((self.edges, self.edges[:, ::-1]))
        return np.ascontiguousarray(np.moveaxis(both, 0, -1))

    @property
    def contrasts_of_both(self) -> Image:
        """The tables of contrasts for bright and for dark cables, shape (24, 25, 8)."""
        own = self.limited_contrasts
        both = np.concatenate((own, own[:, ::-1, ::-1]))
        return np.ascontiguousarray(np.moveaxis(both, 0, -1))

    def look_up(self, points: PointMeasures) -> Image:
        """Return the ratios of P points on borders of a bright and of a dark cable.

        float32, shape (P, 8): four classes of strength of bright ones, then of dark ones.
        """
        edges, contrasts = points.cells()
        ratios: Image = np.minimum(
            self.edges_of_both.reshape(-1, 2 * CLASSES)[edges]
            + self.contrasts_of_both.reshape(-1, 2 * CLASSES)[contrasts],
            LARGEST_RATIO,
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
_SHAPES = {"edges": (CLASSES, *EDGE_SHAPE), "contrasts": (CLASSES, *CONTRAST_SHAPE)}


def _lines(tables: Image) -> str:
    return ",\n".join(
        " ["
        + ",\n  ".join(json.dumps([round(float(value), 3) for value in row]) for row in table)
        + "]"
        for table in tables
    )


def border_strength(responses: Image) -> float:
    """Return how strong a border is: the mean of the upper half of its responses (P,), signed."""
    highest = np.sort(responses)[::-1][: (len(responses) + 1) // 2]
    return float(highest.mean()) if len(highest) else 0.0


def strength_class(strength: float) -> int:
    """Return the class of a strength, -1 for one that is too faint for any."""
    return int(np.searchsorted(STRENGTHS, strength, side="right")) - 1


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
        Of each class of strength. A class that was never met is taken to look like the nearest one
        that was.
    background : ResponseHistograms
        Elsewhere.
    source : str
        What they were counted in.

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


def _log_ratios(on_border: FloatArray, elsewhere: FloatArray) -> Image:
    mixed = (1.0 - STRAY_SHARE) * on_border + STRAY_SHARE * elsewhere
    ratios = np.log(mixed / ((1.0 - ACCIDENT_SHARE) * elsewhere + ACCIDENT_SHARE * mixed))
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
