"""Twin of `cable.observation`: the filter across every border at points of its own."""

from __future__ import annotations

import math

import numpy as np
from numpy import float32 as f32

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.state import StateColumn
from cable_tracker.cable.thesis.observation import SMALLEST_SUM
from cable_tracker.compilation import compiled, compiled_fast

DISTANCE, ANGLE = int(StateColumn.DISTANCE), int(StateColumn.ANGLE)
WIDTH, SKEW = int(StateColumn.WIDTH), int(StateColumn.SKEW)


@compiled_fast
def weigh(scores: Image, epsilon: float, weights: FloatArray) -> None:
    """Multiply weights (N,) by what the sums of answers (2N,) make of each cable."""
    left, right = scores[: len(weights)], scores[len(weights) :]
    lowest = f32(epsilon)
    for i in range(len(weights)):
        one, other = abs(left[i]), abs(right[i])
        opposed = (left[i] * right[i] < f32(0)) & (min(one, other) > f32(SMALLEST_SUM))
        strength = max(one + other, lowest)
        weights[i] *= float(strength) if opposed else epsilon


@compiled_fast
def _read(pixels: Image, column: float, row: float) -> float:
    """Return a grey level between pixels, bilinear; the outermost pixels go on."""
    height, width = pixels.shape
    x, y = min(max(column, f32(0)), f32(width - 1)), min(max(row, f32(0)), f32(height - 1))
    i, j = min(np.uint32(x), np.uint32(width - 2)), min(np.uint32(y), np.uint32(height - 2))
    u, v = x - f32(i), y - f32(j)
    above = pixels[j, i] + u * (pixels[j, i + np.uint32(1)] - pixels[j, i])
    j += np.uint32(1)
    below = pixels[j, i] + u * (pixels[j, i + np.uint32(1)] - pixels[j, i])
    return above + v * (below - above)


@compiled_fast
def respond(
    pixels: Image, half: Image, column: float, row: float, cosine: float, sine: float
) -> float:
    """Return the answer of an odd filter at one point, across a line whose normal is given.

    The taps at k and -k have opposite signs, so that one product serves both.
    """
    answer = f32(0)
    for k in range(1, len(half) + 1):
        x, y = f32(k) * f32(cosine), f32(k) * f32(sine)
        ahead = _read(pixels, f32(column) + x, f32(row) - y)
        behind = _read(pixels, f32(column) - x, f32(row) + y)
        answer += half[k - 1] * (ahead - behind)
    return answer


@compiled
def sum_along_borders(
    pixels: Image,
    half: Image,
    states: FloatArray,
    spacing: float,
    frame_size: tuple[int, int],
    reduction: float,
    scores: Image,
    counts: Image,
) -> None:
    """Write the sums of answers along the borders of states (8, N), and of how many points.

    Parameters
    ----------
    pixels : Image
        The picture, float32.
    half : Image
        Taps of the filter at 1, 2, .. px, float32.
    states : FloatArray
        In the frame's image frame.
    spacing : float
        Distance between points [px of the frame].
    frame_size : (int, int)
        Width and height of the frame [px].
    reduction : float
        Pixels of the picture per pixel of the frame.
    scores, counts : Image
        float32, shape (2, N).
    """
    height, width = pixels.shape
    limit_x, limit_y = (frame_size[0] - 1) / 2, (frame_size[1] - 1) / 2
    reach = int(math.hypot(frame_size[0], frame_size[1]) / 2 / spacing)
    for i in range(states.shape[1]):
        cosine_skew = math.cos(states[SKEW, i])
        for border in range(2):
            side = 2 * border - 1
            angle = states[ANGLE, i] + side * states[SKEW, i]
            offset = (states[DISTANCE, i] + side * states[WIDTH, i] / 2) * cosine_skew
            cosine, sine = math.cos(angle), math.sin(angle)
            total, count = f32(0), f32(0)
            for k in range(-reach, reach + 1):
                x = offset * cosine - k * spacing * sine
                y = offset * sine + k * spacing * cosine
                if abs(x) > limit_x or abs(y) > limit_y:
                    continue
                total += respond(
                    pixels,
                    half,
                    (width - 1) / 2 + x * reduction,
                    (height - 1) / 2 - y * reduction,
                    cosine,
                    sine,
                )
                count += f32(1)
            scores[border, i] = total
            counts[border, i] = count


@compiled
def scatter_responses(pixels: Image, half: Image, lines: FloatArray, answers: Image) -> None:
    """Write the moduli of the answers at single places.

    `lines` has shape (G, 4): column, row in the picture, cosine, sine of the normal.
    """
    for g in range(len(lines)):
        answers[g] = abs(respond(pixels, half, lines[g, 0], lines[g, 1], lines[g, 2], lines[g, 3]))
