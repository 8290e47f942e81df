"""Candidates: the strips among the particles that look most like cables, whatever they weigh.

A particle weighs what its place was believed and how strong its borders are: a faint cable that a
detector sees for the first time weighs next to nothing beside a furrow that has been followed for a
while, is drawn about in no round, and is never found. So a part of each round goes to the strips
that look most like cables, those that a map shows among them. They are proposals: what is drawn
about them weighs what it weighs anyway.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.propose.frame_inputs import FrameConfig, FrameInputs
from cable_tracker.cable.hypotheses.weigh.clusters import find_groups, heaviest_members
from cable_tracker.cable.measure.borders.appearance import appearances_of
from cable_tracker.compilation import compiled_part

CANDIDATE_SHARE = 0.5
"""Share of the particles of a round that are drawn about candidates."""

CANDIDATE_NARROWING = 0.5
"""Factor on the kernel scales of detections, for each round once more."""

MOST_LOOKED_AT, MOST_CANDIDATES = 12, 3
"""Numbers of particles that are looked at in a round, and of candidates among them and the strips
of the map."""


@compiled_part
def likeliest_strips(
    states: FloatArray,
    log_likelihoods: FloatArray,
    inputs: FrameInputs,
    config: FrameConfig,
) -> FloatArray:
    """Return the particles, and strips of the map, that look most like cables, shape (C, 8).

    The best one comes first. Of particles that lie together only the likeliest is looked at.

    Parameters
    ----------
    states, log_likelihoods : FloatArray
        Particles, shape (N, 8), and their log-likelihood ratios, shape (N,); -inf for impossible
        ones.
    inputs : FrameInputs
        The scanned frame, the tables of its log-likelihood ratios, its map, and the strips that
        the map shows.
    config : FrameConfig
        Radii of the clusters.
    """
    groups = find_groups(states, log_likelihoods, config.cluster_radii, MOST_LOOKED_AT, -math.inf)
    strips = states[heaviest_members(log_likelihoods, groups)]
    strips = np.concatenate((strips, inputs.predicted.births.map_strips))
    order = np.argsort(-appearances_of(strips, inputs.scan, inputs.model, inputs.cable_map))
    return strips[order[:MOST_CANDIDATES]]
