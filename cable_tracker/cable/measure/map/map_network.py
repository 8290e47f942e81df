"""The network that works out the map of a picture.

The likelihood ratio adds up how strong the borders of a strip are, and the bottom has stronger
edges than a faint or overgrown cable. What a person goes by is the whole of it: a skin unlike the
ground, two borders that belong together, nothing of the kind beside. A small network of
convolutions, trained on the simulated worlds to tune on (`tune_*`), says of each cell of 4x4 px how
likely it is part of a cable. It looks at one frame and has no memory; it is consulted while no
cable is known, a border of the known one is faint, or it curves, else now and then (`KeptMap`),
and says which strips look like one (`appearance`, `map_strips`). The filter decides.

`docs/train_cable_map.py` trains it; OpenCV runs it.

References
----------
O. Ronneberger, P. Fischer and T. Brox (2015), "U-Net: convolutional networks for biomedical image
segmentation": the shape of the network.
"""

from __future__ import annotations

import threading
from functools import cache
from importlib.resources import files
from typing import Any

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.map.cable_map import NO_MAP, CableMap, cable_map_of
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH

NETWORK = "cable_map.onnx"
"""The network, as a file beside this module."""

CELL = 4
"""Side of a cell [px of the picture that the network takes]."""

STRIDE = 32
"""Sides of the picture that the network takes are multiples of it [px]."""

TALLEST = 640
"""Height of the tallest picture handed over [px]: of a narrow strip of a frame, as wide as the
network has seen pictures, it would take much memory and time."""

LIGHT_CELLS = (16, 80, 320)
"""Three channels: grey levels minus their means over squares of 16, 80 and 320 px [at the reference
width], interpolated. Small squares remove uneven light but also the inside of a wide cable; larger
ones keep the inside; the largest, the whole picture, keeps the light as well."""

FLATTEST = 1.0
"""Added to the mean deviation of the picture [grey levels]: noise of a flat one stays noise."""

LARGEST = 5.0
"""Largest level handed over, of either sign [mean deviations of the picture]."""


def make_cable_map(picture: Image, frame_width: int) -> CableMap:
    """Return the map of a picture; `NO_MAP` of one that is too narrow for a cell.

    Parameters
    ----------
    picture : Image
        Grey levels, uint8 or float32, shape (h, w).
    frame_width : int
        Width of the frame that the picture shows [px].
    """
    levels = _as_seen(picture)
    height, width = levels.shape
    relative = normalised(levels)
    whole, (margin_left, margin_top) = padded(relative)
    columns, rows = cells_within(margin_left, width), cells_within(margin_top, height)
    if not (columns and rows):
        return NO_MAP
    log_odds = _log_odds(whole)
    inside = np.ascontiguousarray(log_odds[rows.start : rows.stop, columns.start : columns.stop])
    probabilities = (1.0 / (1.0 + np.exp(-inside))).astype(np.float32)
    if not relative.any():
        # The network never saw a picture of one grey level.
        probabilities[:] = 0.0
    scale = frame_width / width
    return cable_map_of(
        probabilities,
        (CELL * (columns.start + 0.5) - margin_left - 0.5 * width) * scale,
        (0.5 * height - CELL * (rows.start + 0.5) + margin_top) * scale,
        CELL * scale,
    )


def normalised(levels: Image) -> Image:
    """Return float32 grey levels (3, h, w) relative to the light, as `LIGHT_CELLS` says.

    They are in mean absolute deviations, which a few glaring stones do not change.
    """
    height, width = levels.shape
    levels = levels - np.float32(levels.mean(dtype=np.float64))
    found = np.empty((len(LIGHT_CELLS), height, width), np.float32)
    for relative, side in zip(found, LIGHT_CELLS, strict=True):
        coarse = (max(width // side, 1), max(height // side, 1))
        light = cv2.resize(levels, coarse, interpolation=cv2.INTER_AREA)
        np.subtract(levels, cv2.resize(light, (width, height)), out=relative)
        deviation = cv2.norm(relative, cv2.NORM_L1) / relative.size + FLATTEST
        np.clip(relative / np.float32(deviation), -LARGEST, LARGEST, out=relative)
    return found


def _as_seen(picture: Image) -> Image:
    """Return a picture as wide as the network has seen them, or narrower if it is a tall one."""
    height, width = picture.shape
    scale = min(REFERENCE_WIDTH / width, TALLEST / height)
    size = (max(round(width * scale), 1), max(round(height * scale), 1))
    if size != (width, height):
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return np.asarray(picture, np.float32)


def padded(levels: Image) -> tuple[Image, tuple[int, int]]:
    """Return levels with their outermost ones repeated, and how many were added left and above.

    Their shape is (..., h, w). What is added are whole cells, so that one begins at the corner.
    """
    height, width = levels.shape[-2:]
    right, below = -width % STRIDE, -height % STRIDE
    left, above = (side // (2 * CELL) * CELL for side in (right, below))
    beside = [(0, 0)] * (levels.ndim - 2)
    margins = (*beside, (above, below - above), (left, right - left))
    return np.pad(levels, margins, "edge"), (left, above)


def cells_within(margin: int, length: int) -> range:
    """Return the cells of a side whose centres lie behind a margin, within a length [px]."""
    first = -((CELL // 2 - margin) // CELL)
    return range(first, (margin + length - CELL // 2 - 1) // CELL + 1)


def _log_odds(levels: Image) -> Image:
    """Return the log-odds of the cells of padded levels (3, h, w)."""
    network = _network()
    network.setInput(levels[None])
    return np.asarray(network.forward()[0, 0])


_OF_THREAD = threading.local()


def _network() -> Any:  # noqa: ANN401
    """Return the network of this thread: one of OpenCV's must not be used by two at once."""
    if not hasattr(_OF_THREAD, "network"):
        _OF_THREAD.network = cv2.dnn.readNetFromONNX(_description())
    return _OF_THREAD.network


@cache
def _description() -> np.ndarray[Any, np.dtype[np.uint8]]:
    path = files("cable_tracker.cable.measure.map").joinpath(NETWORK)
    return np.frombuffer(path.read_bytes(), np.uint8)
