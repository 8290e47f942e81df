"""Draws the tracker's belief over a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate, Hypothesis
from cable_tracker.cable.model.geometry import points_on_lines
from cable_tracker.cable.model.segments import (
    Segment,
    band_about,
    border_segments,
    centreline_segments,
)
from cable_tracker.cable.model.state import ANGLE, DISTANCE, STATE_SIZE, CableState
from cable_tracker.errors import FrameError
from cable_tracker.sequences.pictures.shown_levels import shown_levels
from cable_tracker.tracking.image_frame import image_to_pixel
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.visualisation.drawable import (
    drawn_spread,
    heaviest_rows,
    likely_states,
    within_reach,
)
from cable_tracker.visualisation.palette import (
    ESTIMATE,
    HYPOTHESES,
    PARTICLES,
    TRUTH,
    WHITE,
    Colour,
    status_colour,
    to_bgr,
)

LARGEST_CLOUD = 100
"""Largest number of particles that are drawn: those of highest weight."""

LONGEST_SIDE = 8192
"""Longest side of an enlarged picture [px]: videos hold twice as much at most."""

BAND_POINTS = 41

SHIFT = 4
"""Binary digits after the point in the coordinates that OpenCV draws."""

FONT = cv2.FONT_HERSHEY_SIMPLEX


@dataclass(frozen=True, slots=True)
class _Pen:
    """Sizes that suit an image: all grow with it.

    Attributes
    ----------
    image_size : (int, int)
        Width and height [px].
    line, thin : int
        Thickness of borders, and of what is less important [px].
    dash : float
        Length of a dash and of the gap after it [px].
    """

    image_size: tuple[int, int]
    line: int
    thin: int
    dash: float

    @classmethod
    def for_image(cls, canvas: Image) -> _Pen:
        height, width = canvas.shape[:2]
        scale = min(width / 480, height / 360)
        return cls((width, height), max(1, round(1.7 * scale)), max(1, round(scale)), 9 * scale)


def draw_estimate(image: Image, estimate: CableEstimate, cloud: FloatArray | None) -> Image:
    """Draw an estimate and a cloud of particles over its frame; see `draw_overlay`."""
    return draw_overlay(
        image,
        state=estimate.claimed_state,
        status=estimate.status.value,
        sigma=estimate.standard_deviations()[:4],
        cloud=cloud,
        hypotheses=estimate.hypotheses,
        presence=estimate.presence,
    )


def draw_overlay(
    image: Image,
    *,
    state: CableState | None,
    status: str,
    sigma: Sequence[float] | FloatArray | None = None,
    truth: CableState | None = None,
    cloud: FloatArray | None = None,
    hypotheses: Sequence[Hypothesis] = (),
    presence: float | None = None,
    caption: str = "",
    legend: bool = True,
    minimum_width: int | None = None,
    maximum_width: int | None = None,
) -> Image:
    """Draw particles, estimate, truth and status over a frame.

    Parameters
    ----------
    image : Image
        Grey (H, W) or blue-green-red (H, W, 3), uint8, or floating point from 0 to 255. It is not
        changed.
    state : CableState or None
        The estimate [px, rad]; drawn in the colour of the status. None where no cable is claimed.
    status : str
        TRACKING, LOST, INITIALISING, or anything else, which is shown in grey.
    sigma : (4,) or None
        Standard deviations of d, alpha, w, beta [px, rad], for the band of two sigma about the
        centreline.
    truth : CableState or None
        True state of the cable; drawn dashed.
    cloud : FloatArray or None
        Particles, shape (N, 9): the columns of `CableState`, and the weight.
    hypotheses : sequence of Hypothesis
        Where the cable may be. Of those after the first, which is that of the estimate,
        the centrelines are drawn where there is a state or a cloud.
    presence : float or None
        Probability that a cable is in view, 0 to 1, shown behind the status.
    caption : str
        Shown in the lower left corner, one line of ASCII.
    legend : bool
        Write status and numbers on a strip at the top.
    minimum_width, maximum_width : int or None
        Enlarge narrower images, and shrink wider ones, to this width before drawing [px]. The
        numbers stay those of the frame as it came.

    Returns
    -------
    Image
        Blue-green-red, uint8, shape (H, W, 3), or in another size where a width asks for it.

    Raises
    ------
    FrameError
        The image is no grey or colour image, or the cloud has not nine columns.
    """
    canvas = _as_bgr(image)
    if cloud is not None and (cloud.ndim != 2 or cloud.shape[1] != STATE_SIZE + 1):
        raise FrameError(f"cloud: shape is {cloud.shape}; give (N, 9), the state and its weight")
    canvas, scale = resized(canvas, minimum_width, maximum_width)
    pen = _Pen.for_image(canvas)
    if cloud is not None:
        _draw_cloud(canvas, cloud, scale, pen)
    if state is not None or cloud is not None:
        _draw_hypotheses(canvas, hypotheses[1:], scale, pen)
    if state is not None and state.is_finite():
        _draw_estimate(canvas, state.scaled(scale), _scaled_sigma(sigma, scale), status, pen)
    if truth is not None and truth.is_finite():
        _draw_truth(canvas, truth.scaled(scale), pen)
    if legend:
        _write_legend(canvas, state, status, presence, caption)
    return canvas


def resized(canvas: Image, minimum: int | None, maximum: int | None) -> tuple[Image, float]:
    """Return an image whose width lies between two limits, and its enlargement.

    One that is very tall is narrower: no side is longer than `LONGEST_SIDE`.
    """
    height, width = canvas.shape[:2]
    wanted = min(max(width, minimum or width), maximum or max(width, minimum or width))
    wanted = max(1, min(wanted, LONGEST_SIDE, LONGEST_SIDE * width // height))
    if wanted == width:
        return canvas, 1.0
    scale = wanted / width
    size = (wanted, max(1, round(height * scale)))
    # By area is the better picture, and slower than all the drawing; down to half it shows little.
    method = cv2.INTER_CUBIC if scale > 1.0 else cv2.INTER_LINEAR if scale > 0.5 else cv2.INTER_AREA
    return cv2.resize(canvas, size, interpolation=method), scale


def _as_bgr(image: Image) -> Image:
    """Copy an image to blue-green-red of eight bits."""
    if image.ndim not in (2, 3) or image.size == 0 or (image.ndim == 3 and image.shape[2] != 3):
        raise FrameError(f"image: shape is {image.shape}; give (H, W) grey or (H, W, 3) colour")
    if image.dtype != np.uint8:
        finite = np.nan_to_num(image, nan=0.0, posinf=255.0, neginf=0.0)
        image = shown_levels(finite)
    if image.ndim == 2:
        return cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_GRAY2BGR)
    return np.array(image, order="C")


def _scaled_sigma(
    sigma: Sequence[float] | FloatArray | None, scale: float
) -> tuple[float, float] | None:
    """Return the deviations of distance and angle in the enlarged image, if they are numbers."""
    spread = drawn_spread(sigma) if sigma is not None else None
    return (spread[0] * scale, spread[1]) if spread is not None else None


def _to_fixed(points: FloatArray, image_size: tuple[int, int]) -> Image:
    """Turn points (..., 2) of the image frame into OpenCV's fixed-point pixels."""
    pixels = image_to_pixel(points, image_size)
    # Far beyond the image the end of a line makes no difference, but must fit into an int.
    return np.rint(within_reach(pixels, image_size) * (1 << SHIFT)).astype(np.int32)


def _draw_segments(
    canvas: Image, segments: Sequence[Segment], colour: Colour, thickness: int, pen: _Pen
) -> None:
    if segments:
        fixed = _to_fixed(np.array(segments), pen.image_size)
        cv2.polylines(canvas, list(fixed), False, to_bgr(colour), thickness, cv2.LINE_AA, SHIFT)


def _draw_cloud(canvas: Image, cloud: FloatArray, scale: float, pen: _Pen) -> None:
    """Draw centrelines faintly, those of high weight more clearly."""
    reach = float(np.hypot(*pen.image_size)) / 2
    distances = cloud[:, DISTANCE] * scale
    usable = np.isfinite(cloud[:, :2]).all(axis=1) & (np.abs(distances) < reach)
    # Lightest first, so that a heavier one is drawn over it.
    chosen = heaviest_rows(cloud[:, -1], usable, LARGEST_CLOUD)
    if chosen.size == 0:
        return
    angles, ends = cloud[chosen, ANGLE], np.array([-reach, reach])
    fixed = _to_fixed(points_on_lines(angles, distances[chosen], ends), pen.image_size)
    weights = cloud[chosen, -1]
    opacity = 20 + 85 * np.sqrt(weights / weights[-1])
    levels = np.rint(opacity / 12).astype(np.int64) * 12
    layer = np.zeros(canvas.shape[:2], dtype=np.uint8)
    for level in np.unique(levels):
        lines = list(fixed[levels == level])
        cv2.polylines(layer, lines, False, int(level), pen.thin, cv2.LINE_AA, SHIFT)
    _blend(canvas, layer, PARTICLES)


def _blend(canvas: Image, opacity: Image, colour: Colour) -> None:
    """Mix a colour into the canvas; `opacity` is uint8, shape (H, W)."""
    left, top, width, height = cv2.boundingRect(opacity)
    if width == 0:
        return
    region = canvas[top : top + height, left : left + width]
    share = opacity[top : top + height, left : left + width] * np.float32(1 / 255)
    paint = np.full(region.shape, to_bgr(colour), dtype=np.uint8)
    region[:] = cv2.blendLinear(paint, region, share, 1 - share)


def _draw_hypotheses(
    canvas: Image, hypotheses: Sequence[Hypothesis], scale: float, pen: _Pen
) -> None:
    segments = [
        segment
        for state in likely_states(hypotheses)
        for segment in centreline_segments(state.scaled(scale), pen.image_size)
    ]
    _draw_segments(canvas, segments, HYPOTHESES, pen.thin, pen)


def _draw_estimate(
    canvas: Image, state: CableState, sigma: tuple[float, float] | None, status: str, pen: _Pen
) -> None:
    colour = ESTIMATE if status == TrackingStatus.TRACKING.value else status_colour(status)
    if sigma is not None:
        _draw_band(canvas, state, sigma, colour, pen)
    _draw_segments(canvas, centreline_segments(state, pen.image_size), colour, pen.thin, pen)
    _draw_segments(canvas, border_segments(state, pen.image_size), colour, pen.line, pen)


def _draw_band(
    canvas: Image, state: CableState, sigma: tuple[float, float], colour: Colour, pen: _Pen
) -> None:
    """Fill where the centreline lies within two standard deviations of distance and angle."""
    rim = band_about(state, sigma, pen.image_size, BAND_POINTS)
    layer = np.zeros(canvas.shape[:2], dtype=np.uint8)
    cv2.fillPoly(layer, [_to_fixed(rim, pen.image_size)], 55, cv2.LINE_AA, SHIFT)
    _blend(canvas, layer, colour)


def _draw_truth(canvas: Image, truth: CableState, pen: _Pen) -> None:
    dashes = [
        dash
        for segment in border_segments(truth, pen.image_size)
        for dash in _dashes(segment, pen.dash)
    ]
    _draw_segments(canvas, dashes, TRUTH, pen.line, pen)


def _dashes(segment: Segment, length: float) -> list[Segment]:
    """Cut a segment into dashes with equal gaps between them."""
    start, end = np.array(segment)
    total = float(np.hypot(*(end - start)))
    starts = np.arange(0.0, total, 2 * max(length, 1.0))
    ends = np.minimum(starts + max(length, 1.0), total)
    direction = (end - start) / max(total, 1e-9)
    pairs = start + np.stack((starts, ends), axis=1)[..., None] * direction
    return [((a[0], a[1]), (b[0], b[1])) for a, b in pairs.tolist()]


def _numbers(state: CableState) -> str:
    return (
        f"d {state.distance:+.1f} px  alpha {np.rad2deg(state.angle):+.1f} deg  "
        f"w {state.width:.1f} px  beta {np.rad2deg(state.skew):+.1f} deg"
    )


def _write_legend(
    canvas: Image, state: CableState | None, status: str, presence: float | None, caption: str
) -> None:
    """Write status and numbers on a dark strip at the top, the caption at the bottom."""
    height, width = canvas.shape[:2]
    numbers = _numbers(state) if state is not None and state.is_finite() else ""
    wide = _numbers(CableState(-1000.0, -1.0, 100.0, -0.5))
    # Measured by a text of the widest kind, so that the size does not flicker with the digits.
    scale = min(0.97 * width / max(1, _text_width(wide, 1.0)), 0.0021 * height + 0.02, 1.6)
    line = round(_text_height(scale) * 1.6)
    longest = with_presence(TrackingStatus.INITIALISING.value, None if presence is None else 1.0)
    side_by_side = _text_width(f"{longest}  {wide}", scale) < width - 2 * line
    strip = min(height, line if side_by_side else 2 * line)
    darken(canvas[:strip])
    margin = max(2, line // 4)
    text = with_presence(status, presence)
    write_line(canvas, text, (margin, line), scale, status_colour(status))
    if numbers and side_by_side:
        write_line(canvas, numbers, (width - margin - _text_width(wide, scale), line), scale, WHITE)
    elif numbers:
        write_line(canvas, numbers, (margin, 2 * line), scale, WHITE)
    if caption:
        darken(canvas[height - min(height, line) :, : _text_width(caption, scale) + 2 * margin])
        write_line(canvas, caption, (margin, height), scale, WHITE)


def with_presence(status: str, presence: float | None) -> str:
    """Return a status with the probability that a cable is in view, if that is known."""
    return status if presence is None else f"{status} {100 * presence:.0f} %"


def darken(region: Image) -> None:
    """Darken a part of a picture, in place, so that text can be read on it."""
    if region.size > 0:
        region[:] = cv2.convertScaleAbs(region, alpha=0.35)


def _thickness(scale: float) -> int:
    return max(1, round(1.6 * scale))


def _text_width(text: str, scale: float) -> int:
    return int(cv2.getTextSize(text, FONT, scale, _thickness(scale))[0][0])


def _text_height(scale: float) -> int:
    return int(cv2.getTextSize("Tg", FONT, scale, _thickness(scale))[0][1])


def write_line(
    canvas: Image, text: str, corner: tuple[int, int], scale: float, colour: Colour
) -> None:
    """Write a line of text whose strip ends at `corner` (column, row below)."""
    place = (corner[0], corner[1] - round(0.38 * _text_height(scale)))
    cv2.putText(canvas, text, place, FONT, scale, to_bgr(colour), _thickness(scale), cv2.LINE_AA)
