"""Knowledge of a page about its subject: a cable, or a target with an outline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cable_tracker.cable.model.state import COMPONENTS, POSE_SIZE
from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE, TrackerParameters
from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.errors import ParameterError
from cable_tracker.gui.subject.parameter_groups import CABLE_GROUPS, TARGET_GROUPS, Groups
from cable_tracker.node_parameter_tables import (
    TARGET_NODE_PARAMETERS,
    TARGET_RUNTIME_PARAMETERS,
    TRACKER_NODE_PARAMETERS,
    TRACKER_RUNTIME_PARAMETERS,
)
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.parameters.presets import TARGET_PRESETS
from cable_tracker.tracking.parameter_table import (
    ParameterSet,
    ParameterSpec,
    ParameterValue,
    parameter_table,
)
from cable_tracker.visualisation import palette
from cable_tracker.visualisation.palette import Colour

LayerToggle = tuple[str, str, Colour, float]
"""Name of a layer, words, colour, and opacity of the colour's sample."""

Lane = tuple[str, float]
"""Title of a lane of the history, and the least span of its axis."""


@dataclass(frozen=True, slots=True)
class Subject:
    """Subject that is followed, as the page shows it.

    Attributes
    ----------
    noun : str
        Noun for the subject.
    node : str
        Name of the node that follows it, and of its section in files.
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
    parameters : type
        Class of the filter's parameters.
    table : tuple of ParameterSpec
        The filter's parameters.
    runtime, of_node : tuple of ParameterSpec
        Parameters of the node: those that can be changed while it runs, and all.
    presets : mapping
        Presets by name.
    groups : Groups
        Groups of the parameters.
    """

    noun: str
    node: str
    shape: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    least_spans: tuple[float, ...]
    truths: int
    lanes: tuple[Lane, Lane]
    layers: tuple[LayerToggle, ...]
    parameters: type[ParameterSet]
    table: tuple[ParameterSpec, ...]
    runtime: tuple[ParameterSpec, ...]
    of_node: tuple[ParameterSpec, ...]
    presets: Mapping[str, ParameterSet]
    groups: Groups

    def references(self) -> dict[str, dict[str, ParameterValue]]:
        """Return what values can be compared with: the presets, by name."""
        return {name: each.as_mapping() for name, each in self.presets.items()}

    def own_parameters(self, values: Mapping[str, ParameterValue]) -> ParameterSet:
        """Return the parameters of the filter among the values of a session."""
        known = {spec.name for spec in self.table}
        return self.parameters().replaced(
            {name: value for name, value in values.items() if name in known}
        )

    def preset(self, name: str) -> ParameterSet:
        """Return a preset.

        Raises
        ------
        ParameterError
            There is none of this name.
        """
        if name not in self.presets:
            raise ParameterError(
                f"preset {name!r} is none of those of a {self.noun}: {' | '.join(self.presets)}"
            )
        return self.presets[name]

    def session_table(self, *, is_live: bool) -> Sequence[ParameterSpec]:
        """Return what can be changed while it runs."""
        return (*self.table, *self.runtime) if is_live else self.table


CABLE = Subject(
    noun="cable",
    node="tracker",
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
    parameters=TrackerParameters,
    table=PARAMETER_TABLE,
    runtime=TRACKER_RUNTIME_PARAMETERS,
    of_node=TRACKER_NODE_PARAMETERS,
    presets=PRESETS,
    groups=CABLE_GROUPS,
)

TARGET = Subject(
    noun="target",
    node="target_tracker",
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
    parameters=TargetParameters,
    table=parameter_table(TargetParameters),
    runtime=TARGET_RUNTIME_PARAMETERS,
    of_node=TARGET_NODE_PARAMETERS,
    presets=TARGET_PRESETS,
    groups=TARGET_GROUPS,
)
