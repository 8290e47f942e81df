"""The two kinds of things that are followed, and what of their parameters belongs to each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import PRESETS
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
    named,
    parameter_table,
)

KindParameters_co = TypeVar("KindParameters_co", bound=ParameterSet, covariant=True)


@dataclass(frozen=True, slots=True)
class FollowedKind(Generic[KindParameters_co]):
    """Node and parameters of the tracker of cables, or of that of targets.

    Attributes
    ----------
    node : str
        Name of the node, and of its section in parameter files.
    presets : mapping
        Presets of the filter by name.
    runtime, of_node : tuple of ParameterSpec
        Parameters of the node besides the filter's: those that can be changed while it runs, and
        all.
    """

    node: str
    presets: Mapping[str, KindParameters_co]
    runtime: tuple[ParameterSpec, ...]
    of_node: tuple[ParameterSpec, ...]

    @property
    def table(self) -> tuple[ParameterSpec, ...]:
        """The filter's parameters."""
        return parameter_table(type(self.presets["default"]))

    def preset(self, name: str) -> KindParameters_co:
        """Return a preset of the filter; a `ParameterError` if there is none of the name."""
        return named("preset", name, self.presets)

    def with_values(self, preset_name: str, values: Mapping[str, object]) -> KindParameters_co:
        """Return a preset with the values of a file, passing over those that only the node knows.

        Raises
        ------
        ParameterError
            There is no such preset, a name is neither the filter's nor the node's, or a value is
            not acceptable.
        """
        of_node = {spec.name for spec in self.of_node}
        own = {name: value for name, value in values.items() if name not in of_node}
        return self.preset(preset_name).replaced(own)


CABLE: FollowedKind[TrackerParameters] = FollowedKind(
    node="tracker",
    presets=PRESETS,
    runtime=TRACKER_RUNTIME_PARAMETERS,
    of_node=TRACKER_NODE_PARAMETERS,
)
TARGET: FollowedKind[TargetParameters] = FollowedKind(
    node="target_tracker",
    presets=TARGET_PRESETS,
    runtime=TARGET_RUNTIME_PARAMETERS,
    of_node=TARGET_NODE_PARAMETERS,
)
