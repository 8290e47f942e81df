"""Estimates of the cables that clusters of particles stand for: means and covariance.

Borders may lie elsewhere than where the likelihood sees them. Growth, shadow, sand and the
roundness of a cable shift a border as a whole, by the same in frame after frame; particles agree on
the wrong place then. Mostly it is one border of the two, and what the frame shows of that one says
how far. Besides, smoothed borders push each other outwards.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.belief import Hypotheses
from cable_tracker.cable.hypotheses.clusters import Clusters
from cable_tracker.cable.measure.map.cable_map import AS_THE_STRIP, MapBorders
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.geometry import wrap_state, wrapped_estimate
from cable_tracker.cable.model.state import DISTANCE, POSE_SIZE, STATE_SIZE, WIDTH, CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

SMALLEST_HYPOTHESIS = 0.01
"""Minimum mass of a cluster that is reported; the leading one always is."""

CLEAR_LOG_RATIO, HALVING_LOG_RATIO = 1.8, 0.25
"""Sigma of the displacement = `border_displacement` 2^((CLEAR - e) / HALVING), e the mean
log-likelihood ratio per point of the border [nats]."""

USUAL_MOST, MOST_OF_WIDTH, FARTHEST = 4.0, 0.25, 12.0
"""Upper bound of that factor: a quarter of the width, at least 4 and at most 12 px at the reference
width. With more, the borders of sigma points would change places."""

BORDER_TURN = math.radians(0.4)
"""Turn of a border that is displaced by one pixel of the reference width [rad]."""

ROUND_BORDER = 0.5
"""Distance of each border of a round cable inwards from its silhouette, as a factor on
`border_displacement`: the cable's brightness falls off towards the silhouette."""

POSE_OF_BORDERS = np.array(
    [[0.5, 0.5, 0.0, 0.0], [0.0, 0.0, 0.5, 0.5], [-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, -0.5, 0.5]]
)
"""Jacobian (4, 4) of d, alpha, w, beta with respect to left offset, right offset, left angle, right
angle."""

BLUR = 1.5
"""Sigma of what blurs borders besides the filter: water, lens, and the likelihood, which cannot
tell places a pixel apart [px at the reference width]."""

WIDENING, THIN_WIDTH = 0.58, 3.5
"""How much wider than a cable the likelihood sees it, WIDENING exp(-(W / THIN_WIDTH)^2), W its
width as it is seen: smoothed borders push each other outwards [sigmas of what smooths them].
Fitted to crisp strips of even seeds up to 500."""

RESOLVED_WIDENING = 0.5
"""Widening by maps that is less than they resolve [px at the reference width]."""

SHADOW_DOUBT = 0.4
"""Standard deviation of the width of a shadow that is taken off, or of a part that is added, as a
share of it."""

MAP_DOUBT, MOST_MAP_DOUBT, SMALLEST_OVERLAP = 0.57, 0.2, 0.1
"""Sigma of a border over its distance from that of the map, its upper bound as a share of the
width, and the overlap that is reckoned with at least. Round, lit and overgrown cables, of which the
borders that are seen are not those of the cable, overlap less with their maps than flat ones.
Chosen on two held-out simulators, AH and AI, where two thirds to four fifths of the widths lay
within 1.96 sigma without it."""

LEAST_WIDTH_SHARE = 0.6
"""Minimum width of a cable as a share of the width that is seen."""


def leading_estimate(
    hypotheses: Hypotheses, by_map: MapBorders, parameters: TrackerParameters, frame_scale: float
) -> tuple[FloatArray, FloatArray]:
    """Return mean (8,) and covariance (8, 8) of the leading cluster alone.

    `by_map`: where maps show its borders; not used if `map_width_share` is 0.
    """
    if parameters.map_width_share == 0.0:
        by_map = AS_THE_STRIP
    leader = hypotheses.clusters.means[0]
    displaced = displaced_covariance(
        hypotheses.covariance,
        hypotheses.leading_mean_borders,
        float(leader[WIDTH]),
        parameters,
        frame_scale,
    )
    # A map resolves a shadow, or what lies beyond a stripe, to one cell at best.
    doubts = SHADOW_DOUBT * np.array([by_map.left_rim, by_map.right_rim])
    variances = doubts**2 + map_doubt(hypotheses) ** 2
    offsets = POSE_OF_BORDERS[:, :2]
    displaced[:POSE_SIZE, :POSE_SIZE] += offsets * variances @ offsets.T
    return wrapped_estimate(_estimated(leader, by_map, parameters, frame_scale), displaced)


def map_doubt(hypotheses: Hypotheses) -> float:
    """Return the sigma of each border of the leader for what it and the map disagree on [px].

    0 without a map. If one of a strip and what the map shows contains the other, and their overlap
    is o, either border of the map lies w (1 - o) / o beside that of the strip.
    """
    if not hypotheses.is_mapped:
        return 0.0
    overlap = max(hypotheses.overlap_share, SMALLEST_OVERLAP)
    doubt = min(MAP_DOUBT * (1.0 - overlap) / overlap, MOST_MAP_DOUBT)
    return doubt * float(hypotheses.clusters.means[0, WIDTH])


def width_by_map(widening: float, parameters: TrackerParameters, frame_scale: float) -> float:
    """Return what is added to the width by borders for how much wider maps show the cable [px].

    Nothing where they show it narrower: of a cable that sand covers in part they show the rest.
    """
    return parameters.map_width_share * max(widening - RESOLVED_WIDENING * frame_scale, 0.0)


def _estimated(
    mean: FloatArray, by_map: MapBorders, parameters: TrackerParameters, frame_scale: float
) -> FloatArray:
    """Return a cluster's mean (8,) with the width that the cable has, not that of its borders.

    Shadows beside it, which `by_map` tells, are no part of it; what lies beyond a stripe is.
    """
    state = mean.copy()
    width = width_before_smoothing(float(state[WIDTH]), parameters, frame_scale)
    state[WIDTH] = width + width_by_map(by_map.widening, parameters, frame_scale)
    state[WIDTH] -= by_map.left_rim + by_map.right_rim
    state[DISTANCE] += 0.5 * (by_map.left_rim - by_map.right_rim)
    return state


def reported_hypotheses(
    clusters: Clusters, leader: FloatArray, parameters: TrackerParameters, frame_scale: float
) -> tuple[Hypothesis, ...]:
    """Return the clusters that are worth mention, and in any case the first, which is `leader`."""
    masses = clusters.masses.tolist()
    reported = [Hypothesis(masses[0], CableState.from_array(leader))]
    for mass, mean in zip(masses[1:], clusters.means[1:], strict=True):
        if mass >= SMALLEST_HYPOTHESIS:
            state = _estimated(mean, AS_THE_STRIP, parameters, frame_scale)
            reported.append(Hypothesis(mass, CableState.from_array(wrap_state(state))))
    return tuple(reported)


def width_before_smoothing(
    width: float, parameters: TrackerParameters, frame_scale: float
) -> float:
    """Return the width of a cable that the likelihood sees `width` wide [px].

    Parameters
    ----------
    width : float
        Width W between the borders that the likelihood sees [px].
    parameters : TrackerParameters
        `filter_sigma`.
    frame_scale : float
        See `WorkingImage`.
    """
    sigma = math.hypot(parameters.filter_sigma, BLUR) * frame_scale
    widening = WIDENING * sigma * math.exp(-((width / (THIN_WIDTH * sigma)) ** 2))
    return max(width - widening, LEAST_WIDTH_SHARE * width)


def displaced_covariance(
    covariance: FloatArray,
    border_means: FloatArray,
    width: float,
    parameters: TrackerParameters,
    frame_scale: float,
) -> FloatArray:
    """Return the covariance (8, 8) of an estimate whose borders may be displaced.

    Tempering inflates the particle covariance for errors that are common along a border. That
    common error is modelled here as a displacement, so the inflation is undone (factor `tempering`
    on the pose block) before the displacement is added.

    Parameters
    ----------
    covariance : FloatArray
        Covariance of the particles of the leading cluster, shape (8, 8).
    border_means : FloatArray
        Mean log-likelihood ratios per point of the left and of the right border, shape (2,).
    width : float
        Width of the cable [px].
    parameters : TrackerParameters
        `border_displacement` and `tempering`.
    frame_scale : float
        See `WorkingImage`.
    """
    factors = displacement_factors(border_means, width / frame_scale)
    border = parameters.border_displacement * frame_scale
    turn = parameters.border_displacement * BORDER_TURN
    sigmas = np.concatenate((factors * border, factors * turn))
    displaced: FloatArray = covariance * _tempering_of_covariances(parameters.tempering)
    displaced[:POSE_SIZE, :POSE_SIZE] += POSE_OF_BORDERS * sigmas**2 @ POSE_OF_BORDERS.T
    displaced[WIDTH, WIDTH] += (2.0 * ROUND_BORDER * border) ** 2
    return displaced


@cache
def _tempering_of_covariances(tempering: float) -> FloatArray:
    """Return the factors on a covariance (8, 8) that undo its inflation by tempering."""
    scales = np.ones(STATE_SIZE)
    scales[:POSE_SIZE] = math.sqrt(tempering)
    return np.outer(scales, scales)


def displacement_factors(border_means: FloatArray, width: float) -> FloatArray:
    """Return the sigmas of the displacements of borders in units of `border_displacement`.

    `border_means` are mean log-likelihood ratios per point [nats], `width` that of the cable [px at
    the reference width]. The result has the shape of `border_means`.
    """
    largest = min(max(MOST_OF_WIDTH * width, USUAL_MOST), FARTHEST)
    doublings = (CLEAR_LOG_RATIO - border_means) / HALVING_LOG_RATIO
    factors: FloatArray = np.exp2(np.minimum(doublings, math.log2(largest)))
    return factors
