"""What the texture of a frame says of a strip: a cable's skin is smoother than the bottom.

Grain, ripples and stones of the bottom end where a cable covers them. Under a shadow, in a furrow
and in a sunlit band the bottom goes on, as rough as beside them: light and shade change the grey
levels and their differences by the same factor. So what is compared is the mean size of the
gradient over the grey level, inside and outside each border. A skin that is as rough as the bottom,
or rougher, says nothing: growth is rough, and so is the camera's noise in what is dark.

Limitation: in noise a bright strip has a small gradient over its level and counts as smooth.
Requiring a smaller gradient as well cures that, but finds fewer cables (tried).

The constants were chosen on the simulated worlds to tune on (`tune_*`): of strips at random one in
two hundred is smoother than both sides by more than `ORDINARY_STEP`, of cables two in five.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.borders.border_points import Crossings, padded_count, pixel_at
from cable_tracker.cable.measure.gradients.scan_lines import ScanLines
from cable_tracker.cable.measure.gradients.texture_sums import TEXTURE_STEP
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

    To `texture` (2, 2): sums of the texture inside and outside, and numbers of pixels.
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
    # As variables, they stay in registers.
    inside, outside = np.float32(0.0), np.float32(0.0)
    for index in range(looked_at):
        sums = lines.texture[np.uint64((first + skipped) // TEXTURE_STEP + index)]
        inside += sums[np.uint64(pixels[1, index])] - sums[np.uint64(pixels[0, index])]
        outside += sums[np.uint64(pixels[3, index])] - sums[np.uint64(pixels[2, index])]
    inside_pixels, outside_pixels = np.uint32(0), np.uint32(0)
    for index in range(looked_at):
        inside_pixels += pixels[1, index] - pixels[0, index]
        outside_pixels += pixels[3, index] - pixels[2, index]
    texture[0, 0] += inside
    texture[0, 1] += inside_pixels
    texture[1, 0] += outside
    texture[1, 1] += outside_pixels


@compiled_inside
def smoothness(texture: FloatArray) -> float:
    """Return by how much the inside of a border is smoother than the outside, log texture.

    One standard error less: few pixels are smooth by chance. `texture` is what `add_texture` added;
    0 where too little of a side is in view.
    """
    inside, outside = _mean_texture(texture[0]), _mean_texture(texture[1])
    if inside <= 0.0 or outside <= 0.0:
        return 0.0
    error = PIXEL_NOISE * math.sqrt(1.0 / texture[0, 1] + 1.0 / texture[1, 1])
    return math.log(outside / inside) - error


@compiled_inside
def _mean_texture(side: FloatArray) -> float:
    return float(side[0] / side[1]) if side[1] >= FEWEST_PIXELS else 0.0
