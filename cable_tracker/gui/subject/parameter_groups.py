"""The parameters in groups, as the window shows them."""

from __future__ import annotations

from collections.abc import Sequence

from cable_tracker.tracking.parameter_table import ParameterSpec

Groups = tuple[tuple[str, tuple[str, ...]], ...]
"""Titles, and names of parameters."""

CABLE_GROUPS: Groups = (
    (
        "Filter",
        (
            "particle_count", "seed", "filter", "observation",
            "resampling", "resampling_threshold", "limit_handling", "ancestor_count",
        ),
    ),
    (
        "Movement",
        (
            "distance_variance", "angle_variance", "width_variance", "skew_variance",
            "distance_rate_variance", "angle_rate_variance", "width_rate_variance",
            "skew_rate_variance", "rate_damping", "diffusion_degrees_of_freedom",
        ),
    ),
    (
        "Observation",
        (
            "working_width", "sample_spacing", "filter_sigma", "light_correction",
            "burned_in_time", "epsilon",
            "response_table", "tempering", "missing_cost",
            "reversal_cost", "covered_cost", "polarity_memory", "border_displacement",
        ),
    ),
    ("Limits of a particle", ("distance_limit", "width_minimum", "width_maximum", "skew_limit")),
    (
        "Random start",
        (
            "initial_distance_range", "initial_angle_range", "initial_width_minimum",
            "initial_width_maximum", "initial_skew_minimum", "initial_skew_maximum",
            "initial_distance_rate_range", "initial_angle_rate_range",
        ),
    ),
    (
        "Search and refinement",
        (
            "detector", "looks", "map_interval", "map_width_share", "detector_share",
            "search_share", "refinement_rounds", "refinement_share",
        ),
    ),
    (
        "Presence",
        (
            "thin_width", "evidence_limit", "evidence_limit_known", "known_after",
            "evidence_repeated", "presence_gain", "appearance_rate", "disappearance_rate",
            "leaving_rate", "leaving_margin", "memory_time", "width_spread", "width_time",
            "width_memory",
        ),
    ),
    (
        "Claiming a cable",
        (
            "presence_to_track", "presence_to_lose", "evidence_to_track", "evidence_to_find",
            "overlap_to_find", "evidence_to_lose", "confirmation_time", "loss_time",
            "converged_distance", "converged_angle", "fixture_travel", "search_time",
            "maximum_gap",
        ),
    ),
)  # fmt: skip

TARGET_GROUPS: Groups = (
    (
        "Filter",
        (
            "particle_count", "seed", "filter", "detector", "working_width", "ancestor_count",
            "place_share", "search_share", "refinement_share", "place_count",
        ),
    ),
    (
        "Movement",
        (
            "position_variance", "scale_sigma", "angle_sigma", "jump_share", "rate_gain",
            "rate_damping", "diffusion_degrees_of_freedom", "size_spread", "size_time",
        ),
    ),
    (
        "Appearance",
        (
            "template_points", "ratio_limit", "hue_weight", "grey_hue_weight", "sharpness",
            "appearance_rate_of_target", "appearance_rate_around", "first_look_share",
            "least_separation",
        ),
    ),
    (
        "Contour",
        (
            "contour_regulariser", "contour_iterations", "prior_softness", "grey_prior_softness",
            "shape_rate",
        ),
    ),
    (
        "Presence",
        (
            "clutter_places", "clutter_share", "grey_clutter_share", "score_spread",
            "evidence_limit", "likeness_limit", "likeness_spread", "grey_likeness_spread",
            "appearance_rate", "disappearance_rate", "leaving_rate", "leaving_margin",
            "memory_time",
        ),
    ),
    (
        "Claiming a target",
        (
            "presence_to_track", "presence_to_lose", "confirmation_time", "loss_time",
            "converged_position", "maximum_gap",
        ),
    ),
    ("Blobs (preset thesis)", ("blob_weights", "blob_model", "blob_iterations", "blob_contrast",
        "blob_shape_limit")),
)  # fmt: skip

OTHERS = "Node"
"""Title of the group of those that only a node has."""


def grouped(table: Sequence[ParameterSpec], titles: Groups) -> dict[str, list[ParameterSpec]]:
    """Put the parameters of a table into groups by their titles; each is in one of them."""
    by_name = {spec.name: spec for spec in table}
    groups = {
        title: [by_name.pop(name) for name in names if name in by_name] for title, names in titles
    }
    groups[OTHERS] = list(by_name.values())
    return {title: rows for title, rows in groups.items() if rows}
