"""Fast marching: arrival times of a front that starts at seeds.

J. Ha (2008), (13) and (14), with the upwind form of Sethian (1999): the outer power in the thesis'
(14) is a misprint.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.compilation import compiled, compiled_inside


def edge_speed(image: NDArray[np.float32], sigma: float, gain: float) -> FloatArray:
    """Return the speed phi = 1/(1 + |gain grad G*I|^2): 1 on even ground, near 0 on edges.

    Parameters
    ----------
    image : array
        Intensities in [0, 1], shape (H, W).
    sigma : float
        Sigma of the Gaussian G [px].
    gain : float
        Factor on the gradient [px]; 1 in the thesis.
    """
    smooth = cv2.GaussianBlur(image, (0, 0), sigma).astype(np.float64)
    across, down = np.gradient(smooth, axis=1), np.gradient(smooth, axis=0)
    speed: FloatArray = 1.0 / (1.0 + gain**2 * (across**2 + down**2))
    return speed


@compiled_inside
def _push(heap: IndexArray, places: IndexArray, times: FloatArray, size: int, point: int) -> int:
    """Put a point into the heap, or move it up after its time has fallen; return the size."""
    index = places[point]
    if index < 0:
        index = size
        size += 1
    while index > 0:
        parent = (index - 1) // 2
        if times[heap[parent]] <= times[point]:
            break
        heap[index] = heap[parent]
        places[heap[index]] = index
        index = parent
    heap[index] = point
    places[point] = index
    return size


@compiled_inside
def _pop(heap: IndexArray, places: IndexArray, times: FloatArray, size: int) -> int:
    """Remove the earliest point; return the size."""
    size -= 1
    moved = heap[size]
    index = 0
    while True:
        child = 2 * index + 1
        if child >= size:
            break
        if child + 1 < size and times[heap[child + 1]] < times[heap[child]]:
            child += 1
        if times[heap[child]] >= times[moved]:
            break
        heap[index] = heap[child]
        places[heap[index]] = index
        index = child
    heap[index] = moved
    places[moved] = index
    return size


@compiled_inside
def _arrival(
    times: FloatArray, row: int, column: int, height: int, width: int, slow: float
) -> float:
    """Solve |grad T| = slow at one point from its earlier neighbours."""
    point = row * width + column
    across = down = math.inf
    if column > 0:
        across = min(across, times[point - 1])
    if column + 1 < width:
        across = min(across, times[point + 1])
    if row > 0:
        down = min(down, times[point - width])
    if row + 1 < height:
        down = min(down, times[point + width])
    if abs(across - down) >= slow or across == math.inf or down == math.inf:
        return min(across, down) + slow
    return 0.5 * (across + down + math.sqrt(2.0 * slow * slow - (across - down) ** 2))


@compiled
def arrival_times(speed: FloatArray, seeds: BoolArray, latest: float) -> FloatArray:
    """Return the arrival time of the front at every pixel, shape (H, W); infinite after `latest`.

    Parameters
    ----------
    speed : FloatArray
        phi, positive, shape (H, W) [px per unit of time].
    seeds : BoolArray
        Pixels of the front at time 0, of the same shape.
    latest : float
        Time at which the front stops.
    """
    height, width = speed.shape
    times = np.full(height * width, math.inf)
    places = np.full(height * width, -1, np.int64)
    heap = np.empty(height * width, np.int64)
    is_final = np.zeros(height * width, np.bool_)
    size = 0
    for row in range(height):
        for column in range(width):
            if seeds[row, column]:
                times[row * width + column] = 0.0
                size = _push(heap, places, times, size, row * width + column)
    while size > 0:
        point = heap[0]
        if times[point] > latest:
            break
        size = _pop(heap, places, times, size)
        is_final[point] = True
        row, column = point // width, point % width
        for step in range(4):
            i = row + (step == 1) - (step == 0)
            j = column + (step == 3) - (step == 2)
            if i < 0 or j < 0 or i >= height or j >= width or is_final[i * width + j]:
                continue
            time = _arrival(times, i, j, height, width, 1.0 / speed[i, j])
            if time < times[i * width + j]:
                times[i * width + j] = time
                size = _push(heap, places, times, size, i * width + j)
    for point in range(height * width):
        if not is_final[point]:
            times[point] = math.inf
    return times.reshape(height, width)
