"""How likely it is that a point lies on the border of a cable: two learnt tables.

The first is of the response across the border and of its slope: is there an edge, and is it here?
The second is of the contrast between what lies inside the border and outside, a few pixels away
from it, given the response: is it the edge of something, or a mere line? Both are of likelihood
ratios, points on borders against points elsewhere. What is measured at a point is sorted into bins,
to be counted when the tables are learnt and to be looked up.

How strong a border is, is not known beforehand: there is a pair of tables for each of some classes
of strength, all against the same background, and a faint border is none the worse for not being a
strong one.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray
from cable_tracker.compilation import compiled_inside
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
"""Bins of the response that are merged into one in the table of contrasts."""

RESPONSE_MIDDLE, CONTRAST_MIDDLE = np.float32(RESPONSE_LIMIT), np.float32(CONTRAST_LIMIT)
RESPONSE_FACTOR = np.float32(RESPONSE_BINS / (2 * RESPONSE_LIMIT))
SLOPE_FACTOR = np.float32(SLOPE_BINS / SLOPE_LIMIT)
CONTRAST_FACTOR = np.float32(CONTRAST_BINS / (2 * CONTRAST_LIMIT))
"""What numbers are shifted by, and bins per unit, in single precision as in the kernels."""

STRENGTHS = (1.2, 1.8, 2.7, 4.0)
"""Smallest strength of the borders of each class; see `border_strength` of cable/learning. Fainter
ones, which cannot be told from the bottom, are not learnt from."""

CLASSES = len(STRENGTHS)

EDGE_SHAPE = (RESPONSE_BINS, SLOPE_BINS)
CONTRAST_SHAPE = (RESPONSE_BINS // COARSE, CONTRAST_BINS)

RATIO_LIMIT = 6.0
"""No entry of a table is beyond this, of either sign."""

LARGEST_RATIO = np.float32(2.4)
"""No single point may say more than this for a border, both tables together."""

SHIPPED = "response_table.json"


@compiled_inside
def _bin(value: np.float32, shift: np.float32, factor: np.float32, count: int) -> np.int32:
    scaled = (value + shift) * factor
    return np.int32(min(max(scaled, np.float32(0.0)), np.float32(count - 1)))


@compiled_inside
def edge_cell(response: np.float32, slope: np.float32) -> np.uint32:
    """Return the row of the table of edges for a response and the size of a slope."""
    row = _bin(response, RESPONSE_MIDDLE, RESPONSE_FACTOR, RESPONSE_BINS)
    return np.uint32(row * SLOPE_BINS + _bin(slope, np.float32(0.0), SLOPE_FACTOR, SLOPE_BINS))


@compiled_inside
def contrast_cell(response: np.float32, contrast: np.float32) -> np.uint32:
    """Return the row of the table of contrasts for a response and a contrast."""
    row = _bin(response, RESPONSE_MIDDLE, RESPONSE_FACTOR, RESPONSE_BINS) // COARSE
    cell = _bin(contrast, CONTRAST_MIDDLE, CONTRAST_FACTOR, CONTRAST_BINS)
    return np.uint32(row * CONTRAST_BINS + cell)


@compiled_inside
def point_cell(response: np.float32, slope: np.float32, contrast: np.float32) -> np.uint32:
    """Return the row of the table of all three for a response, the size of a slope, a contrast."""
    cell = _bin(contrast, CONTRAST_MIDDLE, CONTRAST_FACTOR, CONTRAST_BINS)
    return np.uint32(edge_cell(response, slope) * CONTRAST_BINS + cell)


@dataclass(frozen=True, eq=False)
class ResponseTable:
    """Log-likelihood ratios, border against background, of what is measured at one point.

    Attributes
    ----------
    edges : Float32Array
        float32, shape (4, 96, 15): class of strength; response from -12 to 12 robust scales; slope
        from 0 to 0.75 per px.
    contrasts : Float32Array
        float32, shape (4, 24, 25): class; response from -12 to 12, contrast from -12 to 12 of its
        scales; the ratio of the contrast, given the response.
    source : str
        Description of the recordings that they were learnt from.
    """

    edges: Float32Array
    contrasts: Float32Array
    source: str

    @cached_property
    def absent(self) -> FloatArray:
        """Log-likelihood ratios of a point that shows nothing at all, by class, shape (4,)."""
        nothing = np.float32(0.0)
        ratios = self.ratios[point_cell(nothing, nothing, nothing)]
        means: FloatArray = ratios.reshape(2, CLASSES).mean(axis=0).astype(np.float64)
        return means

    @property
    def limited_contrasts(self) -> Float32Array:
        """The table of contrasts so that no point says more than `LARGEST_RATIO` with any slope.

        The excess is taken off the contrasts, so equally for all slopes: the slope still tells how
        exactly a strong edge lies here.
        """
        most = self.edges.max(axis=2).reshape(CLASSES, -1, COARSE).max(axis=2)
        limited: Float32Array = np.minimum(self.contrasts, LARGEST_RATIO - most[..., None])
        return limited

    @cached_property
    def ratios(self) -> Float32Array:
        """The ratios of a point by its measures, both tables together, float32, shape (36000, 8).

        The rows are those of `point_cell`, the columns the four classes of strength of bright
        cables, then those of dark ones. It is as quick to read as either table alone.
        """
        contrasts = self.limited_contrasts.repeat(COARSE, axis=1)
        bright = np.minimum(self.edges[..., None] + contrasts[:, :, None], LARGEST_RATIO)
        both = np.concatenate((bright, bright[:, ::-1, :, ::-1]))
        return np.ascontiguousarray(both.reshape(len(both), -1).T)

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


def _lines(tables: Float32Array) -> str:
    return ",\n".join(
        " ["
        + ",\n  ".join(json.dumps([round(float(value), 3) for value in row]) for row in table)
        + "]"
        for table in tables
    )


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
    text = (
        files("cable_tracker.cable.measure.borders").joinpath(SHIPPED).read_text(encoding="utf-8")
    )
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
