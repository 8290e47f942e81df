"""The image frame of trackers, and coordinates of pixels.

Image frame: origin at the image centre ((W-1)/2, (H-1)/2), x to the right, y up [px]. Pixel
coordinates: column and row, from the centre of the top left pixel, rows downwards [px]. Page
coordinates, of outlines and browsers: from the corner of that pixel, half a pixel more.
"""

from __future__ import annotations

from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray

Coordinate = TypeVar("Coordinate", float, NDArray[Any])
"""One number, or an array of any shape."""

Window: TypeAlias = tuple[int, int, int, int]
"""First column, first row, and the column and row after the last [px]."""


def image_centre(image_size: tuple[int, int]) -> tuple[float, float]:
    """Return the column and row of the image centre, of width and height [px]."""
    width, height = image_size
    return (width - 1) / 2, (height - 1) / 2


def to_pixel(
    x: Coordinate, y: Coordinate, image_size: tuple[int, int]
) -> tuple[Coordinate, Coordinate]:
    """Return the column and row of x, y in the image frame; `image_to_pixel` takes points."""
    centre_column, centre_row = image_centre(image_size)
    return centre_column + x, centre_row - y


def to_image(
    column: Coordinate, row: Coordinate, image_size: tuple[int, int]
) -> tuple[Coordinate, Coordinate]:
    """Return x and y in the image frame of a column and row; `pixel_to_image` takes points."""
    centre_column, centre_row = image_centre(image_size)
    return column - centre_column, centre_row - row


def to_page(
    x: Coordinate, y: Coordinate, image_size: tuple[int, int]
) -> tuple[Coordinate, Coordinate]:
    """Return where x, y in the image frame are to the right of and below the top left corner."""
    width, height = image_size
    return width / 2 + x, height / 2 - y


def from_page(
    right: Coordinate, down: Coordinate, image_size: tuple[int, int]
) -> tuple[Coordinate, Coordinate]:
    """Return x and y in the image frame of what is right of and below the top left corner."""
    width, height = image_size
    return right - width / 2, height / 2 - down


def image_to_pixel(points: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Turn points (..., 2) of the image frame into pixel coordinates, column and row."""
    return np.stack(to_pixel(points[..., 0], points[..., 1], image_size), axis=-1)


def pixel_to_image(pixels: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Turn pixel coordinates (..., 2), column and row, into points of the image frame."""
    return np.stack(to_image(pixels[..., 0], pixels[..., 1], image_size), axis=-1)


def bounding_box(mask: BoolArray) -> Window | None:
    """Return the smallest window that holds all pixels of a mask (H, W); None: it has none."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if len(rows) == 0:
        return None
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1
