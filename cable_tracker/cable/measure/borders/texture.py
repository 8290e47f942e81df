"""What the texture of a frame says of a strip: a cable's skin is smoother than the bottom.

Grain, ripples and stones of the bottom end where a cable covers them. Under a shadow, in a furrow
and in a sunlit band the bottom goes on, as rough as beside them: light and shade change the grey
levels and their differences by the same factor. So what is compared is the mean size of the
gradient over the grey level, inside and outside each border. A skin that is as rough as the bottom,
or rougher, says nothing: growth is rough, and so is the camera's noise in what is dark.

The shaded limb of a round cable, or a highlight on it, is steep across the cable, and no bottom:
beside it, half of the cable would be a smooth strip. The bottom is rough in every direction, so
what is steep across the border alone counts little there, see `MOST_FOR_ALONG`.

Limitation: in noise a bright strip has a small gradient over its level and counts as smooth.
Requiring a smaller gradient as well cures that, but finds fewer cables (tried).

The constants were chosen on the simulated worlds to tune on (`tune_*`): of strips at random one in
some thousand is smoother than both sides by more than `ORDINARY_STEP`, of cables one in four.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.borders.border_points import Crossings, padded_count, pixel_at
from cable_tracker.cable.measure.gradients.scan_lines import ScanLines
from cable_tracker.cable.measure.gradients.texture_sums import (
    ACROSS_LINES,
    ALONG_LINES,
    MIXED,
    TENSOR_SIZE,
    TEXTURE_STEP,
)
from cable_tracker.compilation import compiled_inside

NEAREST_INSIDE, DEPTH_INSIDE = 6.0, 12.0
"""Start of the inner window behind the border, and its depth, which ends at the middle of the cable
[px at the reference width]."""

NEAREST_OUTSIDE, DEPTH_OUTSIDE = 6.0, 15.0
"""Start of the outer window before the border, and its depth [px at the reference width]: nearer,
the border itself would be in it."""

INNERMOST = 2.0
"""Minimum depth of the inner window, before the middle of the cable [px at the reference width]."""

THINNEST = 12.0
"""Minimum width of a strip whose texture is measured [px at the reference width]."""

FEWEST_PIXELS = 12
"""Minimum number of pixels in each window; with fewer the texture says nothing."""

PIXELS = TENSOR_SIZE
"""Column of the number of pixels in what is added up on a side of a border: it comes after those of
`texture_sums`."""

COLUMNS = TENSOR_SIZE + 1
"""Number of these columns."""

MOST_FOR_ALONG = 2.7
"""The texture outside is at most so many times its gradients along the border. 2 where they have
all directions alike; that finds fewer cables where the bottom has ripples along them (tried)."""

PIXEL_NOISE = 1.0
"""Standard deviation of the log texture of one pixel about that of its surface; pixels count as
independent of each other."""

ORDINARY_STEP, STEP_SLOPE = 0.22, 40.0
"""Log-likelihood ratio = STEP_SLOPE (step - ORDINARY_STEP), not below 0, step the difference of log
texture outside less inside; STEP_SLOPE in nats per unit."""


@compiled_inside
def texture_log_ratio(left: float, right: float, limit: float) -> float:
    """Return what texture says for a cable, from 0 to a limit [nats].

    Parameters
    ----------
    left, right : float
        Smoothness of the inside against the bottom at each border, see `smoothness`. Their
        harmonic mean counts: a cable is smoother than the bottom on both sides.
    limit : float
        See the parameter `texture_limit`.
    """
    if left <= 0.0 or right <= 0.0:
        return 0.0
    step = 2.0 * left * right / (left + right)
    return min(max(STEP_SLOPE * (step - ORDINARY_STEP), 0.0), limit)


@compiled_inside
def may_speak(smoother: float) -> bool:
    """Tell whether texture may say anything of a cable one of whose borders is so smooth.

    If not, the other one need not be looked at: a harmonic mean is less than twice either number.
    """
    return smoother > 0.5 * ORDINARY_STEP


class TextureWindows(NamedTuple):
    """Where texture is looked at beside the crossings of a border, along the scan lines.

    Attributes
    ----------
    inside, outside : (float, float)
        Left and right end of each window [working px from the crossing], plus half a pixel, so that
        rounding down gives the nearest pixel.
    looked_at : bool
        Whether the strip is wide enough, and texture counts at all.
    """

    inside: tuple[float, float]
    outside: tuple[float, float]
    looked_at: bool


@compiled_inside
def texture_windows(stretch: float, width: float, scale: float, limit: float) -> TextureWindows:
    """Return where texture is looked at beside a border.

    Parameters
    ----------
    stretch : float
        Distance along the line, positive to the right, per px inwards across the border.
    width, scale : float
        Width of the cable [working px]; working px per px at the reference width.
    limit : float
        See `texture_log_ratio`.
    """
    begin = min(NEAREST_INSIDE * scale, 0.5 * width - INNERMOST * scale)
    end = min(begin + DEPTH_INSIDE * scale, 0.5 * width)
    nearest, farthest = -NEAREST_OUTSIDE * scale, -(NEAREST_OUTSIDE + DEPTH_OUTSIDE) * scale
    return TextureWindows(
        _window(begin * stretch, end * stretch),
        _window(nearest * stretch, farthest * stretch),
        limit > 0.0 and width >= THINNEST * scale,
    )


@compiled_inside
def _window(begin: float, end: float) -> tuple[float, float]:
    return min(begin, end) + 0.5, max(begin, end) + 0.5


@compiled_inside
def add_texture(
    lines: ScanLines,
    first: int,
    count: int,
    windows: TextureWindows,
    crossings: Crossings,
    texture: FloatArray,
) -> None:
    """Add what lies beside crossings with the lines from `first` on.

    To `texture`, shape (2, 4): sums of the texture inside and outside, and numbers of pixels.
    """
    positions, pixels = crossings.positions, crossings.pixels
    last = float(lines.texture.shape[1] - 1)
    skipped = -first % TEXTURE_STEP
    looked_at = max(count - skipped + TEXTURE_STEP - 1, 0) // TEXTURE_STEP
    for index in range(padded_count(looked_at)):
        position = positions[skipped + TEXTURE_STEP * index]
        pixels[0, index] = pixel_at(position + windows.inside[0], last)
        pixels[1, index] = pixel_at(position + windows.inside[1], last)
        pixels[2, index] = pixel_at(position + windows.outside[0], last)
        pixels[3, index] = pixel_at(position + windows.outside[1], last)
    sums = lines.texture[(first + skipped) // TEXTURE_STEP :]
    for side in range(2):
        _add_windows(sums, pixels[2 * side], pixels[2 * side + 1], looked_at, texture[side])


@compiled_inside
def _add_windows(
    sums: Image,
    begins: NDArray[np.uint32],
    ends: NDArray[np.uint32],
    count: int,
    texture: FloatArray,
) -> None:
    """Add windows of lines, from `begins` to `ends`, to the texture of a side, shape (4,)."""
    # As variables, they stay in registers.
    along, mixed, across = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    for index in range(count):
        line, begin, end = sums[np.uint64(index)], np.uint64(begins[index]), np.uint64(ends[index])
        along += line[end, ALONG_LINES] - line[begin, ALONG_LINES]
        mixed += line[end, MIXED] - line[begin, MIXED]
        across += line[end, ACROSS_LINES] - line[begin, ACROSS_LINES]
    pixels = np.uint32(0)
    for index in range(count):
        pixels += ends[index] - begins[index]
    texture[ALONG_LINES] += along
    texture[MIXED] += mixed
    texture[ACROSS_LINES] += across
    texture[PIXELS] += pixels


@compiled_inside
def smoothness(texture: FloatArray, step: float) -> float:
    """Return by how much the inside of a border is smoother than the outside, log texture.

    One standard error less: few pixels are smooth by chance. 0 where too little of a side is in
    view.

    Parameters
    ----------
    texture : FloatArray
        What `add_texture` added, shape (2, 4).
    step : float
        `BorderLine.step` of the border: by how much it moves along u from line to line.
    """
    pixels_inside, pixels_outside = texture[0, PIXELS], texture[1, PIXELS]
    if min(pixels_inside, pixels_outside) < FEWEST_PIXELS:
        return 0.0
    inside = _gradients(texture[0]) / pixels_inside
    along = MOST_FOR_ALONG * _gradients_along(texture[1], step)
    outside = min(_gradients(texture[1]), along) / pixels_outside
    if inside <= 0.0 or outside <= 0.0:
        return 0.0
    error = PIXEL_NOISE * math.sqrt(1.0 / pixels_inside + 1.0 / pixels_outside)
    return math.log(outside / inside) - error


@compiled_inside
def _gradients(texture: FloatArray) -> float:
    """Return the sum of the sizes of the gradients on a side."""
    return float(texture[ALONG_LINES] + texture[ACROSS_LINES])


@compiled_inside
def _gradients_along(texture: FloatArray, step: float) -> float:
    """Return that sum, each by the squared cosine of its angle with the border.

    Of gradients in all directions, that is half of it.
    """
    mixed = 2.0 * step * texture[MIXED]
    products = step * step * texture[ALONG_LINES] + mixed + texture[ACROSS_LINES]
    return float(products / (1.0 + step * step))
