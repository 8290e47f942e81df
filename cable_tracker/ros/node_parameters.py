"""The tables of parameters as ROS parameters: declared, coerced, validated, applied as a whole."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_table import (
    Parameters,
    ParameterSet,
    ParameterSpec,
    ParameterValue,
    parameter_table,
)

QOS_PREFIX = "qos_overrides."
"""Begin of overrides that rclpy reads only where a topic asks for it, which none of ours does."""

FOREIGN_NAMES = ("use_sim_time", "start_type_description_service")
"""Overrides that rclpy itself reads."""

TOGETHER = "set both together"
"""End of a refusal where two values do not fit."""

PARAMETER_TYPES = {
    bool: Parameter.Type.BOOL,
    int: Parameter.Type.INTEGER,
    float: Parameter.Type.DOUBLE,
    str: Parameter.Type.STRING,
}


def descriptor_of(spec: ParameterSpec, *, read_only: bool) -> ParameterDescriptor:
    """Describe a parameter to ROS: meaning, unit, range, allowed words."""
    unit = f" [{spec.unit}]" if spec.unit else ""
    descriptor = ParameterDescriptor(
        name=spec.name,
        type=PARAMETER_TYPES[spec.kind].value,
        description=f"{spec.meaning}{unit}",
        additional_constraints=spec.range_text() if spec.choices else "",
        read_only=read_only,
    )
    if spec.minimum is None or spec.maximum is None:
        return descriptor
    if spec.kind is int:
        descriptor.integer_range = [
            IntegerRange(from_value=int(spec.minimum), to_value=int(spec.maximum), step=0)
        ]
    else:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=spec.minimum, to_value=spec.maximum, step=0.0)
        ]
    return descriptor


def declare(
    node: Node, spec: ParameterSpec, default: ParameterValue, *, read_only: bool = False
) -> ParameterValue:
    """Declare a parameter and return its value at start.

    A whole number in a YAML file is accepted where a float is meant: what was given is looked at
    before the parameter is declared with its own type.

    Raises
    ------
    ParameterError
        What was given at start is not acceptable.
    """
    # rclpy has no public way to what was given at the start.
    override = node._parameter_overrides.get(spec.name)
    # None is what an empty list in a YAML file turns into; it is refused like any other type.
    value = spec.coerce(default if override is None else override.value)
    descriptor = descriptor_of(spec, read_only=read_only)
    node.declare_parameter(spec.name, value, descriptor, ignore_override=True)
    return value


def declare_set(node: Node, defaults: Parameters, *, read_only: bool = False) -> Parameters:
    """Declare the parameters of a set, by default with its values; return those at start.

    Raises
    ------
    ParameterError
        What was given at start is not acceptable.
    """
    values = defaults.as_mapping()
    specs = parameter_table(type(defaults))
    return defaults.replaced(
        {spec.name: declare(node, spec, values[spec.name], read_only=read_only) for spec in specs}
    )


def warn_of_unknown_overrides(node: Node) -> None:
    """Say which names given at start the node does not have; to be called when all are declared."""
    for name in unknown_overrides(node):
        node.get_logger().warning(
            f"parameter '{name}' is ignored: of quality of service a tracker's image_reliability"
            " and instrument_reliability alone can be set"
            if name.startswith(QOS_PREFIX)
            else f"unknown parameter '{name}' is ignored; docs/parameters.md lists all"
        )


def unknown_overrides(node: Node) -> list[str]:
    """Return the names given at start (YAML file, command line) that the node does not have."""
    given: Iterable[str] = node._parameter_overrides
    return sorted(
        name for name in given if not node.has_parameter(name) and name not in FOREIGN_NAMES
    )


def is_given_at_start(node: Node, name: str) -> bool:
    """Tell whether a parameter stands in a YAML file or on the command line, with any value."""
    return name in node._parameter_overrides


def those_in(kind: type[ParameterSet], values: Mapping[str, object]) -> dict[str, object]:
    """Return the entries of `values` whose names are parameters of a parameter set."""
    own = {spec.name for spec in parameter_table(kind)}
    return {name: value for name, value in values.items() if name in own}


def with_those_in(parameters: Parameters, values: Mapping[str, object]) -> Parameters:
    """Return a set with those of some values, by name, that are its own parameters.

    Raises
    ------
    ParameterError
        A value is not acceptable, or the set contradicts itself.
    """
    return parameters.replaced(those_in(type(parameters), values))


def watch(
    node: Node,
    table: Iterable[ParameterSpec],
    apply: Callable[[Mapping[str, object]], None],
    validate: Callable[[Mapping[str, object]], object] = lambda values: None,
) -> None:
    """Apply changes at runtime; one with a value that its row of the table refuses changes nothing.

    Parameters
    ----------
    node : Node
        The node, all of whose parameters are declared.
    table : iterable of ParameterSpec
        The parameters that are watched.
    apply : callable
        Called with the changed values by name once they are accepted.
    validate : callable
        Called with the changed values by name before anything is changed; raises `ParameterError`
        to refuse all of them.
    """
    changes = _RuntimeChanges(node, table, apply, validate)
    node.add_pre_set_parameters_callback(changes.coerce)
    node.add_on_set_parameters_callback(changes.check)
    node.add_post_set_parameters_callback(changes.take)


class _RuntimeChanges:
    """Callbacks of rclpy before, at and after a change of parameters; see `watch`."""

    def __init__(
        self,
        node: Node,
        table: Iterable[ParameterSpec],
        apply: Callable[[Mapping[str, object]], None],
        validate: Callable[[Mapping[str, object]], object],
    ) -> None:
        self._node = node
        self._specs = {spec.name: spec for spec in table}
        self._apply, self._validate = apply, validate
        self._before: dict[str, object] = {}

    def coerce(self, parameters: list[Parameter]) -> list[Parameter]:
        """Return the parameters with values of their own types, where they can be converted."""
        return [_coerced(parameter, self._specs) for parameter in parameters]

    def check(self, parameters: list[Parameter]) -> SetParametersResult:
        """Accept or refuse a change, and keep the values from before it."""
        values = self._watched(parameters)
        try:
            for name, value in values.items():
                self._specs[name].coerce(value)
            self._validate(values)
        except ParameterError as error:
            reason = _with_advice(str(error), len(values))
            return SetParametersResult(successful=False, reason=reason)
        self._before = {name: self._node.get_parameter(name).value for name in values}
        return SetParametersResult(successful=True)

    def take(self, parameters: list[Parameter]) -> None:
        """Log and apply a change that was accepted."""
        values = self._watched(parameters)
        changes = [
            f"{name} {self._before[name]} -> {value}"
            for name, value in values.items()
            if value != self._before[name]
        ]
        if changes:
            self._node.get_logger().info(f"parameters changed: {', '.join(changes)}")
        self._apply(values)

    def _watched(self, parameters: Sequence[Parameter]) -> dict[str, object]:
        return {each.name: each.value for each in parameters if each.name in self._specs}


def _with_advice(reason: str, count: int) -> str:
    """Say how two values are set together, where only one of them was given.

    The service ``set_parameters`` gives them one after the other, and so does ``ros2 param``.
    """
    if count == 1 and reason.endswith(TOGETHER):
        return f"{reason} with set_parameters_atomically, or the other first"
    return reason


def _coerced(parameter: Parameter, specs: Mapping[str, ParameterSpec]) -> Parameter:
    spec = specs.get(parameter.name)
    if spec is None:
        return parameter
    try:
        return Parameter(parameter.name, value=spec.coerce(parameter.value))
    except ParameterError:
        # The checks that follow refuse it, with the reason. That of a whole number where a float is
        # meant is its range, not its type.
        if spec.kind is float and parameter.type_ is Parameter.Type.INTEGER:
            return Parameter(parameter.name, value=float(parameter.value))
        return parameter
