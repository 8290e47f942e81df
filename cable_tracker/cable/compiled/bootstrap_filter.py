"""The steps of the bootstrap filter for all particles at once; twin of `NumpyBootstrapFilter`.

Few calls with many arguments: each call from Python costs as much as a hundred particles.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.compiled.evidence import border_evidence
from cable_tracker.cable.compiled.movement import BLOCK, diffuse, drift, keep_within, wrap
from cable_tracker.cable.compiled.observation import (
    scatter_responses,
    sum_along_borders,
    weigh,
)
from cable_tracker.cable.compiled.scan_lines import (
    scan_columns,
    scan_rows,
    score_cable,
    sum_by_table,
    sum_directly,
)
from cable_tracker.cable.compiled.scan_lines import scatter_responses as scatter_scanned_responses
from cable_tracker.cable.compiled.statistics import mean_and_covariance
from cable_tracker.cable.measure.scan_lines import TABLE_COUNT
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.compiled.normal import fill_normals
from cable_tracker.particle_filter.compiled.weights import normalise


@compiled
def predict(
    before: FloatArray,
    ancestors: IndexArray,
    still: FloatArray,
    time: float,
    damping: float,
    uniforms: FloatArray,
    normals: Image,
    stretches: FloatArray,
    sigmas: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    reflects: bool,
    after: FloatArray,
) -> None:
    """Write the states that the ancestors move to; see `compiled.movement` for the arguments.

    `uniforms` has a row (N,) for every two components that diffuse, and `normals`, float32, room
    for two rows for each of them, of BLOCK particles.
    """
    count, pairs = after.shape[1], len(uniforms)
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        for pair in range(pairs):
            fill_normals(uniforms[pair, start:stop], normals[pair], normals[pair + pairs])
        drift(before, ancestors, still, time, damping, after, start, stop)
        diffuse(after, normals, stretches, sigmas, start, stop)
        wrap(after, start, stop)
        keep_within(after, lower, upper, reflects, start, stop)


@compiled
def scan_frame(
    frame: Image,
    size: tuple[int, int],
    rows: IndexArray,
    columns: IndexArray,
    grid: IndexArray,
    half: Image,
    room: Image,
    along_rows: Image,
    along_columns: Image,
    scattered: Image,
) -> None:
    """Filter a frame along its lines and at its grid; see `compiled.scan_lines`.

    Without `columns` those are left out.
    """
    scan_rows(frame, size, rows, half, room, along_rows)
    if len(columns) > 0:
        scan_columns(frame, size, columns, half, room, along_columns)
    scatter_scanned_responses(frame, size, grid, half, scattered)


@compiled
def weigh_along_scan_lines(
    size: tuple[int, int],
    reduction: float,
    along_rows: Image,
    heights: Image,
    along_columns: Image,
    places: Image,
    table_step: float,
    scattered: Image,
    states: FloatArray,
    still: FloatArray,
    lying_count: int,
    lying: Image,
    borders: Image,
    epsilon: float,
    weights: FloatArray,
    deviations: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
) -> tuple[float, float]:
    """Weigh and estimate; return N_eff and the evidence.

    See `compiled.scan_lines` and `compiled.statistics` for the arguments; `borders`, float32 of
    shape (5, 2N), holds where they cross, slopes and gains, and has room for two things more.
    """
    first, slope, gain, sums, room = borders[0], borders[1], borders[2], borders[3], borders[4]
    count = len(first)
    if count > 2 * TABLE_COUNT and (lying_count == 0 or lying_count == count):
        lines, positions = (along_columns, places) if lying_count else (along_rows, heights)
        for side in range(2):
            low, high = side * (count // 2), (side + 1) * (count // 2)
            if not sum_by_table(
                lines, positions, table_step, first[low:high], slope[low:high], room, sums[low:high]
            ):
                sum_directly(
                    along_rows, heights, along_columns, places, lying_count // 2, lying[low:high],
                    first[low:high], slope[low:high], room, sums[low:high],
                )  # fmt: skip
    else:
        sum_directly(
            along_rows, heights, along_columns, places, lying_count, lying, first, slope, room, sums
        )
    for i in range(count):
        sums[i] *= gain[i]
    weigh(sums, epsilon, weights)
    effective = normalise(weights)
    mean_and_covariance(states, weights, still, deviations, mean, covariance)
    scores, counts = np.zeros(2), np.zeros(2)
    # The columns are not filtered if no border lies. Then that of the mean does not lie either.
    score_cable(mean, size, reduction, along_rows, heights, along_columns, places, scores, counts)
    return effective, border_evidence(scores, counts, scattered)


@compiled
def look_at_points(
    pixels: Image,
    frame_size: tuple[int, int],
    spacing: float,
    half: Image,
    lines: FloatArray,
    scattered: Image,
    states: FloatArray,
    still: FloatArray,
    borders: Image,
    epsilon: float,
    weights: FloatArray,
    deviations: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
) -> tuple[float, float]:
    """Weigh and estimate; return N_eff and the evidence.

    See `compiled.observation` and `compiled.statistics` for the arguments.
    """
    reduction = pixels.shape[1] / frame_size[0]
    both = 2 * len(weights)
    sums, counts = borders[0].reshape(2, both // 2), borders[1].reshape(2, both // 2)
    sum_along_borders(pixels, half, states, spacing, frame_size, reduction, sums, counts)
    weigh(borders[0], epsilon, weights)
    effective = normalise(weights)
    mean_and_covariance(states, weights, still, deviations, mean, covariance)
    scatter_responses(pixels, half, lines, scattered)
    of_mean = mean.copy().reshape(len(mean), 1)
    sum_along_borders(
        pixels, half, of_mean, spacing, frame_size, reduction, sums[:, :1], counts[:, :1]
    )
    scores, numbers = sums[:, 0].astype(np.float64), counts[:, 0].astype(np.float64)
    return effective, border_evidence(scores, numbers, scattered)
