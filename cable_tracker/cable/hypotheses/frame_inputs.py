"""What a frame is concluded from: what changes from frame to frame, and what is always the same.

The random numbers of a frame are drawn at once, for each particle. A particle finds its own in its
row, whatever it is drawn from, so that the order in which particles are drawn does not matter.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.births import BIRTH_TAIL
from cable_tracker.cable.hypotheses.clusters import RADII
from cable_tracker.cable.hypotheses.predicted_density import PredictedDensity
from cable_tracker.cable.hypotheses.presence import (
    LIKELY_PRESENCE,
    SAME_HYPOTHESIS_RADII,
    PriorPresence,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import PolarityPrior, RatioModel
from cable_tracker.cable.measure.map.cable_map import CableMap, ExpectedOverlap, MapWeights
from cable_tracker.cable.measure.scanned_gradients import ScanInputs
from cable_tracker.cable.model.limits import StateLimits, possible_limits
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE, pose_units
from cable_tracker.cable.parameters.parameters import (
    BORDER_SWITCH_SHARE,
    LEAST_SURVIVOR_SHARE,
    TrackerParameters,
)
from cable_tracker.particle_filter.student_t import student_t_factors
from cable_tracker.tracking.parameter_table import pixel_scale

DETECTION_SIGMAS = np.array([2.0, np.deg2rad(1.0), 2.8, np.deg2rad(1.0)])
"""Kernel scales of the proposal about a detection: d, alpha, w, beta [px at the reference width,
rad]."""

SMALLEST_SIGMAS = np.array([0.15, np.deg2rad(0.08), 0.2, np.deg2rad(0.08)])
"""Added in quadrature to the kernel scales of a round [px at the reference width, rad]."""

FIRST_POWER = 0.3
"""Power of the likelihood in the first round, also where it is the only one; in the last of several
it is 1. This annealing keeps a narrow peak from being missed."""

WIDENINGS = (1.5, 1.2)
"""Factor on the covariance of the particles that a round draws about: first round, later ones."""

SEARCH_MAP = MapWeights(overlap=11.0, lacking=7.0)
"""Weights of the map in a search. Of strips that share a border the map tells the right one, where
growth, sand and crisp shadows have stronger borders than the cable. What a strip lacks is counted
from `SLACK` below the best strip on. The first weight was chosen on the worlds to tune on
(`tune_*`), the second on a held-out simulator, AH."""

KNOWN_MAP = MapWeights(overlap=4.0, lacking=7.0)
"""Weights of the map beside a known cable, whose own borders are the better guide. A strip that
looks more like a cable, a crisp shadow for instance, gains little by the map. One that looks less
like it, such as a dark seam along a flank, loses as much as the overlap weighs in a search. Chosen
on the worlds to tune on."""

LOST_DETECTOR_SHARE = 0.3
"""Share of the particles about detections while it is more likely than not that there is none."""

LARGEST_BIRTH_SHARE = 0.8
"""Share of the particles of the prior that are born at most."""

STRIPS_ANYWHERE, STRIPS_ALIKE = 64, 96
"""Numbers of strips that measure a frame's background: of any kind, and like the hypotheses."""

ALIKE = 3
"""Number of perturbed components (alpha, log w, beta) of a strip like the hypothesis."""


class SampleCounts(NamedTuple):
    """Numbers of particles of a frame, by the proposal that they are drawn from, before its rounds.

    Attributes
    ----------
    survivors, births, switches, detections : int
        Drawn about ancestors, from the birth density, from the border-switch density, and about
        what the detector sees.
    births_about_memory : int
        Those of the births that are drawn about the remembered cable.
    """

    survivors: int
    births: int
    births_about_memory: int
    switches: int
    detections: int


def sample_counts(
    parameters: TrackerParameters,
    density: PredictedDensity,
    detections: int,
    refined: IndexArray,
) -> SampleCounts:
    """Share out the particles of a frame with some detections that its rounds leave.

    `refined`: those that each round draws, shape (R,).
    """
    count = parameters.particle_count
    switches = int(count * BORDER_SWITCH_SHARE)
    first = count - int(refined.sum()) - switches
    share = parameters.detector_share if detections else 0.0
    existing = density.mass_survived + density.mass_born
    if share > 0.0 and existing < LIKELY_PRESENCE:
        share = max(share, LOST_DETECTOR_SHARE)
    # The raised share, too, leaves something for survivors and births.
    least = max(int(count * LEAST_SURVIVOR_SHARE), 1)
    detected = min(int(count * share), max(first - least, 0))
    rest = first - detected
    born = max(density.mass_born / existing, parameters.search_share)
    births = int(rest * min(born, LARGEST_BIRTH_SHARE))
    return SampleCounts(
        survivors=rest - births,
        births=births,
        births_about_memory=round(density.births.share * births),
        switches=switches,
        detections=detected,
    )


class FrameNoise(NamedTuple):
    """Random numbers for N particles, B of which are births.

    Attributes
    ----------
    normal : FloatArray
        Standard normal, shape (N, 8): columns of the state.
    tail_factors : FloatArray
        Factors that make Student-t numbers of the normal ones, shape (N, 2): of the pose, of the
        rates.
    uniform : FloatArray
        Uniform in [0, 1), shape (N, 8): places of births in the search box. Column 0 of a particle
        whose pose is proposed chooses the ancestor that gives it its rates.
    about_memory : FloatArray
        Student-t, shape (B, 4): deviations of births from the remembered cable, in its scales.
    anywhere : FloatArray
        Uniform in [0, 1), shape (R, 4): d, alpha, w, beta of background strips of any kind.
    elsewhere : FloatArray
        Uniform in [0, 1), shape (S,): d of background strips like the hypotheses.
    alike : FloatArray
        Standard normal, shape (S, 3): deviations of alpha, log w, beta of background strips like
        the hypotheses.
    """

    normal: FloatArray
    tail_factors: FloatArray
    uniform: FloatArray
    about_memory: FloatArray
    anywhere: FloatArray
    elsewhere: FloatArray
    alike: FloatArray


def draw_frame_noise(
    rng: np.random.Generator, count: int, births: int, degrees_of_freedom: float
) -> FrameNoise:
    """Draw for `count` particles, `births` of which are born.

    `degrees_of_freedom` are those of the movement; with infinite ones they are 1.
    """
    normal = rng.standard_normal((count, STATE_SIZE))
    tail_factors = student_t_factors(rng, count, 2, degrees_of_freedom)
    return FrameNoise(
        normal,
        tail_factors,
        rng.random((count, STATE_SIZE)),
        rng.standard_t(BIRTH_TAIL, (births, POSE_SIZE)),
        rng.random((STRIPS_ANYWHERE, POSE_SIZE)),
        rng.random(STRIPS_ALIKE),
        rng.standard_normal((STRIPS_ALIKE, ALIKE)),
    )


class FrameInputs(NamedTuple):
    """What changes from frame to frame.

    Attributes
    ----------
    predicted : PredictedDensity
        The density f before the frame is looked at.
    noise : FrameNoise
        Random numbers of the frame.
    scan, model : ScanInputs, RatioModel
        The scanned frame, and the tables of its log-likelihood ratios.
    cable_map : CableMap
        The map of the frame; beside a clear known cable the kept one, moved along; `NO_MAP` without
        either.
    expected_overlap : ExpectedOverlap
        What overlaps with this map are held against.
    polarity : PolarityPrior
        Probability that a cable is brighter than the bottom.
    reference_angle : float
        Angle within pi/2 of which the normals of all particles are written [rad].
    ancestors : IndexArray
        Index of the kernel of f that each survivor is drawn from, shape (S,).
    detected : FloatArray
        d, alpha, w, beta of cables that a detector sees [px, rad], shape (K, 4).
    anchors : FloatArray
        Expected state of the leading cluster, shape (0 or 1, 8).
    counts : SampleCounts
        Numbers of particles of the frame, by the proposal that they are drawn from.
    prior : PriorPresence
        Prior of the log-odds of the hypotheses, and their expected states.
    """

    predicted: PredictedDensity
    noise: FrameNoise
    scan: ScanInputs
    model: RatioModel
    cable_map: CableMap
    expected_overlap: ExpectedOverlap
    polarity: PolarityPrior
    reference_angle: float
    ancestors: IndexArray
    detected: FloatArray
    anchors: FloatArray
    counts: SampleCounts
    prior: PriorPresence


class FrameConfig(NamedTuple):
    """What is the same in every frame with a known cable, and in every one without.

    Attributes
    ----------
    image_size : (float, float)
        Width and height of the frames [px].
    limits : StateLimits
        Limits of d, alpha, w, beta; poses beyond are impossible.
    degrees_of_freedom : float
        Degrees of freedom of the Student-t of the movement and of all proposals; infinite for a
        Gaussian.
    cluster_radii, detection_sigmas, smallest_sigmas : FloatArray
        `RADII`, `DETECTION_SIGMAS`, `SMALLEST_SIGMAS` for frames of this size, shape (4,) [px,
        rad].
    refined : IndexArray
        Number of particles that each round draws about the best ones, shape (R,).
    powers, widenings : FloatArray
        Power of the likelihood, and factor on the covariance, in each round, shape (R,).
    evidence_limit : float
        Upper bound of the log-likelihood ratio of a group of particles that counts, before the
        width penalty lowers it, and, negated, the lower bound of that of a new group against the
        reference [nats].
    evidence_repeated : float
        Share of the ratio of a surviving group that counts, 0 to 1.
    thin_width : float
        Width below which ratios count less [px of the frame].
    same_hypothesis_radii : FloatArray
        `SAME_HYPOTHESIS_RADII` for frames of this size, shape (4,) [px, rad].
    frame_scale : float
        Pixels of the frame per pixel at the reference width.
    is_known : bool
        Whether a cable is known, see `Belief.is_known`: then borders count whole, and appearance
        does not.
    map_weights : MapWeights
        How much the map of the frame counts in the likelihood.
    """

    image_size: tuple[float, float]
    limits: StateLimits
    degrees_of_freedom: float
    cluster_radii: FloatArray
    detection_sigmas: FloatArray
    smallest_sigmas: FloatArray
    refined: IndexArray
    powers: FloatArray
    widenings: FloatArray
    evidence_limit: float
    evidence_repeated: float
    thin_width: float
    same_hypothesis_radii: FloatArray
    frame_scale: float
    is_known: bool
    map_weights: MapWeights


def frame_config(
    parameters: TrackerParameters, degrees_of_freedom: float, image_size: tuple[int, int]
) -> FrameConfig:
    """Return what the parameters make of it for frames of a size [px]."""
    width, height = image_size
    frame_scale = pixel_scale(width)
    units, rounds = pose_units(frame_scale), range(parameters.refinement_rounds)
    return FrameConfig(
        image_size=(float(width), float(height)),
        limits=possible_limits(parameters, width),
        degrees_of_freedom=degrees_of_freedom,
        cluster_radii=RADII * units,
        detection_sigmas=DETECTION_SIGMAS * units,
        smallest_sigmas=SMALLEST_SIGMAS * units,
        refined=refined_counts(parameters),
        powers=np.array([annealing_power(number, len(rounds)) for number in rounds]),
        widenings=np.array([WIDENINGS[min(number, len(WIDENINGS) - 1)] for number in rounds]),
        evidence_limit=parameters.evidence_limit,
        evidence_repeated=parameters.evidence_repeated,
        thin_width=parameters.thin_width * frame_scale,
        same_hypothesis_radii=SAME_HYPOTHESIS_RADII * units,
        frame_scale=frame_scale,
        is_known=False,
        map_weights=SEARCH_MAP,
    )


def beside_a_known_cable(config: FrameConfig, parameters: TrackerParameters) -> FrameConfig:
    """Return a configuration in which other strips count less: where the cable is, is known.

    It need not look like a cable, either: it is one.
    """
    return config._replace(
        evidence_limit=parameters.evidence_limit_known, is_known=True, map_weights=KNOWN_MAP
    )


def annealing_power(number: int, rounds: int) -> float:
    """Return the power of the likelihood in a round: `FIRST_POWER` in the first, rising to 1."""
    if rounds == 1:
        return FIRST_POWER
    return float(FIRST_POWER ** (1.0 - number / (rounds - 1)))


def refined_counts(parameters: TrackerParameters) -> IndexArray:
    """Return how many particles each round draws, shape (R,): most the last, which counts most."""
    refined = parameters.refinement_share * parameters.particle_count
    rounds = parameters.refinement_rounds
    parts = [1.0] * (rounds - 1) + [1.5] if rounds else []
    return np.array([int(refined * (part / sum(parts))) for part in parts], np.int64)
