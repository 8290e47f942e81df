"""Properties of what a page shows: a cable, or a target with an outline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cable_tracker import followed_kinds
from cable_tracker.cable.model.state import COMPONENTS, POSE_SIZE
from cable_tracker.followed_kinds import FollowedKind
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterSpec, ParameterValue
from cable_tracker.visualisation import palette
from cable_tracker.visualisation.palette import Colour

LayerToggle = tuple[str, str, Colour, float]
"""Name of a layer, words, colour, and opacity of the colour's sample."""

Groups = tuple[tuple[str, str], ...]
"""Titles of groups of parameters, and the parameter of the table that each begins with."""

Lane = tuple[str, float]
"""Title of a lane of the history, and the least span of its axis."""


@dataclass(frozen=True, slots=True)
class Subject:
    """Subject that is followed, as the page shows it.

    Attributes
    ----------
    kind : FollowedKind
        Its node, and the parameters of that.
    noun : str
        Noun for the subject.
    shape : str
        Shape that the user draws as a start: `line` or `box`.
    names, units : tuple of str
        Names and units of the components of the state.
    least_spans : tuple of float
        Smallest spans of the axes of their plots.
    truths : int
        Number of components, from the first, that may have a ground truth.
    lanes : tuple of Lane
        The two components that the history shows.
    layers : tuple of LayerToggle
        Layers drawn on the picture.
    groups : Groups
        Groups of the parameters in the page's order, last of those that only a node has.
    """

    kind: FollowedKind[ParameterSet]
    noun: str
    shape: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    least_spans: tuple[float, ...]
    truths: int
    lanes: tuple[Lane, Lane]
    layers: tuple[LayerToggle, ...]
    groups: Groups

    def references(self) -> dict[str, dict[str, ParameterValue]]:
        """Return the presets by name, with which the values in force can be compared."""
        return {name: each.as_mapping() for name, each in self.kind.presets.items()}

    def session_table(self, *, is_live: bool) -> Sequence[ParameterSpec]:
        """Return the parameters that can be changed while the session runs."""
        return (*self.kind.table, *self.kind.runtime) if is_live else self.kind.table


CABLE = Subject(
    kind=followed_kinds.CABLE,
    noun="cable",
    shape="line",
    names=tuple(each.greek for each in COMPONENTS),
    units=tuple(each.unit for each in COMPONENTS),
    least_spans=(20.0, 4.0, 20.0, 4.0, 40.0, 10.0, 40.0, 10.0),
    truths=POSE_SIZE,
    lanes=(("d px", 20.0), ("α deg", 4.0)),
    layers=(
        ("particles", "particles", palette.PARTICLES, 1.0),
        ("estimate", "borders", palette.ESTIMATE, 1.0),
        ("centreline", "centreline", palette.ESTIMATE, 0.7),
        ("band", "2σ band", palette.ESTIMATE, 0.35),
        ("hypotheses", "others", palette.HYPOTHESES, 1.0),
        ("truth", "truth", palette.TRUTH, 1.0),
        ("picture", "picture", palette.GREY, 1.0),
    ),
    groups=(
        ("Filter", "particle_count"),
        ("Movement", "distance_variance"),
        ("Observation", "working_width"),
        ("Limits of a particle", "distance_limit"),
        ("Random start", "initial_distance_range"),
        ("Search and refinement", "detector"),
        ("Presence", "thin_width"),
        ("Claiming a cable", "presence_to_track"),
        ("Node", "initial_state"),
    ),
)

TARGET = Subject(
    kind=followed_kinds.TARGET,
    noun="target",
    shape="box",
    names=("x", "y", "scale", "angle", "v_x", "v_y"),
    units=("px", "px", "", "deg", "px/s", "px/s"),
    least_spans=(20.0, 20.0, 0.2, 10.0, 40.0, 40.0),
    truths=0,
    lanes=(("x px", 20.0), ("y px", 20.0)),
    layers=(
        ("particles", "particles", palette.PARTICLES, 1.0),
        ("box", "box", palette.ESTIMATE, 1.0),
        ("contour", "contour", palette.AMBER, 1.0),
        ("band", "2σ of the centre", palette.ESTIMATE, 0.35),
        ("truth", "truth", palette.TRUTH, 1.0),
        ("picture", "picture", palette.GREY, 1.0),
    ),
    groups=(
        ("Filter", "particle_count"),
        ("Movement", "position_variance"),
        ("Search and refinement", "place_share"),
        ("Appearance", "template_points"),
        ("Contour", "contour_regulariser"),
        ("Presence", "clutter_places"),
        ("Claiming a target", "presence_to_track"),
        ("Blobs (preset thesis)", "blob_weights"),
        ("Node", "initial_target"),
    ),
)
