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
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
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
        "The filter: that of the thesis, or the one of this project (see docs/algorithm.md).",
    )
    observation: str = word(
        "likelihood_ratio",
        ("responses", "likelihood_ratio"),
        "What a frame says about a cable: sums of responses as in the thesis, or learnt ratios.",
    )
    resampling: str = word(
        "systematic", tuple(RESAMPLING_SCHEMES), "How particles are drawn when resampling."
    )
    resampling_threshold: float = number(
        0.5,
        "share of N",
        0.0,
        1.0,
        "Bootstrap filter: resample when N_eff falls below this share of N.",
    )
    limit_handling: str = word(
        "reflect",
        ("clip", "reflect"),
        "Bootstrap filter: what happens to particles that move beyond a limit.",
    )
    ancestor_count: int = number(
        128, "", 8, 4096, "Particles that the next frame's are drawn about; time grows with it."
    )

    distance_variance: float = number(
        2.0, "px²/frame", 0.0, 1e4, "Squared scale of the diffusion of d (thesis, Table 5.1)."
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
        0.9, "per frame", 0.0, 1.0, "Factor on all rates per frame; 1 keeps them for ever."
    )
    diffusion_degrees_of_freedom: float = number(
        4.0,
        "",
        0.0,
        1000.0,
        "Heavy tails: of the diffusion's Student-t, nu: its variances are nu / (nu - 2) times the"
        " squared scales, twice for 4; 0 makes it Gaussian, and they are the variances.",
    )

    distance_limit: float = number(
        220.0,
        "px",
        10.0,
        1e4,
        "Largest |d| of a particle: half the diagonal of a 4:3 image is 200 px, of an upright"
        " 9:16 one 330.",
    )
    width_minimum: float = number(3.0, "px", 0.5, 1e4, "Smallest w of a particle.")
    width_maximum: float = number(240.0, "px", 1.0, 1e4, "Largest w of a particle.")
    skew_limit: float = number(30.0, "deg", 0.0, 80.0, "Largest |beta| of a particle.")

    initial_distance_range: float = number(
        190.0, "px", 0.0, 1e4, "A random start draws d from ± this (thesis, Table 5.2)."
    )
    initial_angle_range: float = number(
        90.0, "deg", 0.0, 90.0, "A random start draws alpha from ± this (Table 5.2)."
    )
    initial_width_minimum: float = number(
        4.0, "px", 0.5, 1e4, "A random start draws w from this upwards (Table 5.2)."
    )
    initial_width_maximum: float = number(
        220.0, "px", 1.0, 1e4, "A random start draws w up to this (Table 5.2)."
    )
    initial_skew_minimum: float = number(
        -27.0, "deg", -80.0, 80.0, "A random start draws beta from this upwards (Table 5.2: 0)."
    )
    initial_skew_maximum: float = number(
        27.0, "deg", -80.0, 80.0, "A random start draws beta up to this (Table 5.2)."
    )
    initial_distance_rate_range: float = number(
        1.0, "px/frame", 0.0, 1e3, "A random start draws v_d from ± this (Table 5.2)."
    )
    initial_angle_rate_range: float = number(
        0.1, "deg/frame", 0.0, 1e3, "A random start draws v_alpha from ± this (Table 5.2)."
    )

    working_width: int = number(
        320, "px", 64, 8192, "Wider frames are reduced to this width before they are measured."
    )
    sample_spacing: float = number(
        8.0,
        "px",
        1.0,
        60.0,
        "Distance between the scan lines; a border must cross three of them for a claim.",
    )
    filter_sigma: float = number(
        1.6,
        "px",
        0.5,
        20.0,
        "Sigma of the derivative-of-Gaussian filter across a border; it ends at 3 sigma.",
    )
    light_correction: float = number(
        0.5,
        "",
        0.0,
        1.0,
        "Share of uneven light (lamps, dark corners) that is taken out of a frame; 0 for none.",
    )
    burned_in_time: float = number(
        0.04,
        "s",
        0.0,
        2.0,
        "Thin straight lines that stand still for so long, such as a crosshair, are taken out of"
        " pictures at least 240 px wide; 0: nothing is.",
    )
    epsilon: float = number(
        1e-3,
        "grey levels",
        1e-12,
        10.0,
        "Responses: weight of a particle whose borders do not oppose each other.",
    )
    response_table: str = word(
        "", (), "Likelihood ratio: file written by `cable-tracker learn`; empty for our own."
    )
    tempering: float = number(
        0.1875,
        "",
        0.001,
        1.0,
        "Likelihood ratio: power of one point's ratio, for points every 5 px; 1 if they were"
        " independent.",
    )
    missing_cost: float = number(
        0.5,
        "",
        0.0,
        1.0,
        "Likelihood ratio: cost of a point outside the image, as a share of that of a point in it"
        " where no border shows.",
    )
    reversal_cost: float = number(
        3.0,
        "nats",
        0.0,
        1e3,
        "Likelihood ratio: what it costs that a stretch of a bright cable, a sixteenth of the"
        " picture's diagonal, is dark, or one of a dark cable bright, and that a cable has shorter"
        " bands. Large: a cable has no bands.",
    )
    covered_cost: float = number(
        3.0,
        "nats",
        0.0,
        1e3,
        "Likelihood ratio: what it costs that one end of a cable is covered: from some place on,"
        " borders that do not show say nothing against it. Large: no end is covered.",
    )
    polarity_memory: float = number(
        0.98, "per frame", 0.0, 1.0, "How long the cable is remembered as bright or dark."
    )
    border_displacement: float = number(
        1.0,
        "px",
        0.0,
        100.0,
        "How far growth shifts a whole border; added to the particles' covariance.",
    )

    detector: str = word(
        "line_pairs", ("none", "line_pairs"), "Whole-image detector that proposes cables."
    )
    looks: str = word(
        "network",
        ("borders", "network"),
        "What tells how much a strip looks like a cable: its borders alone, or also a network that"
        " has seen many cables.",
    )
    map_interval: float = number(
        1.0,
        "s",
        0.0,
        3600.0,
        "How often at least the network looks at a cable that is known and clear; what it said"
        " moves along with the cable for up to a second. Larger: less time per frame, but a lit"
        " stripe along a pipe may be taken for all of it. While no cable is known, a border of it"
        " is faint, or it is not where it was expected, it looks at each frame.",
    )
    map_width_share: float = number(
        0.67,
        "share",
        0.0,
        1.0,
        "How much of what the network's maps show beyond the borders of the cable is added to its"
        " width: round and overgrown cables are wider than their clearest borders. Unless it is 0,"
        " a dark shadow along a border, which maps leave out, is taken off. 0: the width is that of"
        " the borders.",
    )
    detector_share: float = number(
        0.2,
        "share of N",
        0.0,
        0.9,
        "Particles drawn about what the detector proposes; at least 0.3 while no cable is tracked,"
        " but none for 0.",
    )
    search_share: float = number(
        0.06,
        "share of what is left of N",
        0.0,
        0.9,
        "Particles that search for a cable while one is tracked, of those that neither rounds nor"
        " the detector draw.",
    )
    refinement_rounds: int = number(
        2, "", 0, 4, "Times that particles are drawn anew about the best ones of the same frame."
    )
    refinement_share: float = number(
        0.5, "share of N", 0.0, 0.9, "Particles drawn in the refinement rounds, all together."
    )

    thin_width: float = number(
        12.0,
        "px",
        0.5,
        1e4,
        "Evidence for a narrower strip counts less: any bottom has thin lines.",
    )
    evidence_limit: float = number(
        18.0,
        "nats",
        0.0,
        1e6,
        "Most that one frame's evidence for a hypothesis counts; for a new one, how much better it"
        " explains the frame than the heaviest known one.",
    )
    evidence_limit_known: float = number(
        4.0,
        "nats",
        0.0,
        1e6,
        "The same beside a cable that is known: given, or followed for `known_after`. The higher,"
        " the sooner a clearer strip elsewhere is taken for the cable.",
    )
    known_after: float = number(
        1.0,
        "s",
        0.0,
        1e6,
        "Time for which a hypothesis is held for a cable, clear enough for a first claim (see"
        " `evidence_to_find`), until it is known.",
    )
    evidence_repeated: float = number(
        0.2,
        "",
        0.0,
        1.0,
        "Share of a frame's evidence that counts for a hypothesis that goes on; 1 if frames were"
        " independent.",
    )

    presence_gain: float = number(
        0.3,
        "",
        0.0,
        1.0,
        "Share of a frame's evidence for a cable that counts again for presence.",
    )
    appearance_rate: float = number(
        0.5, "1/s", 0.0, 100.0, "How often a cable comes into view that was not."
    )
    disappearance_rate: float = number(
        0.05, "1/s", 0.0, 100.0, "How often a cable in the middle of the image is gone."
    )
    leaving_rate: float = number(
        10.0,
        "1/s",
        0.0,
        100.0,
        "How often a cable at the edge of the image leaves it; added to `disappearance_rate`.",
    )
    leaving_margin: float = number(
        8.0, "px", 0.1, 1e4, "How near to the edge of the image a cable begins to leave."
    )
    memory_time: float = number(
        4.0,
        "s",
        0.04,
        600.0,
        "Time constant with which the search for a lost cable passes from where it was lost to the"
        " whole image.",
    )
    width_spread: float = number(
        0.3,
        "",
        0.05,
        100.0,
        "Spread of log w about its running mean; large: any width will do.",
    )
    width_time: float = number(
        2.0, "s", 0.04, 600.0, "Time over which the width prior is averaged."
    )
    width_memory: float = number(
        30.0,
        "s",
        0.04,
        1e4,
        "Time without a cable in which the spread of the width prior grows by `width_spread`.",
    )
    presence_to_track: float = number(
        0.8, "", 0.0, HIGHEST_THRESHOLD, "Presence above which a cable is claimed."
    )
    presence_to_lose: float = number(
        0.42, "", 0.0, HIGHEST_THRESHOLD, "Presence below which a cable is given up at once."
    )

    evidence_to_track: float = number(
        0.0, "", -10.0, 100.0, "Evidence above which a cable is claimed (see docs/algorithm.md)."
    )
    evidence_to_find: float = number(
        0.45,
        "",
        -10.0,
        100.0,
        "Evidence, in view, above which a cable is claimed that nothing was known of, if it looks"
        " as cables do: at the start of a search, after `memory_time` without a claim, and"
        " elsewhere than the one that was tracked; more if that one had another width. By"
        " `borders` alone this is for a cable twice `thin_width` wide: narrower ones need up to"
        " three times as much, wider ones two thirds (multi_hypothesis filter).",
    )
    overlap_to_find: float = number(
        0.65,
        "",
        0.0,
        1.0,
        "How far a cable that nothing was known of and what the network takes for cable have to"
        " overlap for a claim, unless its borders are crisp: twice what both have in common over"
        " the sum of both. Less claims more, also of what is none; with two cables in view neither"
        " can have more than about two thirds (multi_hypothesis filter, `looks: network`).",
    )
    evidence_to_lose: float = number(
        -0.05, "", -10.0, 100.0, "Evidence below which a cable is given up."
    )
    confirmation_time: float = number(
        0.08, "s", 0.0, 10.0, "How long the evidence must hold before a cable is claimed."
    )
    loss_time: float = number(
        0.3, "s", 0.0, 60.0, "How long the evidence must fail before a cable is given up."
    )
    converged_distance: float = number(
        15.0, "px", 0.1, 1e4, "Largest sigma of d at which a cable is claimed."
    )
    converged_angle: float = number(
        10.0, "deg", 0.1, 90.0, "Largest sigma of alpha at which a cable is claimed."
    )
    fixture_travel: float = number(
        6.0,
        "px",
        0.0,
        1e4,
        "How far the ground moves across a strip that stands still in the picture until the strip"
        " is taken for a part of the vehicle, its shadow or its light; 0: nothing is"
        " (multi_hypothesis filter).",
    )
    search_time: float = number(
        1.0,
        "s",
        0.04,
        600.0,
        "Start anew when none has been claimed (bootstrap filter), or one that is present has not"
        " shown its borders clearly enough for a claim, for this long.",
    )
    maximum_gap: float = number(
        5.0, "s", 0.1, 3600.0, "A longer pause between frames starts the search anew."
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
