"""Parameters of the tracker from a preset, a file, and single values on the command line."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.model.initial_state_text import RANDOM
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.commands.console.terminal import messages
from cable_tracker.errors import ParameterError
from cable_tracker.node_parameter_tables import (
    METRIC_PARAMETERS,
    TARGET_METRIC_PARAMETERS,
    TARGET_NODE_PARAMETERS,
    TRACKER_NODE_PARAMETERS,
)
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.parameters.presets import target_preset
from cable_tracker.tracking.parameter_files import (
    filter_parameters,
    parse_parameters,
    read_parameter_file,
)
from cable_tracker.tracking.parameter_table import Parameters, ParameterSpec, parameter_table

OF_TARGETS = {"initial_target", "target_count", "target_size"}
VEHICLE_NAMES = {spec.name for spec in (*METRIC_PARAMETERS, *TARGET_METRIC_PARAMETERS)} - OF_TARGETS
TEXTS = {
    spec.name
    for spec in (
        *parameter_table(TrackerParameters),
        *parameter_table(TargetParameters),
        *TRACKER_NODE_PARAMETERS,
        *TARGET_NODE_PARAMETERS,
    )
    if spec.kind is str and not spec.choices
}
"""Parameters whose value is any text, as that of a path."""
UNREAD = (
    (
        OF_TARGETS,
        "only nodes read these; a command follows one target, and is told of it by --init and"
        " --target-size",
    ),
    (
        VEHICLE_NAMES,
        "only nodes read the vehicle's parameters here; for a recording they belong in"
        " vehicle.yaml",
    ),
)
"""Parameters of nodes that commands do not read, and where what they say is said instead."""
READ_FROM_NODES = {"preset", "initial_state"}
"""Parameters of nodes beside the filter's that commands read too."""
OF_NODES_ALONE = (
    {spec.name for spec in (*TRACKER_NODE_PARAMETERS, *TARGET_NODE_PARAMETERS)}
    - READ_FROM_NODES
    - OF_TARGETS
    - VEHICLE_NAMES
)
"""Parameters that a file for a node holds rightly, and that do nothing in a command."""

ValueOption = Annotated[
    list[str] | None,
    typer.Option(
        "-p",
        "--param",
        metavar="NAME=VALUE",
        help="One parameter, also as NAME:=VALUE; wins over --params. May be given several times.",
    ),
]


def parse_value(word: str) -> tuple[str, object]:
    """Read `name=value` or `name:=value`, the value in the notation of YAML.

    Raises
    ------
    ParameterError
        There is no name or no sign of equality, or the value is no YAML.
    """
    name, equals, value = word.partition("=")
    name = name.removesuffix(":").strip()
    if not (name and equals):
        raise ParameterError(f"-p {word}: give a name and a value, such as particle_count=1000")
    text = value.strip() or "''"
    if name in TEXTS and text[0] not in "'\"":
        # A path may hold what means something in YAML.
        return name, text
    return name, parse_parameters(f"{name}: {text}", f"-p {word}").get(name)


def given_values(file: Path | None, words: Iterable[str] | None) -> dict[str, object]:
    """Return the values of a parameter file and of single words, which win.

    Raises
    ------
    ParameterError
        The file or a word cannot be read.
    """
    values = read_parameter_file(file) if file is not None else {}
    single = dict(map(parse_value, words or ()))
    unread = sorted(single.keys() & OF_NODES_ALONE)
    if unread:
        messages.print(f"note: {', '.join(unread)}: only nodes read this", soft_wrap=True)
    return values | single


def chosen_parameters(
    preset_name: str | None, values: dict[str, object], seed: int | None
) -> TrackerParameters:
    """Combine preset, values of the user, and seed.

    Parameters
    ----------
    preset_name : str or None
        Preset of the option `--preset`; one that stands among the values wins.
    values : dict
        Values of `given_values`, by name.
    seed : int or None
        Seed of the option `--seed`, which wins over one among the values.

    Raises
    ------
    ParameterError
        There is no such preset, a name is unknown, or a value is not acceptable.
    """
    base = preset(_base_name(preset_name, values))
    parameters = _tuned(base, values, seed, TRACKER_NODE_PARAMETERS)
    for remark in parameters.remarks():
        messages.print(f"note: {remark}", soft_wrap=True)
    return parameters


def target_values(file: Path | None) -> dict[str, object]:
    """Return what a parameter file says of the tracker of targets; nothing without a file.

    Raises
    ------
    ParameterError
        The file cannot be read.
    """
    return read_parameter_file(file, "target_tracker") if file is not None else {}


def chosen_target(
    preset_name: str | None, values: dict[str, object], seed: int | None
) -> TargetParameters:
    """Combine preset, values and seed for a target; see `chosen_parameters`."""
    base = target_preset(_base_name(preset_name, values))
    return _tuned(base, values, seed, TARGET_NODE_PARAMETERS)


def _base_name(option: str | None, values: dict[str, object]) -> str:
    """Return the preset to start from; values win over the option, which a note says."""
    if "preset" not in values:
        return option or "default"
    named = str(values["preset"])
    if option not in {None, named}:
        messages.print(
            f"note: the preset {named} is used, which the parameters name, not --preset {option}",
            soft_wrap=True,
        )
    return named


def _tuned(
    base: Parameters,
    values: dict[str, object],
    seed: int | None,
    of_node: Iterable[ParameterSpec],
) -> Parameters:
    """Return a preset with values and seed; notes say what of the node's does nothing here."""
    parameters = filter_parameters(base, values, {spec.name for spec in of_node})
    for names, words in UNREAD:
        unread = sorted(values.keys() & names)
        if unread:
            messages.print(f"note: {', '.join(unread)}: {words}", soft_wrap=True)
    return parameters if seed is None else parameters.replaced({"seed": seed})


def chosen_start(init: str | None, values: dict[str, object]) -> str:
    """Return the words that say where to start; the option wins over the parameter file."""
    return init if init is not None else str(values.get("initial_state", RANDOM))
