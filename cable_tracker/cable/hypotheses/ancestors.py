"""Which particles go on to the next frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.clusters import NONE, SMALLEST_MASS, Clusters
from cable_tracker.cable.model.geometry import reach_at, unwrap_state
from cable_tracker.compilation import compiled, compiled_part
from cable_tracker.particle_filter.resampling import POSITIONS, RESAMPLING_SCHEMES
from cable_tracker.particle_filter.weights import exponentials
from cable_tracker.tracking.survival import SurvivalRates, survival_probability

SMALLEST_CLUSTER_SHARE = 0.06
"""Share of the ancestors that every cluster has, however light: so it can prove itself."""

LEAST_SURVIVING = 1e-300
"""Weight of an ancestor that cannot have survived: of none could a mixture be made."""

NO_INDICES = np.empty(0, np.int64)


class Draw(NamedTuple):
    """How ancestors are drawn within the groups: the clusters, and the particles of none.

    Attributes
    ----------
    groups : IndexArray
        Labels of the groups that have ancestors, shape (G,).
    masses, counts : FloatArray, IndexArray
        Weight of each, and how many ancestors it has, shape (G,).
    positions : FloatArray
        Where in the cumulated weights of each group its ancestors are drawn, in ascending order
        within the group, 0 to 1, shape (M,).
    indices : IndexArray
        The ancestors themselves where a scheme has no positions, shape (M,); else (0,).
    """

    groups: IndexArray
    masses: FloatArray
    counts: IndexArray
    positions: FloatArray
    indices: IndexArray


def plan_draw(
    log_weights: FloatArray,
    clusters: Clusters,
    count: int,
    scheme: str,
    rng: np.random.Generator,
) -> Draw:
    """Share out `count` ancestors among clusters, and draw where in their weights they lie."""
    masses = np.append(clusters.masses, clusters.rest)
    labels = np.append(np.arange(len(clusters.masses)), NONE)
    kept = masses > SMALLEST_MASS
    masses, labels = masses[kept], labels[kept]
    wanted = np.maximum(masses, SMALLEST_CLUSTER_SHARE)
    counts = np.maximum(np.rint(wanted / wanted.sum() * count), 1.0).astype(np.int64)
    if scheme in POSITIONS:
        drawn = [POSITIONS[scheme](number, rng) for number in counts.tolist()]
        return Draw(labels, masses, counts, np.concatenate(drawn), NO_INDICES)
    weights, chosen = np.exp(log_weights), []
    for label, mass, number in zip(labels, masses, counts, strict=True):
        members = np.flatnonzero(clusters.labels == label)
        drawn_members = RESAMPLING_SCHEMES[scheme](weights[members] / mass, int(number), rng)
        chosen.append(members[drawn_members])
    return Draw(labels, masses, counts, np.empty(0), np.concatenate(chosen))


@compiled
def surviving_ancestors(
    states: FloatArray,
    log_weights: FloatArray,
    labels: IndexArray,
    draw: Draw,
    reference_angle: float,
    image_size: tuple[float, float],
    rates: SurvivalRates,
    dt: float,
) -> tuple[FloatArray, FloatArray, float]:
    """Return the ancestors, their weights after `dt` seconds, and the probability of survival.

    Parameters
    ----------
    states, log_weights, labels : FloatArray, FloatArray, IndexArray
        The particles, shapes (N, 8), (N,), (N,).
    draw : Draw
        How they are drawn.
    reference_angle : float
        Middle of the chart in which they are returned [rad].
    image_size : (float, float)
        Width and height of the frames [px].
    rates : SurvivalRates
        How often a cable goes out of view.
    dt : float
        Time to the next frame [s].

    Returns
    -------
    ancestors : FloatArray
        Shape (M, 8).
    weights : FloatArray
        Shape (M,), summing to one.
    survival : float
        Probability that the cable is still in view.
    """
    indices = draw.indices if len(draw.indices) else _choose(log_weights, labels, draw)
    count = len(indices)
    ancestors, surviving = np.empty((count, 8)), np.empty(count)
    first = 0
    for group in range(len(draw.counts)):
        for row in range(first, first + draw.counts[group]):
            surviving[row] = draw.masses[group] / draw.counts[group]
        first += draw.counts[group]
    wanted = 0.0
    for row in range(count):
        wanted += surviving[row]
    total = 0.0
    for row in range(count):
        surviving[row] /= wanted
        unwrap_state(states[indices[row]], reference_angle, ancestors[row])
        reach = reach_at(ancestors[row, 1], image_size[0], image_size[1])
        survival = survival_probability(reach - abs(ancestors[row, 0]), rates, dt)
        surviving[row] = max(surviving[row] * survival, LEAST_SURVIVING)
        total += surviving[row]
    for row in range(count):
        surviving[row] /= total
    return ancestors, surviving, total


@compiled_part
def _choose(log_weights: FloatArray, labels: IndexArray, draw: Draw) -> IndexArray:
    """Draw from every group its number of ancestors, by where they lie in its weights."""
    weights = exponentials(log_weights)
    indices = np.empty(len(draw.positions), np.int64)
    drawn = 0
    for group in range(len(draw.counts)):
        label, mass = draw.groups[group], draw.masses[group]
        total, last = 0.0, -1
        for row in range(len(labels)):
            if labels[row] == label:
                total += weights[row] / mass
                if weights[row] > 0.0:
                    last = row
        cumulative, row = 0.0, -1
        for _ in range(draw.counts[group]):
            position = draw.positions[drawn] * total
            while row < last and cumulative <= position:
                row += 1
                if labels[row] == label:
                    cumulative += weights[row] / mass
            indices[drawn] = row
            drawn += 1
    return indices
