"""How much a strip looks like a cable, whatever the strength of its borders.

The likelihood ratio adds up how strong the borders are, and the bottom has stronger edges than a
faint or overgrown cable: a furrow, a rope, the rim of a shadow. What a person goes by is another
thing, and three numbers say most of it:

* *Dominance.* Averaged along the strip, its borders are the strongest edges about: beyond them the
  bottom averages out, and between them there is nothing but skin. A strip with one border on a
  cable and the other elsewhere has the cable's other border inside or beside it.
* *Smoothness.* The texture of the inside over that of the bottom beside it, see `texture`, of both
  sides together: a side that is as rough takes away what the other one gives.
* *Length in view.* Of what has one border in a corner of the picture next to nothing is known.

The weights were fitted on simulated worlds to tune on (`tune_*`, seeds 0 to 39): a conditional
logit model of which of the strips of a frame is the cable, or none. With these, neither the
likelihood ratio of a strip nor the share of points at which its border is the strongest edge adds
anything.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.border_points import (
    BLOCK,
    BorderLine,
    Crossings,
    FrameScan,
    border_on_scan,
    contrast_depths,
    find_crossings,
    pixel_at,
    room_for_crossings,
    width_across,
)
from cable_tracker.cable.measure.likelihood_ratio import (
    BRIGHT,
    DARK,
    RatioModel,
    allocate_log_ratios,
    fill_log_ratios,
)
from cable_tracker.cable.measure.scan_lines import ACROSS, ALONG, ScanLines
from cable_tracker.cable.measure.texture import add_texture, smoothness, texture_windows
from cable_tracker.cable.model.geometry import border_side
from cable_tracker.compilation import compiled_fast_loop, compiled_loop, compiled_part

REACH = 22
"""Up to where beside a border responses are averaged [px at the reference width]."""

PROFILE = 2 * REACH + 1
"""Number of the mean responses of a border, one px at the reference width apart."""

BORDER_REACH, BESIDE = 2, 5
"""Up to where a response belongs to the border, and from where on to something beside it [px at the
reference width]."""

SMALLEST_SHARE = 0.3
"""Minimum share of the crossings of a border beside which a response is known; with fewer its mean
is not looked at."""

FAINTEST = 0.3
"""Added to mean responses before they are divided [robust scales]: noise does not dominate."""

NARROWEST, NARROW_DOMINANCE = 8.0, 0.7
"""Half the width up to which nothing can be told of the inside [px at the reference width], and the
dominance over it that such a strip is taken to have."""

DOMINANCE_OUTSIDE, DOMINANCE_INSIDE, SMOOTHNESS = 1.0, 1.6, 1.8
"""Weights of both borders' dominance over what lies outside and inside, and of both sides'
smoothness [nats per unit of a logarithm]."""

IN_VIEW, ENOUGH_IN_VIEW = 11.0, 0.8
"""Weight of the length in view of the shorter border, as a share of a border through the picture,
and the share beyond which more is no better."""

UNDECIDED = -12.3
"""Added to the sum of the weighted numbers, so that 0 is a strip that may be a cable or not."""


@compiled_part
def appearances_of(states: FloatArray, scan: FrameScan, model: RatioModel) -> FloatArray:
    """Return the appearance of N strips, shape (N, 8): log-odds, of shape (N,) [nats].

    A strip is looked at as the bright or the dark cable that it is likelier to be.
    """
    count = len(states)
    found, measured = np.empty(count), allocate_log_ratios(count)
    fill_log_ratios(states, 0, count, scan, model, measured)
    crossings, profile = room_for_crossings(), np.empty((2, PROFILE))
    for row in range(count):
        log_ratios = measured.log_ratios[row]
        sign = 1.0 if log_ratios[BRIGHT] >= log_ratios[DARK] else -1.0
        in_view = min(measured.visible_lengths[row] / scan.expected, ENOUGH_IN_VIEW)
        found[row] = UNDECIDED + IN_VIEW * in_view
        for border in range(2):
            side = border_side(border)
            found[row] += border_appearance(states[row], side, sign, scan, crossings, profile)
    return found


@compiled_part
def border_appearance(
    state: FloatArray,
    side: float,
    sign: float,
    scan: FrameScan,
    crossings: Crossings,
    profile: FloatArray,
) -> float:
    """Return what dominance and smoothness of one border add to the appearance [nats].

    Parameters
    ----------
    state : FloatArray
        The strip, shape (8,).
    side, sign : float
        -1 for the left border, 1 for the right one; 1 for a bright cable, -1 for a dark one.
    scan : FrameScan
        The frame.
    crossings, profile : Crossings, FloatArray
        Room for crossings, and for sums and numbers of responses, shape (2, `PROFILE`).
    """
    width = width_across(state, scan.reduction)
    depths = contrast_depths(width, scan.scale)
    steep, along, line = border_on_scan(state, side, scan, -side, depths, True)
    lines = scan.rows if steep else scan.columns
    stretch, texture = -side / along, np.zeros((2, 2))
    windows = texture_windows(stretch, width, scan.scale, 1.0)
    profile[:] = 0.0
    crossed = 0
    for start in range(0, len(lines.places), BLOCK):
        first, found = find_crossings(lines, start, line, crossings)
        crossed += found
        _add_responses(lines, first, found, line, stretch * scan.scale, crossings, profile)
        if windows.looked_at:
            add_texture(lines, first, found, windows, crossings, texture)
    dominances = _dominances(profile, SMALLEST_SHARE * crossed, sign, 0.5 * width / scan.scale)
    return (
        DOMINANCE_OUTSIDE * dominances[0]
        + DOMINANCE_INSIDE * dominances[1]
        + SMOOTHNESS * smoothness(texture)
    )


@compiled_fast_loop
def _add_responses(
    lines: ScanLines,
    first: int,
    count: int,
    border: BorderLine,
    stretch: float,
    crossings: Crossings,
    profile: FloatArray,
) -> None:
    """Add responses beside crossings with the lines from `first` on.

    To `profile` (2, `PROFILE`): their sums and numbers, from the outside to the inside. `stretch`
    is the distance along the line per px at the reference width inwards across the border [working
    px].
    """
    last = float(lines.smooth.shape[1] - 1)
    sums, numbers = profile[0], profile[1]
    for index in range(count):
        gradients, middle = lines.gradients[first + index], crossings.positions[index] + 0.5
        # Where the line begins and ends, in steps from the crossing.
        ends = (-middle / stretch, (last + 1.0 - middle) / stretch)
        begin = max(math.ceil(min(ends)) + REACH, 0)
        end = min(math.floor(max(ends)) + REACH + 1, PROFILE)
        for step in range(begin, end):
            pixel = np.uint64(pixel_at(middle + (step - REACH) * stretch, last))
            along, across = gradients[pixel, ALONG], gradients[pixel, ACROSS]
            sums[step] += border.along * along + border.across * across
            numbers[step] += 1.0


@compiled_loop
def _dominances(
    profile: FloatArray, fewest: float, sign: float, half_width: float
) -> tuple[float, float]:
    """Return the logarithms of a border's mean response over the largest outside and inside.

    Parameters
    ----------
    profile : FloatArray
        Sums and numbers of responses, shape (2, `PROFILE`).
    fewest : float
        Means of fewer responses are not looked at.
    sign : float
        1 for a bright cable, -1 for a dark one.
    half_width : float
        Half the width of the strip [px at the reference width].
    """
    border, outside, inside = 0.0, 0.0, 0.0
    deepest = min(half_width, float(REACH))
    for step in range(PROFILE):
        number, depth = profile[1, step], step - REACH
        if number == 0.0 or number < fewest:
            continue
        response = profile[0, step] / number
        if abs(depth) <= BORDER_REACH:
            border = max(border, sign * response)
        elif depth <= -BESIDE:
            outside = max(outside, abs(response))
        elif BESIDE <= depth <= deepest:
            inside = max(inside, abs(response))
    over_outside = math.log((border + FAINTEST) / (outside + FAINTEST))
    if half_width < NARROWEST:
        return over_outside, NARROW_DOMINANCE
    return over_outside, math.log((border + FAINTEST) / (inside + FAINTEST))
