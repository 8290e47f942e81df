"""Parameters of a tracker from a preset, a file, and single values on the command line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.model.initial_state_text import RANDOM
from cable_tracker.commands.console.terminal import print_note
from cable_tracker.errors import ParameterError
from cable_tracker.followed_kinds import CABLE, TARGET, FollowedKind
from cable_tracker.node_parameter_tables import CableVehicleParameters, TargetVehicleParameters
from cable_tracker.tracking.parameter_files import parse_parameters, read_parameter_file
from cable_tracker.tracking.parameter_table import (
    Parameters,
    ParameterSet,
    parameter_table,
)

OF_TARGETS = {"initial_target", "target_count", "target_size"}
VEHICLE_NAMES = {
    spec.name
    for kind in (CableVehicleParameters, TargetVehicleParameters)
    for spec in parameter_table(kind)
} - OF_TARGETS
TEXTS = {
    spec.name
    for spec in (*CABLE.table, *TARGET.table, *CABLE.of_node, *TARGET.of_node)
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
    {spec.name for spec in (*CABLE.of_node, *TARGET.of_node)}
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


def single_values(assignments: Iterable[str] | None) -> dict[str, object]:
    """Read single values as of `parse_value`; notes say which of them do nothing.

    Raises
    ------
    ParameterError
        One of them cannot be read.
    """
    values = dict(map(parse_value, assignments or ()))
    _note_unread(values.keys(), ((OF_NODES_ALONE, "only nodes read this"), *UNREAD))
    return values


def chosen_parameters(
    kind: FollowedKind[Parameters],
    preset_name: str | None,
    file: Path | None,
    single: Mapping[str, object],
    seed: int | None,
) -> tuple[dict[str, object], Parameters]:
    """Combine preset, values of the user, and seed; notes say which of the file's do nothing.

    Parameters
    ----------
    kind : FollowedKind
        What is followed.
    preset_name : str or None
        Preset of the option `--preset`; one that stands among the values wins.
    file : Path or None
        Parameter file.
    single : mapping of str to object
        Single values by name, see `single_values`, which win over those of the file.
    seed : int or None
        Seed of the option `--seed`, which wins over one among the values.

    Returns
    -------
    dict, ParameterSet
        Values of the file and single ones by name, and the parameters of the filter.

    Raises
    ------
    ParameterError
        The file cannot be read, there is no such preset, a name is unknown, or a value is not
        acceptable.
    """
    of_file = read_parameter_file(file, kind.node) if file is not None else {}
    values = {**of_file, **single}
    parameters = kind.with_values(_base_name(kind, preset_name, values), values)
    _note_unread(of_file.keys() - single.keys(), UNREAD)
    if seed is not None:
        parameters = parameters.replaced({"seed": seed})
    for remark in parameters.remarks():
        print_note(remark)
    return values, parameters


def _note_unread(names: Set[str], kinds: Iterable[tuple[Set[str], str]]) -> None:
    """Say which names are of a kind that commands do not read, and why."""
    for kind, why in kinds:
        unread = names & kind
        if unread:
            print_note(f"{', '.join(sorted(unread))}: {why}")


def _base_name(
    kind: FollowedKind[ParameterSet], option: str | None, values: Mapping[str, object]
) -> str:
    """Return the preset to start from; values win over the option, which a note says."""
    if option is not None:
        kind.preset(option)
    if "preset" not in values:
        return option or "default"
    named = str(values["preset"])
    if option not in {None, named}:
        print_note(f"the preset {named} is used, which the parameters name, not --preset {option}")
    return named


def chosen_start(init: str | None, values: dict[str, object]) -> str:
    """Return the words that say where to start; the option wins over the parameter file."""
    return init if init is not None else str(values.get("initial_state", RANDOM))
