"""The one table of a target tracker's parameters.

Lengths are for an image 320 px wide and scale with the image. Variances and shares of change are
per frame at 25 frames per second and scale with the real time between frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_table import ParameterSet, number, word

MAXIMUM_SHARES = 0.95
"""Largest share of the particles that does not come from those of the frame before."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetParameters(ParameterSet):
    """All parameters of `TargetTracker`. The values here are the preset `default`.

    Raises
    ------
    ParameterError
        A value is out of range, or values contradict each other.
    """

    IN_ORDER: ClassVar[tuple[tuple[str, str], ...]] = (("presence_to_lose", "presence_to_track"),)

    particle_count: int = number(
        200, "", 1, 100_000, "Number of particles N; time per frame grows with it."
    )
    seed: int = number(
        0, "", 0, 2**31 - 1, "Seed of the random numbers; takes effect at the next start or reset."
    )
    filter: str = word(
        "poses",
        ("poses", "blobs"),
        "Particle filter: `poses` has particles that are poses, `blobs` contours as in Ha's"
        " thesis.",
    )
    detector: str = word(
        "none",
        ("none", "contours", "marching"),
        "Detector that proposes a target where none was marked (see docs/targets.md).",
    )
    working_width: int = number(
        320,
        "px",
        64,
        4096,
        "Frames wider than this are reduced to this width before they are measured; larger:"
        " finer and slower.",
    )
    ancestor_count: int = number(
        64,
        "",
        4,
        4096,
        "Number of particles of the previous frame about which new ones are drawn; time per"
        " frame grows with it.",
    )

    position_variance: float = number(
        6.0,
        "px²/frame",
        0.0,
        1e4,
        "Variance of the diffusion of x and y (Ha: 5 to 7); larger: faster movements are followed.",
    )
    scale_sigma: float = number(
        0.03, "per frame", 0.0, 1.0, "Standard deviation of the diffusion of log scale."
    )
    angle_sigma: float = number(
        3.0, "deg/frame", 0.0, 90.0, "Standard deviation of the diffusion of the angle."
    )
    jump_share: float = number(
        0.25,
        "",
        0.0,
        0.9,
        "Prior probability of a movement that the diffusion does not explain: a jerk, or lost"
        " frames.",
    )
    rate_gain: float = number(
        0.35,
        "per frame",
        0.0,
        1.0,
        "Share of an unpredicted displacement that corrects the rates; larger: faster and"
        " noisier rates.",
    )
    rate_damping: float = number(
        0.92,
        "per frame",
        0.0,
        1.0,
        "Factor by which the rates are multiplied per frame; 1: they do not decay.",
    )
    diffusion_degrees_of_freedom: float = number(
        4.0,
        "",
        1.0,
        1000.0,
        "Degrees of freedom of the diffusion's Student t-distribution; smaller: heavier tails.",
    )
    size_spread: float = number(
        0.45,
        "",
        0.01,
        100.0,
        "Scale of the logarithm of the size about its running mean; large: any size is accepted.",
    )
    size_time: float = number(
        1.0, "s", 0.04, 600.0, "Time constant of the running mean of the size."
    )

    place_share: float = number(
        0.3,
        "share of N",
        0.0,
        0.9,
        "Share of the particles drawn about peaks of the map of log-likelihood ratios.",
    )
    search_share: float = number(
        0.05,
        "share of N",
        0.0,
        0.9,
        "Share of the particles drawn where a target may come into view.",
    )
    refinement_share: float = number(
        0.3,
        "share of N",
        0.0,
        0.9,
        "Share of the particles drawn anew about the best ones of the same frame.",
    )
    place_count: int = number(
        3,
        "",
        0,
        50,
        "Number of peaks of the map of log-likelihood ratios at each scale that is searched.",
    )

    template_points: int = number(
        60,
        "",
        8,
        2000,
        "Number of points inside the shape at which a pose is scored, and of points around it.",
    )
    ratio_limit: float = number(
        2.5,
        "",
        0.1,
        20.0,
        "Largest absolute log-likelihood ratio of one pixel, target against surroundings.",
    )
    hue_weight: float = number(
        1.5,
        "",
        0.0,
        100.0,
        "Score that is added for a region whose histogram of hues equals the target's; larger:"
        " colours count more.",
    )
    grey_hue_weight: float = number(
        4.0,
        "",
        0.0,
        100.0,
        "`hue_weight` in grey pictures, for the histogram of grey levels and texture.",
    )
    sharpness: float = number(
        10.0,
        "",
        0.1,
        1000.0,
        "Log-weight of a particle per unit of its region's score; larger: fewer particles carry"
        " the weight.",
    )
    appearance_rate_of_target: float = number(
        0.04,
        "per frame",
        0.0,
        1.0,
        "Share of the target's learnt histogram that each frame replaces; larger: adapts and"
        " drifts faster.",
    )
    appearance_rate_around: float = number(
        0.08,
        "per frame",
        0.0,
        1.0,
        "Share of the learnt histogram of the surroundings that each frame replaces.",
    )
    first_look_share: float = number(
        0.5,
        "",
        0.0,
        1.0,
        "Share of the histogram at the start in the target's histogram; larger: less drift.",
    )
    least_separation: float = number(
        0.9,
        "",
        0.0,
        20.0,
        "Score of the marked region below which a start is refused, because the target does not"
        " stand out from its surroundings.",
    )

    contour_regulariser: float = number(
        0.35,
        "",
        0.0,
        100.0,
        "Cost of a neighbouring pixel on the other side of the contour, in units of the"
        " log-ratio; larger: smoother contours.",
    )
    contour_iterations: int = number(
        12, "", 1, 10_000, "Largest number of iterations of a contour."
    )
    prior_softness: float = number(
        0.1,
        "root of area",
        0.001,
        10.0,
        "Distance from the expected outline at which the odds of the shape prior are e : 1;"
        " larger: contours may depart farther from it.",
    )
    grey_prior_softness: float = number(
        0.07,
        "root of area",
        0.001,
        10.0,
        "`prior_softness` in grey pictures, which separate the target less from its surroundings.",
    )
    shape_rate: float = number(
        0.08,
        "per frame",
        0.0,
        1.0,
        "Share of the remembered shape that the contour of each frame replaces; larger: adapts"
        " and drifts faster.",
    )

    clutter_places: int = number(
        64,
        "",
        8,
        10_000,
        "Number of random places in a frame that measure the scores of its clutter.",
    )
    clutter_share: float = number(
        0.006,
        "",
        1e-6,
        1.0,
        "Share of the uniform part in the density of clutter's scores; larger: a frame gives"
        " less evidence for a target.",
    )
    grey_clutter_share: float = number(
        0.1,
        "",
        1e-6,
        1.0,
        "`clutter_share` in grey pictures, in which more clutter resembles the target.",
    )
    score_spread: float = number(
        0.15,
        "",
        0.01,
        10.0,
        "Least standard deviation of the target's usual score, relative to that score.",
    )
    evidence_limit: float = number(
        7.0,
        "",
        0.0,
        1e6,
        "Largest absolute log-likelihood ratio that a frame adds for one place [nats].",
    )
    likeness_limit: float = number(
        3.0,
        "",
        0.0,
        1e6,
        "Largest absolute log-likelihood ratio that the colours inside the contour add per"
        " frame [nats].",
    )
    likeness_spread: float = number(
        0.15,
        "",
        0.001,
        1.0,
        "Least standard deviation of the likeness of the target to its histogram, which is 0 to 1.",
    )
    grey_likeness_spread: float = number(
        0.04,
        "",
        0.001,
        1.0,
        "`likeness_spread` in grey pictures, in which other regions are nearly as alike.",
    )
    appearance_rate: float = number(
        2.5, "1/s", 0.0, 100.0, "Rate at which a target comes into view; larger: claimed sooner."
    )
    disappearance_rate: float = number(
        0.25,
        "1/s",
        0.0,
        100.0,
        "Rate at which a target in the middle of the image disappears; larger: given up sooner.",
    )
    leaving_rate: float = number(
        10.0,
        "1/s",
        0.0,
        100.0,
        "Rate at which a target at the edge of the image leaves it; added to `disappearance_rate`.",
    )
    leaving_margin: float = number(
        6.0,
        "px",
        0.1,
        1e4,
        "Distance to the edge of the image below which a target begins to leave.",
    )
    memory_time: float = number(
        4.0,
        "s",
        0.04,
        600.0,
        "Time constant with which the search for a lost target widens from where it was lost to"
        " the whole image.",
    )
    presence_to_track: float = number(
        0.95,
        "",
        0.0,
        0.998,
        "Probability of presence above which a target is claimed; larger: fewer and later claims.",
    )
    presence_to_lose: float = number(
        0.5, "", 0.0, 0.998, "Probability of presence below which a target is given up."
    )
    confirmation_time: float = number(
        0.08, "s", 0.0, 10.0, "Time for which presence must suffice until a target is claimed."
    )
    loss_time: float = number(
        0.08, "s", 0.0, 60.0, "Time for which presence must fall short until a target is given up."
    )
    converged_position: float = number(
        0.5,
        "root of area",
        0.01,
        100.0,
        "Largest standard deviation of x and y with which a target is claimed.",
    )
    maximum_gap: float = number(
        5.0,
        "s",
        0.1,
        3600.0,
        "Longest pause between two frames; after a longer one the search begins anew.",
    )

    blob_weights: str = word(
        "eq30",
        ("eq30", "product", "likelihood_ratio"),
        "Blobs: weights of the particles by Ha's (30) as printed, by the product in his text,"
        " or by a likelihood ratio.",
    )
    blob_model: str = word(
        "generic",
        ("generic", "near_horizon", "boundary"),
        "Blobs: contour model of Ha's section 6.2, 6.5 or 6.6.",
    )
    blob_iterations: int = number(
        5, "", 1, 1000, "Blobs: number of iterations of a particle's contour."
    )
    blob_contrast: float = number(
        0.1,
        "",
        0.0,
        1.0,
        "Blobs: difference of the mean levels inside and outside above which a contour evolves.",
    )
    blob_shape_limit: float = number(
        25.0,
        "px²",
        0.0,
        1e6,
        "Blobs: largest shape energy with which a contour becomes the prior of the next frame"
        " (our choice).",
    )

    def with_detector(self) -> Self:
        """Return these parameters with a detector, for a start without a mark."""
        return self.replaced({"detector": "contours"}) if self.detector == "none" else self

    def check_together(self) -> None:
        """Refuse shares that leave no particles to follow the target.

        Raises
        ------
        ParameterError
            They do.
        """
        shares = self.place_share + self.search_share + self.refinement_share
        if shares > MAXIMUM_SHARES:
            raise ParameterError(
                "place_share + search_share + refinement_share must not exceed"
                f" {MAXIMUM_SHARES:g}, not {shares:g}: the rest follows the target"
            )
