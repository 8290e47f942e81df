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
        "poses", ("poses", "blobs"), "Particles that are poses, or blobs as in Ha's thesis."
    )
    detector: str = word(
        "none",
        ("none", "contours", "marching"),
        "What proposes a target where none was marked (see docs/targets.md).",
    )
    working_width: int = number(
        320, "px", 64, 4096, "Wider frames are reduced to this width before they are measured."
    )
    ancestor_count: int = number(
        64, "", 4, 4096, "Particles that the next frame's are drawn about; time grows with it."
    )

    position_variance: float = number(
        6.0, "px²/frame", 0.0, 1e4, "Variance of the diffusion of x and y (Ha: 5 to 7)."
    )
    scale_sigma: float = number(
        0.03, "per frame", 0.0, 1.0, "Standard deviation of the diffusion of log scale."
    )
    angle_sigma: float = number(
        3.0, "deg/frame", 0.0, 90.0, "Standard deviation of the diffusion of the angle."
    )
    jump_share: float = number(
        0.25, "", 0.0, 0.9, "Share of the movements that no diffusion explains: jerks, lost frames."
    )
    rate_gain: float = number(
        0.35,
        "per frame",
        0.0,
        1.0,
        "Share of an unforeseen movement that goes into the rates.",
    )
    rate_damping: float = number(
        0.92, "per frame", 0.0, 1.0, "Factor on the rates per frame; 1 keeps them for ever."
    )
    diffusion_degrees_of_freedom: float = number(
        4.0, "", 1.0, 1000.0, "Heavy tails: of the diffusion's Student-t."
    )
    size_spread: float = number(
        0.45,
        "",
        0.01,
        100.0,
        "Spread of log scale about its running mean; large: any size will do.",
    )
    size_time: float = number(1.0, "s", 0.04, 600.0, "Time over which the usual size is averaged.")

    place_share: float = number(
        0.3, "share of N", 0.0, 0.9, "Particles drawn about peaks of the map of log-ratios."
    )
    search_share: float = number(
        0.05, "share of N", 0.0, 0.9, "Particles drawn where a target may come into view."
    )
    refinement_share: float = number(
        0.3, "share of N", 0.0, 0.9, "Particles drawn anew about the best ones of the same frame."
    )
    place_count: int = number(3, "", 0, 50, "Peaks at every scale that is looked for.")

    template_points: int = number(
        60, "", 8, 2000, "Points inside the shape that a pose is measured at, and as many around."
    )
    ratio_limit: float = number(
        2.5,
        "",
        0.1,
        20.0,
        "Largest log-likelihood ratio of one pixel, target against surroundings.",
    )
    hue_weight: float = number(
        1.5, "", 0.0, 100.0, "Score of a region whose hues are all shared as the target's are."
    )
    grey_hue_weight: float = number(
        4.0,
        "",
        0.0,
        100.0,
        "In grey pictures: score of a region whose grey levels and texture are shared as the"
        " target's are.",
    )
    sharpness: float = number(
        10.0, "", 0.1, 1000.0, "Log-weight of a particle per unit of its region's score."
    )
    appearance_rate_of_target: float = number(
        0.04, "per frame", 0.0, 1.0, "How fast the learnt histogram of the target follows."
    )
    appearance_rate_around: float = number(
        0.08, "per frame", 0.0, 1.0, "How fast the learnt histogram of the surroundings follows."
    )
    first_look_share: float = number(
        0.5, "", 0.0, 1.0, "Share of the target's histogram that stays that of the start."
    )
    least_separation: float = number(
        0.9, "", 0.0, 20.0, "Score of a region below which a target does not stand out at all."
    )

    contour_regulariser: float = number(
        0.35, "", 0.0, 100.0, "Cost of a neighbour on the other side, in units of the log-ratio."
    )
    contour_iterations: int = number(12, "", 1, 10_000, "Iterations of a contour at most.")
    prior_softness: float = number(
        0.1,
        "root of area",
        0.001,
        10.0,
        "Distance from the expected outline at which the odds of the shape prior are e : 1.",
    )
    grey_prior_softness: float = number(
        0.07,
        "root of area",
        0.001,
        10.0,
        "`prior_softness` in grey pictures, where less tells the target from what is beside it.",
    )
    shape_rate: float = number(
        0.08, "per frame", 0.0, 1.0, "How fast the remembered shape follows the contour."
    )

    clutter_places: int = number(
        64, "", 8, 10_000, "Random places of a frame that say how its clutter scores."
    )
    clutter_share: float = number(
        0.006,
        "",
        1e-6,
        1.0,
        "Share of clutter that has any score at all, like the target's or not.",
    )
    grey_clutter_share: float = number(
        0.1,
        "",
        1e-6,
        1.0,
        "`clutter_share` in grey pictures, where more looks like the target.",
    )
    score_spread: float = number(
        0.15, "", 0.01, 10.0, "Least spread of the target's usual score, as a share of it."
    )
    evidence_limit: float = number(
        7.0, "", 0.0, 1e6, "A frame's evidence for one place counts up to this."
    )
    likeness_limit: float = number(
        3.0, "", 0.0, 1e6, "Evidence of the colours within the contour counts up to this a frame."
    )
    likeness_spread: float = number(
        0.15, "", 0.001, 1.0, "Least spread of the target's likeness to itself."
    )
    grey_likeness_spread: float = number(
        0.04,
        "",
        0.001,
        1.0,
        "`likeness_spread` in grey pictures, where much else is nearly as like.",
    )
    appearance_rate: float = number(
        2.5, "1/s", 0.0, 100.0, "How often a target comes into view that was not."
    )
    disappearance_rate: float = number(
        0.25, "1/s", 0.0, 100.0, "How often a target in the middle of the image is gone."
    )
    leaving_rate: float = number(
        10.0,
        "1/s",
        0.0,
        100.0,
        "How often a target at the edge of the image leaves it; added to `disappearance_rate`.",
    )
    leaving_margin: float = number(
        6.0, "px", 0.1, 1e4, "How near to the edge of the image a target begins to leave."
    )
    memory_time: float = number(
        4.0,
        "s",
        0.04,
        600.0,
        "Time constant with which the search for a lost target passes from where it was lost to"
        " the whole image.",
    )
    presence_to_track: float = number(
        0.95, "", 0.0, 0.998, "Presence above which a target is claimed."
    )
    presence_to_lose: float = number(
        0.5, "", 0.0, 0.998, "Presence below which a target is given up."
    )
    confirmation_time: float = number(
        0.08, "s", 0.0, 10.0, "How long the presence must hold before a target is claimed."
    )
    loss_time: float = number(
        0.08, "s", 0.0, 60.0, "How long the presence must fail before a target is given up."
    )
    converged_position: float = number(
        0.5, "root of area", 0.01, 100.0, "Largest sigma of x and y at which a target is claimed."
    )
    maximum_gap: float = number(5.0, "s", 0.1, 3600.0, "A longer pause between frames starts anew.")

    blob_weights: str = word(
        "eq30",
        ("eq30", "product", "likelihood_ratio"),
        "Blobs: weights by Ha's (30) as printed, the product that his text says, or a ratio.",
    )
    blob_model: str = word(
        "generic",
        ("generic", "near_horizon", "boundary"),
        "Blobs: Ha's sections 6.2, 6.5 or 6.6.",
    )
    blob_iterations: int = number(5, "", 1, 1000, "Blobs: iterations of a particle's contour.")
    blob_contrast: float = number(
        0.1, "", 0.0, 1.0, "Blobs: difference of the means above which a contour evolves."
    )
    blob_shape_limit: float = number(
        25.0,
        "px²",
        0.0,
        1e6,
        "Blobs: shape energy below which a contour becomes the prior (our choice).",
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
