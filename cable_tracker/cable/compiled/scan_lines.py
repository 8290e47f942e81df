"""Twin of `cable.scan_lines`, from the frame itself: no other picture is made on the way."""

from __future__ import annotations

import numpy as np
from numpy import float32 as f32

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.compiled.geometry import sine_and_cosine
from cable_tracker.cable.measure.scan_lines import CABLES_PER_CELL
from cable_tracker.cable.model.state import StateColumn
from cable_tracker.compilation import compiled_fast

DISTANCE, ANGLE = int(StateColumn.DISTANCE), int(StateColumn.ANGLE)
WIDTH, SKEW = int(StateColumn.WIDTH), int(StateColumn.SKEW)

OUTSIDE = f32(-1e9)
"""Where lines are not crossed [px]."""

BLOCK = 1024
"""Borders at a time, so that what is read for them stays in the nearest cache."""


@compiled_fast
def _share(index: int, step: float, frame_index: int, length: int) -> float:
    """Return what one pixel of the frame counts for in one that is the mean over an area."""
    start = index * step
    stop = min(start + step, float(length))
    return max(min(stop, frame_index + 1.0) - max(start, float(frame_index)), 0.0) / (stop - start)


@compiled_fast
def _average(frame: Image, row: int, column: int, down: float, across: float) -> float:
    """Return one pixel of the reduced picture; each is the mean over `down` x `across` pixels."""
    height, width = frame.shape
    total = f32(0)
    top, left = int(row * down), int(column * across)
    bottom = min(int(np.ceil((row + 1) * down)), height)
    right = min(int(np.ceil((column + 1) * across)), width)
    for y in range(top, bottom):
        part = f32(0)
        for x in range(left, right):
            part += f32(_share(column, across, x, width)) * f32(frame[y, x])
        total += f32(_share(row, down, y, height)) * part
    return total


@compiled_fast
def _read_row(frame: Image, row: int, down: float, across: float, sums: Image, line: Image) -> None:
    """Write one row of the picture; `sums`, float32 (W,), is room."""
    height, width = frame.shape
    if down == 1.0 and across == 1.0:
        pixels = frame[row]
        for x in range(width):
            line[x] = f32(pixels[x])
        return
    sums[:] = f32(0)
    for y in range(int(row * down), min(int(np.ceil((row + 1) * down)), height)):
        share = f32(_share(row, down, y, height))
        pixels = frame[y]
        for x in range(width):
            sums[x] += share * f32(pixels[x])
    for column in range(len(line)):
        total = f32(0)
        left = int(column * across)
        for x in range(left, min(int(np.ceil((column + 1) * across)), width)):
            total += f32(_share(column, across, x, width)) * sums[x]
        line[column] = total


@compiled_fast
def _filter_line(padded: Image, half: Image, answer: Image) -> None:
    """Filter a line that stands in `padded` with room for the filter on both sides."""
    reach, length = len(half), len(answer) - 1
    first, last = padded[reach], padded[reach + length - 1]
    for k in range(reach):
        padded[k] = first
        padded[reach + length + k] = last
    answer[:] = f32(0)
    for k in range(1, reach + 1):
        tap = half[k - 1]
        right, left = padded[reach + k : reach + k + length], padded[reach - k :]
        for i in range(length):
            answer[i] += tap * (right[i] - left[i])


@compiled_fast
def scan_rows(
    frame: Image,
    size: tuple[int, int],
    rows: IndexArray,
    half: Image,
    room: Image,
    along_rows: Image,
) -> None:
    """Write the filter's answers along some rows of the picture.

    Parameters
    ----------
    frame : Image
        uint8 or float32, shape (H, W).
    size : (int, int)
        Width and height of the picture, which is the frame reduced by averaging over areas.
    rows : IndexArray
        Shape (R,).
    half : Image
        Taps of the filter at 1, 2, .. px, float32.
    room : Image
        float32, at least W + w + 2 len(half) long.
    along_rows : Image
        The answer, float32, shape (R, w + 1); the last column is only room to read from.
    """
    width, height = size
    down, across = frame.shape[0] / height, frame.shape[1] / width
    reach = len(half)
    padded, sums = room[: width + 2 * reach], room[width + 2 * reach :][: frame.shape[1]]
    for k in range(len(rows)):
        _read_row(frame, rows[k], down, across, sums, padded[reach : reach + width])
        _filter_line(padded, half, along_rows[k])


@compiled_fast
def scan_columns(
    frame: Image,
    size: tuple[int, int],
    columns: IndexArray,
    half: Image,
    room: Image,
    along_columns: Image,
) -> None:
    """Write the filter's answers along some columns of the picture, shape (C, h + 1); see above."""
    width, height = size
    down, across = frame.shape[0] / height, frame.shape[1] / width
    reach = len(half)
    padded = room[: height + 2 * reach]
    for k in range(len(columns)):
        column = columns[k]
        if down == 1.0 and across == 1.0:
            for y in range(height):
                padded[reach + y] = f32(frame[y, column])
        else:
            for y in range(height):
                padded[reach + y] = _average(frame, y, column, down, across)
        _filter_line(padded, half, along_columns[k])


@compiled_fast
def scatter_responses(
    frame: Image, size: tuple[int, int], grid: IndexArray, half: Image, answers: Image
) -> None:
    """Write the moduli of the filter's answers at single places (G, 2) of the picture."""
    width, height = size
    down, across = frame.shape[0] / height, frame.shape[1] / width
    whole = down == 1.0 and across == 1.0
    for g in range(len(grid)):
        row, column = grid[g, 0], grid[g, 1]
        answer = f32(0)
        for k in range(1, len(half) + 1):
            if g % 2 == 0:
                top, left = row, max(column - k, 0)
                bottom, right = row, min(column + k, width - 1)
            else:
                top, left = max(row - k, 0), column
                bottom, right = min(row + k, height - 1), column
            if whole:
                rise = f32(frame[bottom, right]) - f32(frame[top, left])
            else:
                rise = _average(frame, bottom, right, down, across) - _average(
                    frame, top, left, down, across
                )
            answer += half[k - 1] * rise
        answers[g] = abs(answer)


@compiled_fast
def _crossing(
    cosine: float, sine: float, offset: float, middle_x: float, middle_y: float
) -> tuple[bool, float, float, float]:
    """Return where a border crosses its lines: lying or not, at the middle, slope, and gain.

    An upright one crosses the row at height y in column `middle + slope * y`; a lying one crosses
    the column at x in row `middle + slope * x`.
    """
    lying = abs(cosine) < abs(sine)
    along = 1.0 / (sine if lying else cosine)
    first = middle_y - offset * along if lying else middle_x + offset * along
    slope = (cosine if lying else -sine) * along
    return lying, first, slope, (-along if lying else along)


@compiled_fast
def project(
    states: FloatArray,
    size: tuple[int, int],
    reduction: float,
    lying: Image,
    borders: Image,
) -> int:
    """Write where the borders of states (8, N) cross the scan lines; return how many lie.

    Parameters
    ----------
    states : FloatArray
        Shape (8, N).
    size : (int, int)
        Width and height of the picture.
    reduction : float
        Its pixels per pixel of the frame.
    lying : Image
        Answer, bool, shape (2N,): the left borders, then the right ones.
    borders : Image
        Answer, float32, shape (3 or more, 2N): where they cross the middle line, slopes, gains; see
        `_crossing`.
    """
    count = states.shape[1]
    middle_x, middle_y = (size[0] - 1) / 2, (size[1] - 1) / 2
    number = 0
    distances, angles, widths, skews = states[DISTANCE], states[ANGLE], states[WIDTH], states[SKEW]
    left_lying, right_lying = lying[:count], lying[count:]
    left_first, right_first = borders[0, :count], borders[0, count:]
    left_slope, right_slope = borders[1, :count], borders[1, count:]
    left_gain, right_gain = borders[2, :count], borders[2, count:]
    for i in range(count):
        sine, cosine = sine_and_cosine(angles[i])
        sine_skew, cosine_skew = sine_and_cosine(skews[i])
        size_of_cosine = cosine_skew * reduction
        lies, middle, steep, factor = _crossing(
            cosine * cosine_skew + sine * sine_skew,
            sine * cosine_skew - cosine * sine_skew,
            (distances[i] - widths[i] / 2) * size_of_cosine,
            middle_x,
            middle_y,
        )
        left_lying[i], left_first[i] = lies, f32(middle)
        left_slope[i], left_gain[i] = f32(steep), f32(factor)
        number += np.int64(lies)
        lies, middle, steep, factor = _crossing(
            cosine * cosine_skew - sine * sine_skew,
            sine * cosine_skew + cosine * sine_skew,
            (distances[i] + widths[i] / 2) * size_of_cosine,
            middle_x,
            middle_y,
        )
        right_lying[i], right_first[i] = lies, f32(middle)
        right_slope[i], right_gain[i] = f32(steep), f32(factor)
        number += np.int64(lies)
    return number


@compiled_fast
def _add_crossings(lines: Image, positions: Image, first: Image, slope: Image, sums: Image) -> None:
    """Add the answers of lines (L, n + 1) where borders cross them; borders are shape (B,)."""
    last = f32(lines.shape[1] - 2)
    for k in range(len(lines)):
        position, line = positions[k], lines[k]
        for i in range(len(first)):
            crossing = first[i] + slope[i] * position
            bounded = min(max(crossing, f32(0)), last)
            before = np.uint32(bounded)
            low, high = line[before], line[before + np.uint32(1)]
            answer = low + (bounded - f32(before)) * (high - low)
            sums[i] += answer if crossing == bounded else f32(0)


@compiled_fast
def sum_directly(
    along_rows: Image,
    heights: Image,
    along_columns: Image,
    places: Image,
    lying_count: int,
    lying: Image,
    first: Image,
    slope: Image,
    room: Image,
    sums: Image,
) -> None:
    """Write the sums of answers (B,) of borders, upright ones and lying ones.

    `first`, `slope` and `lying` are those of `project`; `room` is as long as they are.
    """
    count = len(first)
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        for i in range(start, stop):
            sums[i] = f32(0)
        for family in range(2):
            if lying_count == (count if family == 0 else 0):
                continue
            for i in range(start, stop):
                room[i] = first[i] if lying[i] == (family == 1) else OUTSIDE
            lines, positions = (along_rows, heights) if family == 0 else (along_columns, places)
            _add_crossings(lines, positions, room[start:stop], slope[start:stop], sums[start:stop])


@compiled_fast
def sum_by_table(
    lines: Image,
    positions: Image,
    step: float,
    first: Image,
    slope: Image,
    room: Image,
    sums: Image,
) -> bool:
    """Write the sums for borders (N,) of one side by a table of them; tell whether that pays.

    See `cable.scan_lines.sum_by_table`; `room`, float32 of shape (N or more,), is for the table.
    """
    count = len(first)
    low_first, high_first, low_slope, high_slope = first[0], first[0], slope[0], slope[0]
    for i in range(count):
        low_first, high_first = min(low_first, first[i]), max(high_first, first[i])
        low_slope, high_slope = min(low_slope, slope[i]), max(high_slope, slope[i])
    slope_step = 2.0 * step / max(abs(positions[0]), abs(positions[-1]), 1.0)
    start_first = np.floor(low_first / step) * step
    start_slope = np.floor(low_slope / slope_step) * slope_step
    # As numbers with a fraction: a border next to the wrong family crosses at almost any place.
    wide = np.floor((high_first - start_first) / step) + 2.0
    high = np.floor((high_slope - start_slope) / slope_step) + 2.0
    if wide * high > count / CABLES_PER_CELL:
        return False
    across, down = int(wide), int(high)
    table = room[: across * down].reshape(down, across)
    firsts, slopes = np.empty(across, np.float32), np.empty(across, np.float32)
    for i in range(across):
        firsts[i] = f32(start_first + i * step)
    for j in range(down):
        for i in range(across):
            slopes[i] = f32(start_slope + j * slope_step)
            table[j, i] = f32(0)
        _add_crossings(lines, positions, firsts, slopes, table[j])
    flat, stride = room[: across * down], np.uint32(across)
    base_first, base_slope = f32(start_first), f32(start_slope)
    per_first, per_slope = f32(1.0 / step), f32(1.0 / slope_step)
    last_i, last_j = f32(across - 2), f32(down - 2)
    for k in range(count):
        u, v = (first[k] - base_first) * per_first, (slope[k] - base_slope) * per_slope
        i, j = np.floor(min(max(u, f32(0)), last_i)), np.floor(min(max(v, f32(0)), last_j))
        cell = np.uint32(np.uint32(j) * stride + np.uint32(i))
        below = np.uint32(cell + stride)
        share = u - i
        upper = flat[cell] + share * (flat[cell + np.uint32(1)] - flat[cell])
        lower = flat[below] + share * (flat[below + np.uint32(1)] - flat[below])
        sums[k] = upper + (v - j) * (lower - upper)
    return True


@compiled_fast
def score_cable(
    state: FloatArray,
    size: tuple[int, int],
    reduction: float,
    along_rows: Image,
    heights: Image,
    along_columns: Image,
    places: Image,
    scores: FloatArray,
    counts: FloatArray,
) -> None:
    """Write the sums of answers (2,) along the borders of a state (8,), and of how many points."""
    sine, cosine = sine_and_cosine(state[ANGLE])
    sine_skew, cosine_skew = sine_and_cosine(state[SKEW])
    for border in range(2):
        side = 2.0 * border - 1.0
        lies, first, slope, gain = _crossing(
            cosine * cosine_skew - side * sine * sine_skew,
            sine * cosine_skew + side * cosine * sine_skew,
            (state[DISTANCE] + side * state[WIDTH] / 2) * cosine_skew * reduction,
            (size[0] - 1) / 2,
            (size[1] - 1) / 2,
        )
        lines, positions = (along_columns, places) if lies else (along_rows, heights)
        last = f32(lines.shape[1] - 2)
        total, count = f32(0), 0.0
        for k in range(len(lines)):
            crossing = f32(first) + f32(slope) * positions[k]
            if crossing < f32(0) or crossing > last:
                continue
            before = np.uint32(crossing)
            low, high = lines[k, before], lines[k, before + np.uint32(1)]
            total += low + (crossing - f32(before)) * (high - low)
            count += 1.0
        scores[border] = total * gain
        counts[border] = count * abs(gain)
