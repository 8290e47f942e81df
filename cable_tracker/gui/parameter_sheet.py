"""Parameters between a session, presets, files and the fields of a page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from cable_tracker.cable.parameters.parameters import (
    PARAMETER_TABLE,
    PARAMETERS_BY_NAME,
    ParameterSpec,
    ParameterValue,
    TrackerParameters,
)
from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.errors import GuiError, OutputError, ParameterError
from cable_tracker.gui.parameter_groups import grouped
from cable_tracker.node_parameter_tables import (
    TRACKER_NODE_PARAMETERS,
    TRACKER_RUNTIME_PARAMETERS,
)
from cable_tracker.tracking.parameter_files import (
    filter_parameters,
    format_values,
    parse_parameters,
)

WORDS_FOR_TRUTH = {"true": True, "false": False}


def value_from_field(spec: ParameterSpec, given: object) -> object:
    """Turn what stands in a field into a value; what is none stays text, and is refused later."""
    if spec.kind is str or not isinstance(given, str):
        return given
    text = given.strip().replace(",", ".")
    if spec.kind is bool:
        return WORDS_FOR_TRUTH.get(text.lower(), given)
    for convert in (int, float):
        try:
            return convert(text)
        except ValueError:
            continue
    return given


def values_for_page(values: Mapping[str, ParameterValue]) -> dict[str, ParameterValue]:
    """Return values that JSON can say; whole floats become ints, which look the same in fields."""
    return {
        name: int(value) if isinstance(value, float) and value.is_integer() else value
        for name, value in values.items()
        if not isinstance(value, float) or math.isfinite(value)
    }


def groups_for_page(table: Sequence[ParameterSpec]) -> list[dict[str, object]]:
    """Return the groups as the browser's half of the panel wants them."""
    return [
        {
            "title": group.title,
            "rows": [
                {
                    "name": spec.name,
                    "kind": spec.kind.__name__,
                    "unit": spec.unit,
                    "meaning": spec.meaning,
                    "range": spec.range_text(),
                    "choices": list(spec.choices),
                }
                for spec in group.rows
            ],
        }
        for group in grouped(table)
    ]


def filter_values(values: Mapping[str, ParameterValue]) -> TrackerParameters:
    """Return the parameters of the filter among the values of a session."""
    known = {name: value for name, value in values.items() if name in PARAMETERS_BY_NAME}
    return TrackerParameters().replaced(known)


def parameter_text(values: Mapping[str, ParameterValue], source: str) -> str:
    """Return the file that the node reads, with all that it can change while it runs."""
    table = (*PARAMETER_TABLE, *TRACKER_RUNTIME_PARAMETERS)
    known = [spec for spec in table if spec.name in values]
    return format_values(known, values, f"Tuned on {source}.")


def values_from_text(text: str | None, name: str) -> dict[str, ParameterValue]:
    """Read a file as `cable-tracker track --params` does.

    Parameters
    ----------
    text : str or None
        What is in the file; None if it is too large for one with parameters.
    name : str
        What the user calls it.

    Returns
    -------
    dict
        All parameters of the filter, and those of the node that the file names.

    Raises
    ------
    ParameterError
        It is no such file, or a value is not acceptable.
    """
    if text is None:
        raise ParameterError(f"{name}: is too large for a file with parameters")
    values = parse_parameters(text, name)
    of_node = {spec.name: spec for spec in TRACKER_NODE_PARAMETERS}
    base = preset(str(values.get("preset", "default")))
    try:
        parameters = filter_parameters(base, values, set(of_node))
        named = values.keys() & of_node.keys()
        return parameters.as_mapping() | {
            each: of_node[each].coerce(values[each]) for each in sorted(named)
        }
    except ParameterError as error:
        raise ParameterError(f"{name}: {error}") from error


def write_parameter_file(path: Path, text: str, *, overwrite: bool) -> None:
    """Write the file.

    Raises
    ------
    GuiError
        There is one already, and it must not be overwritten.
    OutputError
        It cannot be written.
    """
    try:
        with path.open("w" if overwrite else "x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise GuiError(f"{path}: exists already; save once more to replace it") from error
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error


def references() -> dict[str, dict[str, ParameterValue]]:
    """Return what values can be compared with: the presets, by name."""
    return {name: parameters.as_mapping() for name, parameters in PRESETS.items()}
