"""Normal random numbers in bulk, from uniform ones by the transform of Box and Muller (1958).

A uniform number of 53 bits makes two normal ones: its first 26 bits the radius, the rest the
direction. That reaches six standard deviations, and can be done for many numbers at a time.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray

RADIUS_BITS = 26
RADIUS_STEPS = float(2**RADIUS_BITS)


def normals_from_uniforms(uniforms: FloatArray) -> FloatArray:
    """Return twice as many standard normal numbers, shape (2n,), from uniform ones, shape (n,).

    The uniform numbers are at least 0 and below 1.
    """
    scaled = uniforms * RADIUS_STEPS
    steps = np.floor(scaled)
    # One step up, for the logarithm of zero is none.
    radius = np.sqrt(-2.0 * np.log((steps + 1.0) / RADIUS_STEPS))
    direction = 2.0 * np.pi * (scaled - steps)
    return np.concatenate((radius * np.cos(direction), radius * np.sin(direction)))


def uniform_rows(rows: int) -> int:
    """Return how many rows of uniform numbers make as many rows of normal ones."""
    return (rows + 1) // 2


def standard_normals(rng: np.random.Generator, rows: int, count: int) -> FloatArray:
    """Draw standard normal numbers, shape (rows, count).

    Of the numbers that a uniform one makes, the second stands half of the rows further down.
    """
    pairs = uniform_rows(rows)
    normals = normals_from_uniforms(rng.random(pairs * count))
    return normals.reshape(2 * pairs, count)[:rows]
