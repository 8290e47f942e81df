"""Start of a target: marked boxes or outlines, and the parameter that names them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.errors import FrameError, ParameterError

WAIT, DETECT = "wait", "detect"
"""Values of the parameter: wait for a mark, or take what a detector proposes."""

LEAST_SIDE = 3.0
"""Minimum width and height of a marked box [px]."""

LEAST_THICKNESS = 0.5
"""Corners of an outline that are nearer than this to one line enclose nothing [px]."""

FARTHEST = 1e6
"""Corners farther from the picture's are taken to be so far: OpenCV's numbers have 32 bits, and it
walks along all rows in between [px]."""

ROUNDNESS = 0.95
"""Axes of the ellipse that a box stands for, against its sides."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetStart:
    """A marked target.

    Attributes
    ----------
    corners : FloatArray
        Two opposite corners of a box, or the corners of an outline; column and row from the top
        left corner of the frame [px], shape (K, 2).

    Raises
    ------
    FrameError
        It is not finite, or has no area.
    """

    corners: FloatArray

    def __post_init__(self) -> None:
        if self.corners.ndim != 2 or self.corners.shape[1] != 2 or len(self.corners) < 2:
            raise FrameError("mark a target by two corners of a box, or three of an outline")
        if not np.isfinite(self.corners).all():
            raise FrameError("the corners of the marked target must be finite numbers")
        left, top, right, bottom = self.box
        if right - left < LEAST_SIDE or bottom - top < LEAST_SIDE:
            raise FrameError(
                f"the marked target is {right - left:g} px wide and {bottom - top:g} px high;"
                f" mark {LEAST_SIDE:g} px at least"
            )
        if not self.is_box and self._thickness() < LEAST_THICKNESS:
            raise FrameError(
                "the corners of the marked target lie on a line; mark three that enclose an area"
            )

    @classmethod
    def from_box(cls, x0: float, y0: float, x1: float, y1: float) -> TargetStart:
        """Return the start from a box; see `corners`."""
        return cls(np.array([[x0, y0], [x1, y1]], dtype=np.float64))

    @property
    def is_box(self) -> bool:
        """Whether only a box is known."""
        return len(self.corners) == 2

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom [px]."""
        left, top = self.corners.min(axis=0)
        right, bottom = self.corners.max(axis=0)
        return float(left), float(top), float(right), float(bottom)

    def _thickness(self) -> float:
        """Return the root of the sum of squared distances of the corners from their line [px]."""
        centred = self.corners - self.corners.mean(axis=0)
        return float(np.linalg.svd(centred, compute_uv=False)[-1])

    def check(self, image_size: tuple[int, int]) -> None:
        """Check that the start can be in a picture of this size [px].

        Raises
        ------
        FrameError
            It lies outside, or is larger.
        """
        width, height = image_size
        left, top, right, bottom = self.box
        if min(right, width) - max(left, 0.0) < LEAST_SIDE or (
            min(bottom, height) - max(top, 0.0) < LEAST_SIDE
        ):
            raise FrameError(
                f"the marked target {left:g},{top:g},{right:g},{bottom:g} lies outside the picture"
                f" of {width}x{height} px; mark one inside"
            )
        if right - left >= width and bottom - top >= height:
            raise FrameError(
                f"the marked target {left:g},{top:g},{right:g},{bottom:g} is as large as the"
                f" picture of {width}x{height} px; mark only the target"
            )

    def mask(self, shape: tuple[int, int], zoom: float) -> BoolArray:
        """Return the mask in a picture of `shape`, `zoom` times smaller than the frame."""
        mask = np.zeros(shape, np.uint8)
        corners = np.clip(self.corners / zoom, -FARTHEST, FARTHEST)
        if self.is_box:
            (left, top), (right, bottom) = corners.min(axis=0), corners.max(axis=0)
            turns = np.linspace(0.0, 2.0 * math.pi, 49)[:-1]
            middle = ((left + right) / 2, (top + bottom) / 2)
            half = (ROUNDNESS * (right - left) / 2, ROUNDNESS * (bottom - top) / 2)
            corners = np.stack(
                (middle[0] + half[0] * np.cos(turns), middle[1] + half[1] * np.sin(turns)), axis=1
            )
        # A pixel's centre is at its number and a half, as boxes count.
        cv2.fillPoly(mask, [np.round((corners - 0.5) * 16).astype(np.int32)], 1, cv2.LINE_8, 4)
        inside: BoolArray = mask > 0
        return inside


@dataclass(frozen=True, slots=True)
class StartText:
    """Value of the parameter that names the start.

    Attributes
    ----------
    detects : bool
        Whether a detector is asked for.
    boxes : tuple of TargetStart
        Marked targets, the first first; empty where none is marked.
    """

    detects: bool
    boxes: tuple[TargetStart, ...]


def parse_start_text(text: str) -> StartText:
    """Read `wait`, `detect`, or boxes `x0,y0,x1,y1` in px from the top left, divided by `;`.

    Raises
    ------
    ParameterError
        It is none of these, or a box has no area.
    """
    word = text.strip()
    if word in {WAIT, DETECT}:
        return StartText(word == DETECT, ())
    try:
        return StartText(False, tuple(parse_box(part) for part in word.split(";")))
    except ParameterError as error:
        raise ParameterError(f"{error}; give {WAIT}, {DETECT}, or boxes divided by ';'") from error


def parse_box(text: str) -> TargetStart:
    """Read a box `x0,y0,x1,y1` in px from the top left.

    Raises
    ------
    ParameterError
        It is no box, or has no area.
    """
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 4:
        raise ParameterError(
            f"{text.strip()!r} is no box x0,y0,x1,y1 in px from the top left corner"
        )
    try:
        return TargetStart.from_box(*numbers)
    except FrameError as error:
        raise ParameterError(str(error)) from error
