"""A whole recording at a glance: small pictures of every few frames on one sheet."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.atomic_output import write_bytes
from cable_tracker.errors import OutputError, ParameterError
from cable_tracker.sequences.pictures.encoded_pictures import png_bytes
from cable_tracker.visualisation.palette import WHITE, Colour, to_bgr

GAP = 4
"""Space between the pictures [px]."""

BACKGROUND = 40
"""Grey level between the pictures."""

CAPTION_SHARE = 0.0625
"""Height of the line of text below a picture, as a share of the picture's width."""


class ContactSheet:
    """Collects pictures of a recording of any length in bounded memory.

    Every `stride`-th picture is kept. When there are more than `limit`, every second one of them is
    dropped and the stride doubled, so that the sheet always spans the whole recording evenly.

    Parameters
    ----------
    stride : int
        Interval of the pictures that are kept, at least 1.
    limit : int
        Largest number of pictures, at least 2.
    thumbnail_width : int
        Width of a picture on the sheet [px], at least 32.

    Attributes
    ----------
    stride : int
        Interval of the pictures that are on the sheet now.

    Raises
    ------
    ParameterError
        A number is too small.
    """

    def __init__(self, stride: int = 10, limit: int = 60, thumbnail_width: int = 320) -> None:
        if stride < 1 or limit < 2 or thumbnail_width < 32:
            raise ParameterError(
                f"contact sheet: stride {stride}, limit {limit}, thumbnail_width {thumbnail_width}:"
                " give at least 1, 2 and 32"
            )
        self.stride = stride
        self._limit = limit
        self._width = thumbnail_width
        self._height = 0
        self._count = 0
        self._thumbnails: list[Image] = []

    def __len__(self) -> int:
        """Return the number of pictures on the sheet."""
        return len(self._thumbnails)

    def add(
        self, draw: Callable[[], Image], frame: int, caption: str = "", colour: Colour = WHITE
    ) -> None:
        """Add the picture of one more frame; it is drawn only if it stays on the sheet.

        Parameters
        ----------
        draw : callable
            Returns the picture: blue-green-red, uint8, shape (H, W, 3).
        frame : int
            Number of the frame, written below the picture.
        caption : str
            Written beside the number, such as the status; ASCII.
        """
        self._count += 1
        if (self._count - 1) % self.stride:
            return
        overlay = draw()
        if not self._thumbnails:
            self._height = max(1, round(overlay.shape[0] * self._width / overlay.shape[1]))
        self._thumbnails.append(self._shrink(overlay, frame, caption, colour))
        if len(self._thumbnails) > self._limit:
            self._thumbnails = self._thumbnails[::2]
            self.stride *= 2

    def draw(self) -> Image:
        """Return the sheet, shape (H, W, 3), blue-green-red, uint8.

        Raises
        ------
        OutputError
            No picture was added.
        """
        count = len(self._thumbnails)
        if count == 0:
            raise OutputError("contact sheet: there are no frames to show; check the recording")
        # About four units wide to three high, as a screen is.
        columns = math.ceil(math.sqrt(count * 4 / 3 * self._height / self._width))
        columns = min(max(columns, 1), count)
        rows = math.ceil(count / columns)
        cell_height = self._height + self._caption_height + GAP
        cell_width = self._width + GAP
        shape = (rows * cell_height + GAP, columns * cell_width + GAP, 3)
        sheet: Image = np.full(shape, BACKGROUND, dtype=np.uint8)
        for place, thumbnail in enumerate(self._thumbnails):
            top = GAP + place // columns * cell_height
            left = GAP + place % columns * cell_width
            sheet[top : top + thumbnail.shape[0], left : left + self._width] = thumbnail
        return sheet

    def write(self, path: Path) -> None:
        """Write the sheet as a PNG file; a failure leaves no file behind.

        Raises
        ------
        OutputError
            No picture was added, or the file cannot be written.
        """
        write_bytes(path, png_bytes(self.draw()))

    @property
    def _caption_height(self) -> int:
        return max(6, round(CAPTION_SHARE * self._width))

    def _shrink(self, overlay: Image, frame: int, caption: str, colour: Colour) -> Image:
        """Fit a picture into a cell without distorting it, and write below what it shows."""
        height, width = overlay.shape[:2]
        scale = min(self._width / width, self._height / height)
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        method = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
        small = cv2.resize(overlay, size, interpolation=method)
        shape = (self._height + self._caption_height, self._width, 3)
        cell: Image = np.full(shape, BACKGROUND, dtype=np.uint8)
        top, left = (self._height - size[1]) // 2, (self._width - size[0]) // 2
        cell[top : top + size[1], left : left + size[0]] = small
        _write_caption(cell[self._height :], f"{frame}  ", caption, colour)
        return cell


def _write_caption(strip: Image, number: str, caption: str, colour: Colour) -> None:
    """Write the number in white and the caption in its colour on a strip below the picture."""
    strip[:] = 20
    font = cv2.FONT_HERSHEY_SIMPLEX
    scale = strip.shape[0] / 34
    baseline = round(0.72 * strip.shape[0])
    cv2.putText(strip, number, (3, baseline), font, scale, to_bgr(WHITE), 1, cv2.LINE_AA)
    left = 3 + cv2.getTextSize(number, font, scale, 1)[0][0]
    cv2.putText(strip, caption, (left, baseline), font, scale, to_bgr(colour), 1, cv2.LINE_AA)
