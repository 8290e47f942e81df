"""How a frame changes the belief, and whether it speaks for claiming the cable.

A claim that is there is kept by the evidence for the leading hypothesis. For the first one it has
to be clear, by its borders or by a map: the claim score is the clearness of the weaker border plus
a term for the appearance. The conditions of a first claim:

- The score reaches what is needed at the width: more for a thin hypothesis than for a wide one, see
  `needed_clearness`. With a map, a score by the map that reaches `evidence_to_find` suffices.
- With a map, the appearance is that of a cable, unless the hypothesis is wide and its borders are
  crisp.
- Of a wide hypothesis with a border that is not clear by itself, both borders are in view: a single
  edge may be where other ground begins.
- With a map, and if the hypothesis was not followed before, enough of what the map shows is the
  hypothesis, unless its borders are crisp, see `is_lost_in_map`.
"""

from __future__ import annotations

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.filter_interface import BeliefSummary
from cable_tracker.cable.hypotheses.belief import (
    Belief,
    Hypotheses,
    RememberedCable,
    is_familiar,
    remember,
)
from cable_tracker.cable.hypotheses.cluster_estimates import leading_estimate, reported_hypotheses
from cable_tracker.cable.hypotheses.conclusion import Conclusion
from cable_tracker.cable.hypotheses.evidence_correction import ORDINARY_APPEARANCE
from cable_tracker.cable.hypotheses.presence import LIKELY_PRESENCE, trusted_share
from cable_tracker.cable.measure.borders.border_points import MINIMUM_LENGTH
from cable_tracker.cable.measure.map.cable_map import NO_KEPT_MAP
from cable_tracker.cable.model.geometry import lengths_inside, project_borders
from cable_tracker.cable.model.state import WIDTH
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.tracking.rates import over_time

APPEARANCE_SHARE = 0.5
"""Claim score that one nat of appearance by the borders is worth [nats per point]."""

LEAST_APPEARANCE, MOST_APPEARANCE = -0.6, 3.0
"""Limits of what counts of it above `ORDINARY_APPEARANCE` [nats]; chosen on the worlds to tune
on."""

UNLIKE_A_CABLE = 1.5
"""With a map, what looks less like a cable than this is not claimed, unless it is crisp and wide
[nats]: furrows, ripples with crisp troughs, pairs of lines, soft bands."""

CRISP, CRISP_WIDTH = 1.2, 2.5
"""Clearness of the borders from which on the overlap with the map is not asked for [nats per
point], and width in units of `thin_width` from which on then nor is how the strip looks: what is
crisp looks like a cable to a person, too. Chosen on the worlds to tune on."""

MAPPED_SHARE, MOST_MAPPED = 0.6, 5.0
"""The same with a map: claim score that one nat is worth, and the upper limit. The width has no
weight then."""

WIDE, BOTH_IN_VIEW, RIM = 0.25, 0.5, 0.04
"""Width, as a share of the picture's, from which on both borders have to be in view; how much of a
border is in view at least, over that of the other; and the share of the picture's width along its
edges that does not count. Where other ground begins, the ground on one side passes for a cable."""

USUAL_WIDTH = 2.0
"""Width, in units of `thin_width`, at which the clearness that is needed is `evidence_to_find`."""

LEAST_FACTOR, MOST_FACTOR = 2.0 / 3.0, 3.0
"""Limits of the factor on `evidence_to_find`, for wide and for thin strips. Chosen on the simulated
worlds to tune on (`tune_*`) and on crisp strips."""


MEMORY_PRESENCE, MEMORY_MASS = 0.9, 0.7
"""Minimum presence and minimum mass of the leading cluster for updating the memory."""

POLARITY_DOUBT = 0.02
"""The probability that the cable is bright stays this far from 0 and 1."""


def updated_belief(
    before: Belief,
    conclusion: Conclusion,
    dt: float,
    parameters: TrackerParameters,
    image_size: tuple[int, int],
    frame_scale: float,
    *,
    was_known: bool,
) -> Belief:
    """Return the belief after a frame.

    Parameters
    ----------
    before : Belief
        Belief before the frame, aged to its time.
    conclusion : Conclusion
        Particles, clusters and log-odds after the frame, at least one cluster.
    dt : float
        Time since the frame before [s].
    parameters : TrackerParameters
        The tracker's parameters.
    image_size : (int, int)
        Width and height of the frames [px].
    frame_scale : float
        See `WorkingImage`.
    was_known : bool
        Whether the hypothesis that led before the frame was known.
    """
    hypotheses = conclusion.hypotheses
    presence = conclusion.presence
    is_known = conclusion.goes_on and was_known
    is_followed = conclusion.goes_on and before.is_followed
    is_clear = is_new_clear(hypotheses, before.memory, parameters, image_size, frame_scale) and (
        is_followed or not is_lost_in_map(hypotheses, parameters)
    )
    evidence = leading_evidence(hypotheses, parameters)
    # Place, width and polarity are learnt only from what could be claimed.
    is_learnt_from = is_known or is_clear
    believed = presence if is_learnt_from else 0.0
    memory = before.memory
    if believed >= MEMORY_PRESENCE and hypotheses.clusters.masses[0] >= MEMORY_MASS:
        leader = hypotheses.clusters.means[0]
        memory = remember(memory, leader, image_size, dt, parameters, frame_scale)
    p_bright = updated_p_bright(
        before.p_bright, conclusion.p_bright, believed, parameters.polarity_memory, dt
    )
    # Too faint to claim, or, if it is known, to keep.
    is_faint = evidence < parameters.evidence_to_lose if is_known else not is_clear
    is_too_faint = is_faint and presence >= parameters.presence_to_track
    stays_likely = conclusion.goes_on and presence >= LIKELY_PRESENCE
    return Belief(
        particles=Particles(conclusion.states, conclusion.log_weights),
        hypotheses=hypotheses,
        presence=presence,
        p_bright=p_bright,
        memory=memory,
        log_odds=conclusion.log_odds,
        faint_time=before.faint_time + dt if is_too_faint else 0.0,
        evidence=evidence,
        is_clear=is_clear,
        known_time=before.known_time + (dt if is_learnt_from else 0.0) if stays_likely else 0.0,
        is_given=before.is_given and stays_likely,
        kept_map=before.kept_map if conclusion.goes_on else NO_KEPT_MAP,
        fixture_test=before.fixture_test,
    )


def updated_p_bright(
    before: float, found: float, presence: float, memory: float, dt: float
) -> float:
    """Return the probability that the cable is bright, `dt` seconds after one `before`.

    `found`: share of the particles' weight that speaks for a bright cable; it counts as far as
    there is one, `presence`. `memory`: factor on the deviation from 0.5 per frame of 25 per second.
    """
    kept = over_time(memory, dt)
    now = presence * found + (1.0 - presence) * before
    p_bright = kept * now + (1.0 - kept) * 0.5
    return float(min(max(p_bright, POLARITY_DOUBT), 1.0 - POLARITY_DOUBT))


def belief_summary(
    belief: Belief, parameters: TrackerParameters, frame_scale: float
) -> BeliefSummary:
    """Return what a belief says about the frame that it came from.

    `frame_scale`: see `WorkingImage`.
    """
    hypotheses = belief.hypotheses
    by_map = belief.kept_map.borders
    mean, covariance = leading_estimate(hypotheses, by_map, parameters, frame_scale)
    visible = hypotheses.visible_length >= MINIMUM_LENGTH
    familiar = is_familiar(belief, parameters, frame_scale)
    is_present = belief.presence >= parameters.presence_to_lose
    is_acceptable = visible and (belief.is_clear or familiar)
    is_claimable = (
        is_acceptable
        and belief.presence >= parameters.presence_to_track
        and belief.evidence >= parameters.evidence_to_track
    )
    return BeliefSummary(
        covariance=covariance,
        effective_sample_size=hypotheses.effective_size,
        evidence=belief.evidence,
        supports_claim=is_claimable,
        supports_new_claim=is_claimable and belief.is_clear,
        supports_keeping=is_acceptable
        and is_present
        and belief.evidence >= parameters.evidence_to_lose,
        contradicts_claim=not is_present or (belief.memory is not None and not familiar),
        follows_given=belief.is_given,
        presence=belief.presence,
        hypotheses=reported_hypotheses(hypotheses.clusters, mean, parameters, frame_scale),
        event=belief.event,
    )


def is_new_clear(
    hypotheses: Hypotheses,
    memory: RememberedCable | None,
    parameters: TrackerParameters,
    image_size: tuple[int, int],
    frame_scale: float,
) -> bool:
    """Tell whether the leader fulfils the conditions of a first claim, but for `is_lost_in_map`.

    The more its width differs from that of the remembered cable, the larger the score has to be.
    `image_size`: width and height of the frames [px]; `frame_scale`: see `WorkingImage`.
    """
    if not _looks_clear(hypotheses, memory, parameters, frame_scale):
        return False
    leader = hypotheses.clusters.means[0]
    is_narrow = float(leader[WIDTH]) < WIDE * image_size[0]
    are_both_clear = hypotheses.weaker_border_mean >= parameters.evidence_to_find
    return is_narrow or are_both_clear or are_borders_in_view(leader, image_size)


def are_borders_in_view(state: FloatArray, image_size: tuple[int, int]) -> bool:
    """Tell whether each border of a cable (4 or more,) is in view as the other is.

    See `BOTH_IN_VIEW`; `image_size`: width and height of the frames [px].
    """
    borders = project_borders(state[None])
    rims = round(2.0 * RIM * image_size[0])
    # Of a flat picture the rims leave half.
    inner = (image_size[0] - rims, max(image_size[1] - rims, image_size[1] // 2))
    lengths = lengths_inside(borders.angles[0], borders.offsets[0], inner)
    return bool(lengths.min() >= BOTH_IN_VIEW * lengths.max() > 0.0)


def _looks_clear(
    hypotheses: Hypotheses,
    memory: RememberedCable | None,
    parameters: TrackerParameters,
    frame_scale: float,
) -> bool:
    """Tell whether appearance and claim score suffice for a first claim."""
    width = float(hypotheses.clusters.means[0, WIDTH])
    if is_unlike_a_cable(hypotheses, width, parameters, frame_scale):
        return False
    factor = 1.0
    if memory is not None:
        factor += memory.width_deviation(width, parameters) ** 2
    # The larger of both: a threshold below 0 must not be lowered.
    needed = needed_clearness(width, parameters, frame_scale)
    if claim_score_by_width(hypotheses, parameters, frame_scale) >= max(needed, needed * factor):
        return True
    if not hypotheses.is_mapped:
        return False
    # With a map the width does not count: it tells thin cables from thin lines.
    needed = parameters.evidence_to_find
    return claim_score_by_map(hypotheses) >= max(needed, needed * factor)


def is_unlike_a_cable(
    hypotheses: Hypotheses, width: float, parameters: TrackerParameters, frame_scale: float
) -> bool:
    """Tell whether a map says that the leader is no cable, and it is not both crisp and wide.

    `width` of the leader [px]; `frame_scale`: see `WorkingImage`.
    """
    is_wide = width >= CRISP_WIDTH * parameters.thin_width * frame_scale
    if not hypotheses.is_mapped or (is_wide and hypotheses.scaled_clearness >= CRISP):
        return False
    return hypotheses.appearance < UNLIKE_A_CABLE


def is_lost_in_map(hypotheses: Hypotheses, parameters: TrackerParameters) -> bool:
    """Tell whether the overlap of the leader with its map is too small, and it is not crisp.

    So where the network marks half of the picture as cable, nothing is claimed by it.
    """
    if not hypotheses.is_mapped or hypotheses.scaled_clearness >= CRISP:
        return False
    return hypotheses.overlap_share < parameters.overlap_to_find


def leading_evidence(hypotheses: Hypotheses, parameters: TrackerParameters) -> float:
    """Return the evidence for the leader [nats per point]: the mean of its weaker border.

    With a map, at least the claim score by the map, up to `evidence_to_find`: growth or sand may
    hide a border.
    """
    by_border = hypotheses.weaker_border_mean
    if not hypotheses.is_mapped:
        return by_border
    return max(by_border, min(claim_score_by_map(hypotheses), parameters.evidence_to_find))


def needed_clearness(width: float, parameters: TrackerParameters, frame_scale: float) -> float:
    """Return the clearness that the first claim of a cable needs [nats per point].

    `width` of the cable [px]; `frame_scale`: see `WorkingImage`.
    """
    needed = parameters.evidence_to_find
    if needed <= 0.0:
        return needed
    usual = USUAL_WIDTH * parameters.thin_width * frame_scale
    return needed * min(max(usual / max(width, 1e-9), LEAST_FACTOR), MOST_FACTOR)


def claim_score_by_width(
    hypotheses: Hypotheses, parameters: TrackerParameters, frame_scale: float
) -> float:
    """Return the claim score that is compared with `needed_clearness` [nats per point].

    With a map, the appearance is that by the map, see `appearances_of`.
    """
    width = float(hypotheses.clusters.means[0, WIDTH])
    appearance = hypotheses.appearance
    # The appearance of a thin hypothesis counts only against it, see `trusted_appearance`.
    trusted = trusted_share(width, parameters.thin_width * frame_scale)
    above = trusted * (appearance - ORDINARY_APPEARANCE) + (1.0 - trusted) * min(appearance, 0.0)
    worth = APPEARANCE_SHARE * min(max(above, LEAST_APPEARANCE), MOST_APPEARANCE)
    return hypotheses.scaled_clearness + worth


def claim_score_by_map(hypotheses: Hypotheses) -> float:
    """Return the claim score with the weights of an appearance by a map [nats per point]."""
    above = hypotheses.appearance - ORDINARY_APPEARANCE
    return hypotheses.scaled_clearness + MAPPED_SHARE * min(above, MOST_MAPPED)
