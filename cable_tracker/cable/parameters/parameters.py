"""The one table of tracker parameters.

ROS descriptors, validation, the preset files in config/ and the page in docs/ are all made from it.
Lengths are for an image 320 px wide and scale with the image. Variances and rates are per frame at
25 frames per second, as in the thesis, and scale with the real time between frames.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from cable_tracker.errors import ParameterError
from cable_tracker.particle_filter.particles import RESAMPLING_SCHEMES
from cable_tracker.tracking.parameter_table import (
    ParameterSet,
    ParameterSpec,
    number,
    parameter_table,
    word,
)

MAXIMUM_PARTICLES = 1_000_000

HIGHEST_PRESENCE_LOG_ODDS = 5.0
"""Upper limit of the log-odds that there is a cable [nats]: more could not turn again in time."""

HIGHEST_THRESHOLD = math.floor(1e3 / (1.0 + math.exp(-HIGHEST_PRESENCE_LOG_ODDS))) / 1e3
"""Largest threshold of presence that presence can reach: its upper limit, rounded down."""

BORDER_SWITCH_SHARE = 0.06
"""Share of the particles that share a border with the hypothesis that leads, and no more."""

LEAST_SURVIVOR_SHARE = 0.04
"""Least share of the particles that is drawn about those of the frame before."""

ROUNDING = 1e-9
"""By which a sum of shares may be off."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerParameters(ParameterSet):
    """All parameters of `CableTracker`. The values here are the preset `default`.

    Raises
    ------
    ParameterError
        A value is out of range, or values contradict each other.
    """

    IN_ORDER: ClassVar[tuple[tuple[str, str], ...]] = (
        ("width_minimum", "width_maximum"),
        ("initial_width_minimum", "initial_width_maximum"),
        ("initial_skew_minimum", "initial_skew_maximum"),
        ("evidence_to_lose", "evidence_to_track"),
        ("presence_to_lose", "presence_to_track"),
    )

    particle_count: int = number(
        500, "", 1, MAXIMUM_PARTICLES, "Number of particles N; time per frame grows with it."
    )
    seed: int = number(
        0, "", 0, 2**31 - 1, "Seed of the random numbers; takes effect at the next start or reset."
    )
    filter: str = word(
        "multi_hypothesis",
        ("bootstrap", "multi_hypothesis"),
        "Particle filter: `bootstrap` is that of the thesis, `multi_hypothesis` that of this"
        " project (see docs/algorithm.md).",
    )
    observation: str = word(
        "likelihood_ratio",
        ("responses", "likelihood_ratio"),
        "Likelihood of a frame: `responses` sums filter responses along both borders, as in the"
        " thesis; `likelihood_ratio` sums learnt log-likelihood ratios.",
    )
    resampling: str = word("systematic", tuple(RESAMPLING_SCHEMES), "Resampling scheme.")
    resampling_threshold: float = number(
        0.5,
        "share of N",
        0.0,
        1.0,
        "Bootstrap filter: resample when N_eff falls below this share of N; larger: more often.",
    )
    limit_handling: str = word(
        "reflect",
        ("clip", "reflect"),
        "Bootstrap filter: particles beyond a limit are set to it (`clip`) or mirrored at it"
        " (`reflect`).",
    )
    ancestor_count: int = number(
        128,
        "",
        8,
        4096,
        "Number of particles of the previous frame about which new ones are drawn; time per"
        " frame grows with it.",
    )

    distance_variance: float = number(
        2.0,
        "px²/frame",
        0.0,
        1e4,
        "Squared scale of the diffusion of d (thesis, Table 5.1); larger: faster movements are"
        " followed, with a larger covariance.",
    )
    angle_variance: float = number(
        0.3, "deg²/frame", 0.0, 1e3, "Squared scale of the diffusion of alpha (Table 5.1)."
    )
    width_variance: float = number(
        1.0, "px²/frame", 0.0, 1e4, "Squared scale of the diffusion of w (Table 5.1)."
    )
    skew_variance: float = number(
        0.1, "deg²/frame", 0.0, 1e3, "Squared scale of the diffusion of beta (Table 5.1)."
    )
    distance_rate_variance: float = number(
        2.0, "px²/frame", 0.0, 1e4, "Squared scale of the diffusion of v_d, a rate in px per frame."
    )
    angle_rate_variance: float = number(
        0.05,
        "deg²/frame",
        0.0,
        1e3,
        "Squared scale of the diffusion of v_alpha, a rate in deg per frame.",
    )
    width_rate_variance: float = number(
        1.0, "px²/frame", 0.0, 1e4, "Squared scale of the diffusion of v_w (thesis, section 6.1)."
    )
    skew_rate_variance: float = number(
        0.02, "deg²/frame", 0.0, 1e3, "Squared scale of the diffusion of v_beta (section 6.1)."
    )
    rate_damping: float = number(
        0.9,
        "per frame",
        0.0,
        1.0,
        "Factor by which all rates are multiplied per frame; 1: they do not decay.",
    )
    diffusion_degrees_of_freedom: float = number(
        4.0,
        "",
        0.0,
        1000.0,
        "Degrees of freedom nu of the diffusion's Student t-distribution, whose variances are"
        " nu / (nu - 2) times the squared scales; smaller: heavier tails; 0: Gaussian, with the"
        " squared scales as variances.",
    )

    distance_limit: float = number(
        220.0,
        "px",
        10.0,
        1e4,
        "Largest |d| of a particle; half the diagonal of a 4:3 image is 200 px, of an upright"
        " 9:16 image 330 px.",
    )
    width_minimum: float = number(3.0, "px", 0.5, 1e4, "Smallest w of a particle.")
    width_maximum: float = number(240.0, "px", 1.0, 1e4, "Largest w of a particle.")
    skew_limit: float = number(30.0, "deg", 0.0, 80.0, "Largest |beta| of a particle.")

    initial_distance_range: float = number(
        190.0, "px", 0.0, 1e4, "Random start: d is uniform in ± this value (thesis, Table 5.2)."
    )
    initial_angle_range: float = number(
        90.0, "deg", 0.0, 90.0, "Random start: alpha is uniform in ± this value (Table 5.2)."
    )
    initial_width_minimum: float = number(
        4.0, "px", 0.5, 1e4, "Random start: lower limit of w (Table 5.2)."
    )
    initial_width_maximum: float = number(
        220.0, "px", 1.0, 1e4, "Random start: upper limit of w (Table 5.2)."
    )
    initial_skew_minimum: float = number(
        -27.0, "deg", -80.0, 80.0, "Random start: lower limit of beta (Table 5.2: 0)."
    )
    initial_skew_maximum: float = number(
        27.0, "deg", -80.0, 80.0, "Random start: upper limit of beta (Table 5.2)."
    )
    initial_distance_rate_range: float = number(
        1.0, "px/frame", 0.0, 1e3, "Random start: v_d is uniform in ± this value (Table 5.2)."
    )
    initial_angle_rate_range: float = number(
        0.1, "deg/frame", 0.0, 1e3, "Random start: v_alpha is uniform in ± this value (Table 5.2)."
    )

    working_width: int = number(
        320,
        "px",
        64,
        8192,
        "Frames wider than this are reduced to this width before they are measured; larger:"
        " finer and slower.",
    )
    sample_spacing: float = number(
        8.0,
        "px",
        1.0,
        60.0,
        "Distance between scan lines; larger: coarser and faster. A border must cross three of"
        " them for a claim.",
    )
    filter_sigma: float = number(
        1.6,
        "px",
        0.5,
        20.0,
        "Sigma of the derivative-of-Gaussian filter across a border, truncated at 3 sigma;"
        " larger: less noise, but thin strips blur.",
    )
    light_correction: float = number(
        0.5,
        "",
        0.0,
        1.0,
        "Share of uneven illumination (lamps, dark corners) that is removed from a frame; 0: none.",
    )
    burned_in_time: float = number(
        0.04,
        "s",
        0.0,
        2.0,
        "Time for which a thin straight line, such as a crosshair, must stand still until it is"
        " removed from frames at least 240 px wide; 0: no line is removed.",
    )
    epsilon: float = number(
        1e-3,
        "grey levels",
        1e-12,
        10.0,
        "Observation `responses`: weight of a particle whose borders have responses of the same"
        " sign.",
    )
    response_table: str = word(
        "",
        (),
        "Observation `likelihood_ratio`: path of a response table from `cable-tracker learn`;"
        " empty: the table of this package.",
    )
    tempering: float = number(
        0.1875,
        "",
        0.001,
        1.0,
        "Observation `likelihood_ratio`: exponent of the likelihood ratio of one border point,"
        " for points every 5 px; 1: points are independent; smaller: each counts less.",
    )
    missing_cost: float = number(
        0.5,
        "",
        0.0,
        1.0,
        "Observation `likelihood_ratio`: cost of a border point outside the image, relative to"
        " that of a point inside it where no border shows.",
    )
    reversal_cost: float = number(
        3.0,
        "nats",
        0.0,
        1e3,
        "Observation `likelihood_ratio`: cost of each stretch of a cable, a sixteenth of the"
        " image's diagonal long, that is dark on a bright cable or bright on a dark one, and of"
        " shorter bands all along; large: cables have no bands.",
    )
    covered_cost: float = number(
        3.0,
        "nats",
        0.0,
        1e3,
        "Observation `likelihood_ratio`: cost of the hypothesis that one end of a cable is"
        " covered, where missing borders then do not count; large: no end is covered.",
    )
    polarity_memory: float = number(
        0.98,
        "per frame",
        0.0,
        1.0,
        "Factor per frame on the deviation of the probability that the cable is bright from"
        " 0.5; 1: its polarity is never forgotten.",
    )
    border_displacement: float = number(
        1.0,
        "px",
        0.0,
        100.0,
        "Standard deviation by which growth displaces a whole border; added to the covariance"
        " of the particles.",
    )

    detector: str = word(
        "line_pairs",
        ("none", "line_pairs"),
        "Whole-image detector that proposes cables to the filter.",
    )
    looks: str = word(
        "network",
        ("borders", "network"),
        "What measures how much a strip looks like a cable: `borders` only its borders,"
        " `network` also a neural network's map of the frame.",
    )
    map_interval: float = number(
        1.0,
        "s",
        0.0,
        3600.0,
        "Longest time between two runs of the network on a cable that is known and clear; in"
        " between, its last map moves along with the cable for up to 1 s. Larger: less time per"
        " frame, but a lit stripe along a pipe may be taken for the whole pipe. While no cable"
        " is known, one of its borders is faint, or it is not where it was expected, the network"
        " runs on each frame.",
    )
    map_width_share: float = number(
        0.67,
        "share",
        0.0,
        1.0,
        "Share of the width that the network's maps show beyond the cable's borders that is"
        " added to its width: round and overgrown cables are wider than their clearest borders."
        " Above 0, a dark shadow along a border, which maps leave out, is subtracted, and where"
        " the borders are those of a stripe or flank, the cable that the map shows replaces it."
        " 0: the width between the borders.",
    )
    detector_share: float = number(
        0.2,
        "share of N",
        0.0,
        0.9,
        "Share of the particles drawn about the detector's proposals; at least 0.3 while no"
        " cable is tracked, unless it is 0.",
    )
    search_share: float = number(
        0.06,
        "share of what is left of N",
        0.0,
        0.9,
        "Share of the particles that search for a cable while one is tracked, of those that"
        " neither refinement rounds nor the detector draw.",
    )
    refinement_rounds: int = number(
        2,
        "",
        0,
        4,
        "Number of rounds that draw particles anew about the best ones of the same frame.",
    )
    refinement_share: float = number(
        0.5,
        "share of N",
        0.0,
        0.9,
        "Share of the particles drawn in all refinement rounds together.",
    )

    thin_width: float = number(
        12.0,
        "px",
        0.5,
        1e4,
        "Width below which a strip's evidence counts less, because any sea bed has thin lines;"
        " larger: fewer claims of thin strips.",
    )
    evidence_limit: float = number(
        18.0,
        "nats",
        0.0,
        1e6,
        "Largest log-likelihood ratio that one frame adds for a hypothesis; for a new one, that"
        " above the ratio of the heaviest known hypothesis.",
    )
    evidence_limit_known: float = number(
        4.0,
        "nats",
        0.0,
        1e6,
        "`evidence_limit` while a cable is known: given, or followed for `known_after`; larger:"
        " a clearer strip elsewhere is taken for the cable sooner.",
    )
    known_after: float = number(
        1.0,
        "s",
        0.0,
        1e6,
        "Time for which a hypothesis must be clear enough for a first claim (see"
        " `evidence_to_find`) until the cable is known.",
    )
    evidence_repeated: float = number(
        0.2,
        "",
        0.0,
        1.0,
        "Share of a frame's evidence that counts for a hypothesis that continues from the"
        " previous frame; 1: frames are independent.",
    )

    presence_gain: float = number(
        0.3,
        "",
        0.0,
        1.0,
        "Share of a frame's evidence for a cable that counts for presence; 1: frames are"
        " independent.",
    )
    appearance_rate: float = number(
        0.5, "1/s", 0.0, 100.0, "Rate at which a cable comes into view; larger: claimed sooner."
    )
    disappearance_rate: float = number(
        0.05,
        "1/s",
        0.0,
        100.0,
        "Rate at which a cable in the middle of the image disappears; larger: given up sooner.",
    )
    leaving_rate: float = number(
        10.0,
        "1/s",
        0.0,
        100.0,
        "Rate at which a cable at the edge of the image leaves it; added to `disappearance_rate`.",
    )
    leaving_margin: float = number(
        8.0,
        "px",
        0.1,
        1e4,
        "Distance to the edge of the image below which a cable begins to leave.",
    )
    memory_time: float = number(
        4.0,
        "s",
        0.04,
        600.0,
        "Time constant with which the search for a lost cable widens from where it was lost to"
        " the whole image.",
    )
    width_spread: float = number(
        0.3,
        "",
        0.05,
        100.0,
        "Scale of log w about its running mean in the width prior; large: any width is accepted.",
    )
    width_time: float = number(
        2.0, "s", 0.04, 600.0, "Time constant of the running mean of log w in the width prior."
    )
    width_memory: float = number(
        30.0,
        "s",
        0.04,
        1e4,
        "Time without a cable in which the scale of the width prior grows by `width_spread`.",
    )
    presence_to_track: float = number(
        0.8,
        "",
        0.0,
        HIGHEST_THRESHOLD,
        "Probability of presence above which a cable is claimed; larger: fewer and later claims.",
    )
    presence_to_lose: float = number(
        0.42,
        "",
        0.0,
        HIGHEST_THRESHOLD,
        "Probability of presence below which a cable is given up at once.",
    )

    evidence_to_track: float = number(
        0.0,
        "",
        -10.0,
        100.0,
        "Evidence above which a cable is claimed (see docs/algorithm.md); larger: fewer claims.",
    )
    evidence_to_find: float = number(
        0.45,
        "",
        -10.0,
        100.0,
        "Evidence inside the image above which a new cable is claimed that looks like one: at"
        " the start of a search, after `memory_time` without a claim, and away from the tracked"
        " cable; more is needed if its width differs from that of the tracked one. With `looks:"
        " borders` it holds for a strip twice `thin_width` wide; narrower strips need up to"
        " three times as much, wider ones two thirds. Larger: fewer first claims"
        " (multi_hypothesis filter).",
    )
    overlap_to_find: float = number(
        0.65,
        "",
        0.0,
        1.0,
        "Least overlap between a new cable and the network's map for a claim, unless its"
        " borders are crisp: twice the common area over the sum of both areas. Smaller: more"
        " claims, also false ones; with two cables in view neither reaches more than about two"
        " thirds (multi_hypothesis filter, `looks: network`).",
    )
    evidence_to_lose: float = number(
        -0.05, "", -10.0, 100.0, "Evidence below which a cable is given up after `loss_time`."
    )
    confirmation_time: float = number(
        0.08, "s", 0.0, 10.0, "Time for which the evidence must suffice until a cable is claimed."
    )
    loss_time: float = number(
        0.3,
        "s",
        0.0,
        60.0,
        "Time for which the evidence must fall short until a cable is given up.",
    )
    converged_distance: float = number(
        15.0, "px", 0.1, 1e4, "Largest standard deviation of d with which a cable is claimed."
    )
    converged_angle: float = number(
        10.0, "deg", 0.1, 90.0, "Largest standard deviation of alpha with which a cable is claimed."
    )
    fixture_travel: float = number(
        6.0,
        "px",
        0.0,
        1e4,
        "Distance that the ground moves across a strip that stands still in the image until the"
        " strip is taken for a part of the vehicle, its shadow or its light; 0: never"
        " (multi_hypothesis filter).",
    )
    search_time: float = number(
        1.0,
        "s",
        0.04,
        600.0,
        "Time after which the search begins anew: without a claim (bootstrap filter), or while"
        " a cable is present whose borders are too faint for a claim.",
    )
    maximum_gap: float = number(
        5.0,
        "s",
        0.1,
        3600.0,
        "Longest pause between two frames; after a longer one the search begins anew.",
    )

    @property
    def files(self) -> tuple[Path, ...]:
        """Files that parameters name: what comes out depends on their content."""
        return (Path(self.response_table),) if self.response_table else ()

    @property
    def uses_map(self) -> bool:
        """Whether frames are looked at through the network that maps cables."""
        return self.filter == "multi_hypothesis" and self.looks == "network"

    def check_together(self) -> None:
        """Refuse parts that do not go together."""
        if self.filter == "multi_hypothesis" and self.observation != "likelihood_ratio":
            raise ParameterError(
                "filter = multi_hypothesis needs observation = likelihood_ratio, and observation ="
                f" {self.observation} needs filter = bootstrap; set both together"
            )
        if 0.0 < self.diffusion_degrees_of_freedom < 1.0:
            raise ParameterError(
                "diffusion_degrees_of_freedom must be 0 (Gaussian) or at least 1, not"
                f" {self.diffusion_degrees_of_freedom:g}"
            )
        survivors = self._survivor_share()
        if survivors < LEAST_SURVIVOR_SHARE - ROUNDING:
            raise ParameterError(
                f"detector_share = {self.detector_share:g} and refinement_share ="
                f" {self.refinement_share:g} of the particles, and search_share ="
                f" {self.search_share:g} of what they leave, leave"
                f" {max(survivors, 0.0):.2g} of the particles to follow the cable; leave at least"
                f" {LEAST_SURVIVOR_SHARE:g} ({BORDER_SWITCH_SHARE:g} go to its borders)"
            )

    def _survivor_share(self) -> float:
        """Return the share of the particles about those of the frame before, beside a cable."""
        rest = 1.0 - BORDER_SWITCH_SHARE - self.detector_share - self.refinement_share
        return rest * (1.0 - self.search_share)

    def remarks(self) -> tuple[str, ...]:
        """Say which values are accepted but hardly meant, one sentence each.

        A search that begins outside the limits of a particle is no contradiction, because one
        limit alone may be changed: only what of it lies within them is searched.
        """
        remarks = []
        if self.initial_width_maximum > self.width_maximum:
            remarks.append(
                f"initial_width_maximum = {self.initial_width_maximum:g} is above width_maximum ="
                f" {self.width_maximum:g}: nothing wider than that is followed;"
                " raise width_maximum too"
            )
        if self.initial_width_minimum < self.width_minimum:
            remarks.append(
                f"initial_width_minimum = {self.initial_width_minimum:g} is below width_minimum ="
                f" {self.width_minimum:g}: nothing narrower than that is followed;"
                " lower width_minimum too"
            )
        return tuple(remarks)


PARAMETER_TABLE: tuple[ParameterSpec, ...] = parameter_table(TrackerParameters)
"""All parameters, in the order in which people should read them."""

PARAMETERS_BY_NAME: Mapping[str, ParameterSpec] = {spec.name: spec for spec in PARAMETER_TABLE}
