"""Measurements in one picture of a cable: its place, its borders, and how well they are seen.

The tracker says whether there is a cable; where the sand begins it does not say. So the cable is
cut out of the picture and straightened, and at several places along it the steps of brightness at
both borders are compared with those of the bottom and of the cable itself.
"""

from __future__ import annotations

import math
from itertools import product

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import points_on_lines, segment_inside
from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.survey.frame_table import PROFILE_BINS, FrameRow
from cable_tracker.tracking.image_frame import image_to_pixel

COLUMNS, ROWS_PER_BIN = 48, 4
"""Size of the straightened cable [px]; its borders lie at a quarter and three quarters."""

LEFT, RIGHT = COLUMNS // 4, 3 * COLUMNS // 4
TOLERANCE = 3
"""Distance to either side of a claimed border within which it is looked for [px of the strip]."""

SMOOTHING = (5, 1)
"""Columns and rows over which brightness is averaged before steps are taken."""

LEAST_STEP = 0.5
"""Steps of a bottom without any texture, so that nothing is divided by 0 [grey levels]."""

STRIDE = 3
"""Step between the places at which a cable is looked for [px of the strip]."""

CLEAREST = 3
"""Number of places in a row, the clearest of the cable, by which its clearness is judged. Where it
goes into the sand, a part of it is seen as clearly as ever."""

SHORTEST = 8.0
"""A cable that is seen over a shorter length is not judged [px]."""


def write_view(row: FrameRow, view: GroundView, estimate: CableEstimate) -> None:
    """Write where the camera looks, and how far it sees to either side."""
    row["look"] = view.on_ground(np.zeros((1, 2)))[0, 0]
    row["half_view"] = 0.5 * _view_width(view, float(row["look"]), estimate.image_size)
    row["altitude"] = view.height
    row["roll"], row["pitch"] = view.attitude.roll, view.attitude.pitch


def _view_width(view: GroundView, look: float, image_size: tuple[int, int]) -> float:
    """Return the length inside the image of the line at x = `look`, at the cable's height [m].

    However the camera is turned about its axis.
    """
    if view.clearance <= 0.0:
        return math.nan
    # The line's points in homogeneous coordinates: at y = 0, and by how much they change with y.
    start, step = (view.ground_to_image() @ np.array([[0.0, look, 1.0], [-1.0, 0.0, 0.0]]).T).T
    low, high = -math.inf, math.inf
    for side, sign in product(range(2), (-1.0, 1.0)):
        edge = 0.5 * (image_size[side] - 1)
        beyond = sign * start[side] - edge * start[2]
        change = sign * step[side] - edge * step[2]
        if change > 0.0:
            high = min(high, -beyond / change)
        elif change < 0.0:
            low = max(low, -beyond / change)
        elif beyond > 0.0:
            return 0.0
    return float(max(high - low, 0.0))


def write_metres(row: FrameRow, result: CrossTrack) -> None:
    """Write where the cable is beside the vehicle, and at the place where the camera looks."""
    sigma = result.standard_deviations()
    row["offset"], row["sigma_offset"] = result.offset, sigma[0]
    row["heading"], row["sigma_heading"] = result.heading, sigma[2]
    row["diameter"] = result.diameter
    row["aside"], covariance = result.at(float(row["look"]))
    row["aside_variance"], row["aside_heading"] = covariance[0]
    row["heading_variance"] = covariance[1, 1]


def write_profile(row: FrameRow, view: GroundView, grey: Image, state: CableState) -> bool:
    """Write where along a cable its borders can be seen; False: too little of it is inside."""
    profile = border_profile(grey, state)
    if profile is None:
        return False
    along, scores = profile
    points = points_on_lines(np.array(state.angle), np.array(state.distance), along)
    row["profile_ahead"] = view.on_ground(points)[:, 0]
    row["profile_score"] = scores
    return True


def border_profile(image: Image, state: CableState) -> tuple[FloatArray, FloatArray] | None:
    """Judge along a claimed cable whether its borders are there.

    Parameters
    ----------
    image : Image
        Grey levels, shape (H, W).
    state : CableState
        The claim [px, rad].

    Returns
    -------
    (FloatArray, FloatArray) or None
        Places along the line from its foot point, shape (B,) [px], and for each how many times the
        usual step of brightness the weaker border has, shape (B,); None where too little is inside.
    """
    reach = _reach(image, state)
    if reach is None:
        return None
    slopes, usual = _slopes(image, state, reach)
    edges = np.linspace(reach[1], reach[0], PROFILE_BINS + 1)
    return (edges[:-1] + edges[1:]) / 2, _weaker(slopes, 0) / usual


def find_beside(image: Image, state: CableState, reach: float) -> tuple[float, float] | None:
    """Look for a cable beside the place where it should be, in parallel to it.

    Parameters
    ----------
    image : Image
        Grey levels, shape (H, W).
    state : CableState
        Expected state of the cable [px, rad].
    reach : float
        Search range to either side [widths].

    Returns
    -------
    (float, float) or None
        Offset to the right of the state at which the borders are clearest [widths], and how
        clear they are there, as `border_step_of`; None where too little is inside.
    """
    inside = _reach(image, state)
    if inside is None:
        return None
    margin = math.ceil(reach * (RIGHT - LEFT) / STRIDE) * STRIDE
    slopes, usual = _slopes(image, state, inside, margin)
    shifts = range(-margin, margin + 1, STRIDE)
    scores = [_weaker(slopes, margin + shift) for shift in shifts]
    clear = border_step_of(np.array(scores)) / usual
    best = int(clear.argmax())
    return shifts[best] / (RIGHT - LEFT), float(clear[best])


def border_step_of(scores: FloatArray) -> FloatArray:
    """Return how clearly a cable is seen where it is seen best; scores (N, B), result (N,)."""
    windows = np.lib.stride_tricks.sliding_window_view(scores, CLEAREST, axis=1)
    clearest: FloatArray = windows.mean(axis=2).max(axis=1)
    return clearest


def _reach(image: Image, state: CableState) -> tuple[float, float] | None:
    """Return from where to where a cable lies in a picture, along it; None: hardly at all [px]."""
    height, width = image.shape
    segment = segment_inside(state.angle, state.distance, (width, height))
    if segment is None or not state.width > 1.0:
        return None
    sine, cosine = math.sin(state.angle), math.cos(state.angle)
    low, high = sorted(-x * sine + y * cosine for x, y in segment)
    return (low, high) if high - low >= SHORTEST else None


def _slopes(
    image: Image, state: CableState, reach: tuple[float, float], margin: int = 0
) -> tuple[FloatArray, float]:
    """Return the steps of brightness across a straightened cable, (B, columns), and usual ones."""
    strip = _straightened(image, state, reach, margin)
    steps = np.abs(strip[:, 2:] - strip[:, :-2])
    bins = strip.reshape(PROFILE_BINS, ROWS_PER_BIN, -1).mean(axis=1)
    slopes = bins[:, 2:] - bins[:, :-2]
    texture = _without_shading(slopes, margin)
    usual = float(np.median(np.abs(texture))) + 0.25 * float(np.median(steps)) + LEAST_STEP
    return slopes, usual


def _without_shading(slopes: FloatArray, margin: int) -> FloatArray:
    """Return slopes without what is alike all along between the borders: a round body's shading."""
    between = slice(LEFT + margin, RIGHT + margin - 2)
    texture = slopes.copy()
    texture[:, between] -= slopes[:, between].mean(axis=0)
    return texture


def _weaker(slopes: FloatArray, shift: int) -> FloatArray:
    """Return the step at the weaker border of each bin, (B,)."""
    left, right = _strongest(slopes, LEFT - 1 + shift), _strongest(slopes, RIGHT - 1 + shift)
    # Two borders of one cable rise and fall: steps of the same sign are no cable.
    weaker: FloatArray = np.where(left * right < 0.0, np.minimum(np.abs(left), np.abs(right)), 0.0)
    return weaker


def _straightened(
    image: Image, state: CableState, reach: tuple[float, float], margin: int
) -> FloatArray:
    """Cut the cable out: its direction becomes the column's, both borders become straight.

    `margin` columns are added on either side.
    """
    height, width = image.shape
    sine, cosine = math.sin(state.angle), math.cos(state.angle)
    normal, along = np.array([cosine, sine]), np.array([-sine, cosine])
    corners = []
    for place in reach[::-1]:
        half = max(state.width / 2 - place * math.tan(state.skew), 1.0)
        foot = state.distance * normal + place * along
        corners += [foot - half * normal, foot + half * normal]
    points = image_to_pixel(np.array(corners), (width, height))
    rows = PROFILE_BINS * ROWS_PER_BIN
    left, right = LEFT + margin, RIGHT + margin
    ends = np.array([[left, 0], [right, 0], [left, rows - 1], [right, rows - 1]])
    mapping = cv2.getPerspectiveTransform(ends.astype(np.float32), points.astype(np.float32))
    picture = image if image.dtype == np.uint8 else image.astype(np.float32)
    strip = cv2.warpPerspective(
        picture,
        mapping,
        (COLUMNS + 2 * margin, rows),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    smooth: FloatArray = cv2.blur(strip.astype(np.float32), SMOOTHING).astype(np.float64)
    return smooth


def _strongest(slopes: FloatArray, column: int) -> FloatArray:
    """Return the slope of the largest size near a column, for each bin."""
    near = slopes[:, column - TOLERANCE : column + TOLERANCE + 1]
    place = np.abs(near).argmax(axis=1)
    strongest: FloatArray = near[np.arange(len(near)), place]
    return strongest
