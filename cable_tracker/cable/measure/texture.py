"""What the texture of a frame says of a strip: a cable's skin is smoother than the bottom.

Grain, ripples and stones of the bottom end where a cable covers them. Under a shadow, in a furrow
and in a sunlit band the bottom goes on, as rough as beside them: light and shade change the grey
levels and their differences by the same factor. So what is compared is the mean size of the
gradient over the grey level, inside and outside each border. A skin that is as rough as the bottom,
or rougher, says nothing: growth is rough, and so is the camera's noise in what is dark. Where there
is little but noise a bright skin counts as a smooth one; that the gradient alone has to be smaller,
too, was tried against it, and finds fewer cables.

The constants were chosen on the simulated worlds to tune on (`tune_*`): of strips at random one in
two hundred is smoother than both sides by more than `ORDINARY_STEP`, of cables two in five.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.cable.measure.border_points import BorderLine
from cable_tracker.cable.measure.scanned_gradients import ScanLines
from cable_tracker.compilation import compiled_inside

NEAREST_INSIDE, DEPTH_INSIDE = 6.0, 12.0
"""The inside is looked at from so far behind a border on, and so deep, but not beyond the middle
[px at the reference width] ..."""

NEAREST_OUTSIDE, DEPTH_OUTSIDE = 6.0, 15.0
"""... and the outside from so far before it on: nearer, the border itself is seen."""

INNERMOST = 2.0
"""At least so much before the middle of the cable is looked at [px at the reference width]."""

THINNEST = 12.0
"""Narrower strips have no inside to look at [px at the reference width]."""

LINE_STEP = 2
"""Every second scan line is looked at: they say the same as all."""

FEWEST_PIXELS = 12
"""Fewer pixels on a side say nothing."""

ORDINARY_STEP, STEP_SLOPE = 0.26, 40.0
"""Steps of the log texture above the first speak for a cable, by so many nats per unit."""


@compiled_inside
def texture_log_ratio(left: float, right: float, limit: float) -> float:
    """Return what texture says for a cable, from 0 to a limit [nats].

    Parameters
    ----------
    left, right : float
        How much smoother the inside is than the bottom at each border, see `smoothness_behind`.
        Their harmonic mean counts, for a strip that is smoother than one side alone is none.
    limit : float
        See the parameter `texture_limit`.
    """
    if left <= 0.0 or right <= 0.0:
        return 0.0
    step = 2.0 * left * right / (left + right)
    return min(max(STEP_SLOPE * (step - ORDINARY_STEP), 0.0), limit)


@compiled_inside
def smoothness_behind(
    lines: ScanLines, border: BorderLine, stretch: float, width: float, scale: float
) -> float:
    """Return by how much the inside of a border is smoother than the outside, log texture.

    0 for thin strips, and where too little of a side is in view.

    Parameters
    ----------
    lines, border : ScanLines, BorderLine
        Where the border is measured, and how it crosses these lines.
    stretch : float
        Along the line, inwards, per px across the border.
    width, scale : float
        Of the cable, and of the working picture [working px].
    """
    if width < THINNEST * scale:
        return 0.0
    begin = min(NEAREST_INSIDE * scale, 0.5 * width - INNERMOST * scale)
    end = min(begin + DEPTH_INSIDE * scale, 0.5 * width)
    inside = _mean_texture(lines, border, begin * stretch, end * stretch)
    begin, end = -NEAREST_OUTSIDE * scale, -(NEAREST_OUTSIDE + DEPTH_OUTSIDE) * scale
    outside = _mean_texture(lines, border, begin * stretch, end * stretch)
    return math.log(outside / inside) if inside > 0.0 and outside > 0.0 else 0.0


@compiled_inside
def _mean_texture(lines: ScanLines, border: BorderLine, begin: float, end: float) -> float:
    """Return the mean texture from `begin` to `end` of a border's crossings, along the lines.

    0 for too few pixels.
    """
    length = float(lines.texture.shape[1] - 1)
    middle, low, high = 0.5 * (length - 1.0), min(begin, end) + 0.5, max(begin, end) + 0.5
    total, pixels = 0.0, 0
    for number in range(0, len(lines.places), LINE_STEP):
        place = border.start + border.step * lines.places[number]
        # Written so that a place that is no number is outside.
        if not abs(place) <= middle:
            continue
        first = int(min(max(place + middle + low, 0.0), length))
        stop = int(min(max(place + middle + high, 0.0), length))
        sums = lines.texture[number]
        total += sums[np.uint64(stop)] - sums[np.uint64(first)]
        pixels += stop - first
    return total / pixels if pixels >= FEWEST_PIXELS else 0.0
