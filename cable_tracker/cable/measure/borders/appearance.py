"""How much a strip looks like a cable, whatever the strength of its borders.

The likelihood ratio adds up how strong the borders are, and the bottom has stronger edges than a
faint or overgrown cable: a furrow, a rope, the rim of a shadow. What a person goes by is another
thing, and three numbers say most of it:

* *Dominance.* Averaged along the strip, its borders are the strongest edges about: beyond them the
  bottom averages out, and between them there is nothing but skin. A strip with one border on a
  cable and the other elsewhere has the cable's other border inside or beside it.
* *Continuity.* A border is there all along. A beam, a box or a stone has a clear border, and ends.
* *Length in view.* Of what has one border in a corner of the picture next to nothing is known.

With a map of the frame (`cable_map`), how well the strip matches it says more than all of these.
Then a cable one end of which is covered (`stretches`) is looked at without that end, too, at a
cost, and the larger of both counts; without a map, whatever ends in the picture would pass for one.

The weights are those of a conditional logit model of which strip of a frame is the cable, or
none, on simulated worlds to tune on (`tune_*`); that of continuity was chosen on pictures of real
ground. With these, the likelihood ratio of a strip adds nothing.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.borders.border_points import (
    BLOCK,
    BorderLine,
    Crossings,
    border_line,
    find_crossings,
    pixel_at,
    room_for_crossings,
    width_across,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import (
    BRIGHT,
    DARK,
    RatioModel,
    measured_cables,
)
from cable_tracker.cable.measure.borders.stretches import (
    STRETCHES,
    fill_by_stretch,
    has_stretch,
    stretch_axis,
    stretch_scale,
)
from cable_tracker.cable.measure.map.cable_map import (
    CableMap,
    bounded_log_odds,
    is_worked_out,
    map_match,
)
from cable_tracker.cable.measure.scanned_gradients import ACROSS, ALONG, ScanInputs, ScanLines
from cable_tracker.cable.model.geometry import border_side
from cable_tracker.compilation import (
    compiled_fast_loop,
    compiled_inside,
    compiled_loop,
    compiled_part,
)

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

DOMINANCE_OUTSIDE, DOMINANCE_INSIDE = 1.0, 1.6
"""Weights of both borders' dominance over what lies outside and inside [nats per unit of a
logarithm]."""

IN_VIEW, ENOUGH_IN_VIEW = 11.0, 0.8
"""Weight of the length in view of the shorter border, as a share of a border through the picture,
and the share beyond which more is no better."""

PARTS = 4
"""Number of parts of a border of which the weakest one is held against all."""

ORDINARY_CONTINUITY, CONTINUITY = -2.0, 5.0
"""Sum over both borders of the log of the weakest part's response over the mean, below which it
speaks against a cable, and its weight."""

UNDECIDED = -12.3
"""Added to the sum of the weighted numbers, so that 0 is a strip that may be a cable or not."""

COVERED_END = 4.0
"""What it costs that a covered end of a cable is not looked at [nats]: the less, the more strips
that are none pass for cables. Chosen on the worlds to tune on; see also `MOST_UNSEEN` of
`stretches`."""

MAP_OVERLAP, MAP_INSIDE, MAP_REST = 2.0, 1.0, 0.33
"""With a map: the weights of the log-odds of both shares of `MapMatch` and of what the above make
[nats per nat]. Chosen on the worlds to tune on: with more weight on the overlap less is found in a
world that the network does not know."""


@compiled_part
def appearances_of(
    states: FloatArray, scan: ScanInputs, model: RatioModel, cable_map: CableMap
) -> FloatArray:
    """Return the appearance of N strips, shape (N, 8): log-odds, of shape (N,) [nats].

    A strip is looked at as the bright or the dark cable that it is likelier to be.
    `cable_map`: the map of the frame, a kept one, or `NO_MAP`.
    """
    count = len(states)
    found = np.empty(count)
    measured = measured_cables(states, scan, model)
    crossings, profile = room_for_crossings(), np.empty((2, PROFILE))
    along = np.empty(max(len(scan.rows.places), len(scan.columns.places)))
    stretch_signs = np.empty(STRETCHES)
    for row in range(count):
        state, length = states[row], measured.visible_lengths[row]
        log_ratios = measured.log_ratios[row]
        polarity, sign = (BRIGHT, 1.0) if log_ratios[BRIGHT] >= log_ratios[DARK] else (DARK, -1.0)
        turned, covered = measured.reversed[row, polarity], measured.covered[row, polarity]
        _fill_stretch_signs(sign, turned, 0, stretch_signs)
        looks = _looks(state, length, stretch_signs, scan, crossings, profile, along)
        if is_worked_out(cable_map):
            if covered:
                _fill_stretch_signs(sign, turned, covered, stretch_signs)
                shown = _looks(state, length, stretch_signs, scan, crossings, profile, along)
                looks = max(looks, shown - COVERED_END)
            match = map_match(state, cable_map)
            mapped = MAP_OVERLAP * bounded_log_odds(match.overlap_share)
            mapped += MAP_INSIDE * bounded_log_odds(match.inside_share)
            looks = mapped + MAP_REST * looks
        found[row] = looks
    return found


@compiled_inside
def _fill_stretch_signs(sign: float, turned: int, covered: int, signs: FloatArray) -> None:
    """Fill in the `stretch_signs` of a cable: 1 for a bright one, -1 for a dark one.

    `turned` and `covered`: those of the other polarity, and those that are not looked at, by bits.
    """
    for stretch in range(STRETCHES):
        signs[stretch] = -sign if has_stretch(turned, stretch) else sign
        if has_stretch(covered, stretch):
            signs[stretch] = 0.0


@compiled_part
def _looks(
    state: FloatArray,
    length: float,
    stretch_signs: FloatArray,
    scan: ScanInputs,
    crossings: Crossings,
    profile: FloatArray,
    along: FloatArray,
) -> float:
    """Return how much the borders of a strip look like those of a cable [nats].

    `length`: that in view of the shorter one [distances of the scan lines]. The others are those of
    `border_appearance`.
    """
    in_view = min(length / scan.points_across, ENOUGH_IN_VIEW)
    looks, continuity = UNDECIDED + IN_VIEW * in_view, 0.0
    for border in range(2):
        more, continuous = border_appearance(
            state, border_side(border), stretch_signs, scan, crossings, profile, along
        )
        looks, continuity = looks + more, continuity + continuous
    return looks + CONTINUITY * min(continuity - ORDINARY_CONTINUITY, 0.0)


@compiled_part
def border_appearance(
    state: FloatArray,
    side: float,
    stretch_signs: FloatArray,
    scan: ScanInputs,
    crossings: Crossings,
    profile: FloatArray,
    along: FloatArray,
) -> tuple[float, float]:
    """Return what the dominance of one border adds to the appearance [nats], and its continuity.

    See `_continuity`.

    Parameters
    ----------
    state : FloatArray
        The strip, shape (8,).
    side : float
        -1 for the left border, 1 for the right one.
    stretch_signs : FloatArray
        1 for bright stretches of the cable, -1 for dark ones, 0 for those that are not looked at,
        shape (`STRETCHES`,).
    scan : ScanInputs
        The frame.
    crossings, profile, along : Crossings, FloatArray, FloatArray
        Room for crossings, for sums and numbers of responses, shape (2, `PROFILE`), and for the
        responses of the border on each line.
    """
    line = border_line(state, side, scan)
    lines = scan.rows if line.is_steep else scan.columns
    along_per_px = 1.0 / line.inward
    scale = stretch_scale(stretch_axis(state, scan), line)
    signs = np.empty(BLOCK)
    profile[:] = 0.0
    shown = 0
    for start in range(0, len(lines.places), BLOCK):
        first, found = find_crossings(lines, start, line, crossings)
        fill_by_stretch(stretch_signs, scale, lines.places[first : first + found], signs)
        shown += _fill_border_responses(
            lines, first, found, line, along_per_px * scan.scale, signs, crossings, along[shown:]
        )
        _add_responses(
            lines, first, found, line, along_per_px * scan.scale, signs, crossings, profile
        )
    half_width = 0.5 * width_across(state, scan.reduction) / scan.scale
    dominances = _dominances(profile, SMALLEST_SHARE * shown, half_width)
    looks = DOMINANCE_OUTSIDE * dominances[0] + DOMINANCE_INSIDE * dominances[1]
    return looks, _continuity(along[:shown])


@compiled_fast_loop
def _add_responses(
    lines: ScanLines,
    first: int,
    count: int,
    border: BorderLine,
    along_per_px: float,
    signs: FloatArray,
    crossings: Crossings,
    profile: FloatArray,
) -> None:
    """Add responses beside crossings with the lines from `first` on.

    To `profile` (2, `PROFILE`): their sums and numbers, from the outside to the inside.
    `along_per_px` is the distance along the line per px at the reference width inwards across the
    border [working px]. `signs`: 1 where the cable is bright, -1 where it is dark, 0 where nothing
    is looked at, shape (>= `count`,).
    """
    last = float(lines.smooth.shape[1] - 1)
    sums, numbers = profile[0], profile[1]
    for index in range(count):
        gradients, middle = lines.gradients[first + index], crossings.positions[index] + 0.5
        sign = signs[index]
        if sign == 0.0:
            continue
        # Where the line begins and ends, in steps from the crossing.
        ends = (-middle / along_per_px, (last + 1.0 - middle) / along_per_px)
        begin = max(math.ceil(min(ends)) + REACH, 0)
        end = min(math.floor(max(ends)) + REACH + 1, PROFILE)
        for step in range(begin, end):
            pixel = np.uint64(pixel_at(middle + (step - REACH) * along_per_px, last))
            along, across = gradients[pixel, ALONG], gradients[pixel, ACROSS]
            sums[step] += sign * (border.along * along + border.across * across)
            numbers[step] += 1.0


@compiled_loop
def _fill_border_responses(
    lines: ScanLines,
    first: int,
    count: int,
    border: BorderLine,
    along_per_px: float,
    signs: FloatArray,
    crossings: Crossings,
    along: FloatArray,
) -> int:
    """Fill in the responses of the border on lines from `first` on, and return their number.

    Each is the largest one within a pixel, at least 0. `along_per_px` and `signs` as in
    `_add_responses`.
    """
    last, filled = float(lines.smooth.shape[1] - 1), 0
    for index in range(count):
        gradients, middle = lines.gradients[first + index], crossings.positions[index] + 0.5
        sign = signs[index]
        if sign == 0.0:
            continue
        largest = 0.0
        for depth in range(-1, 2):
            gradient = gradients[np.uint64(pixel_at(middle + depth * along_per_px, last))]
            response = border.along * gradient[ALONG] + border.across * gradient[ACROSS]
            largest = max(largest, sign * response)
        along[filled] = largest
        filled += 1
    return filled


@compiled_loop
def _continuity(along: FloatArray) -> float:
    """Return the log of the mean response of the weakest part of a border over that of all, <= 0.

    `along`: the responses on the lines that it crosses, shape (L,).
    """
    count = len(along)
    if count < PARTS:
        return 0.0
    weakest, total = math.inf, 0.0
    for part in range(PARTS):
        begin, end = part * count // PARTS, (part + 1) * count // PARTS
        mean = 0.0
        for index in range(begin, end):
            mean += along[index] / (end - begin)
        weakest, total = min(weakest, mean), total + mean / PARTS
    return math.log((weakest + FAINTEST) / (total + FAINTEST))


@compiled_loop
def _dominances(profile: FloatArray, fewest: float, half_width: float) -> tuple[float, float]:
    """Return the logarithms of a border's mean response over the largest outside and inside.

    Parameters
    ----------
    profile : FloatArray
        Sums and numbers of responses, shape (2, `PROFILE`).
    fewest : float
        Means of fewer responses are not looked at.
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
            border = max(border, response)
        elif depth <= -BESIDE:
            outside = max(outside, abs(response))
        elif BESIDE <= depth <= deepest:
            inside = max(inside, abs(response))
    over_outside = math.log((border + FAINTEST) / (outside + FAINTEST))
    if half_width < NARROWEST:
        return over_outside, NARROW_DOMINANCE
    return over_outside, math.log((border + FAINTEST) / (inside + FAINTEST))
