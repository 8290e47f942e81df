"""`cable-tracker parameters`."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer
from rich.padding import Padding
from rich.text import Text

from cable_tracker.atomic_output import output_file
from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE, TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.commands.console.terminal import console
from cable_tracker.commands.options.common import ForceOption, PresetName
from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_files import (
    format_parameter_file,
    read_parameter_file,
)
from cable_tracker.tracking.parameter_table import ParameterSpec


class ParameterFormat(str, Enum):
    """How `parameters` prints."""

    TABLE = "table"
    YAML = "yaml"


def parameters(
    preset_name: Annotated[
        PresetName, typer.Option("--preset", help="Whose values to print.")
    ] = PresetName["default"],
    output_format: Annotated[
        ParameterFormat, typer.Option("--format", help="A list to read, or a file for the node.")
    ] = ParameterFormat.TABLE,
    output: Annotated[
        Path | None, typer.Option(help="Write the file for the node here instead of printing.")
    ] = None,
    force: ForceOption = False,
) -> None:
    """Print all parameters, or write them to a file."""
    values = preset(preset_name)
    if output is not None:
        text = format_parameter_file(values, f"Preset `{preset_name}`.")
        with output_file(output, _is_parameter_file, overwrite=force) as file:
            file.write_text(text, encoding="utf-8")
        console.print(f"preset {preset_name}: {output}", soft_wrap=True)
        return
    if output_format is ParameterFormat.YAML:
        print(format_parameter_file(values, f"Preset `{preset_name}`."), end="")
        return
    for spec in PARAMETER_TABLE:
        _print_parameter(spec, values)


def _is_parameter_file(path: Path) -> bool:
    try:
        return path.is_file() and bool(read_parameter_file(path))
    except ParameterError:
        return False


def _print_parameter(spec: ParameterSpec, values: TrackerParameters) -> None:
    """Print name, value, unit and range on a line, and below it what the parameter means."""
    value = str(values.as_mapping()[spec.name]) or "(empty)"
    parts = [f"{spec.name} = {value}", spec.unit, f"({spec.range_text()})"]
    console.print(Text(" ".join(filter(None, parts)), style="bold"))
    console.print(Padding(Text(spec.meaning), (0, 0, 0, 4)))
