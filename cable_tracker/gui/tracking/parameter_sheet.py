"""Parameters between a session, presets, files and the fields of a page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from cable_tracker.atomic_output import write_text
from cable_tracker.errors import GuiError, ParameterError, write_failure
from cable_tracker.gui.subject import Groups, Subject
from cable_tracker.printable import printable
from cable_tracker.tracking.parameter_files import (
    edited_text,
    format_values,
    parse_parameters,
)
from cable_tracker.tracking.parameter_table import ParameterSpec, ParameterValue

WORDS_FOR_TRUTH = {"true": True, "false": False}


def value_from_field(spec: ParameterSpec, given: object) -> object:
    """Turn what stands in a field into a value; what is none stays text, and is refused later."""
    if spec.kind is str or not isinstance(given, str):
        return given
    # A comma is a decimal one; in a whole number it can only part thousands.
    text = given.strip() if spec.kind is int else given.strip().replace(",", ".")
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


def grouped(table: Sequence[ParameterSpec], groups: Groups) -> dict[str, list[ParameterSpec]]:
    """Cut a table, whose first parameter begins a group, into groups by their titles."""
    parts: dict[str, list[ParameterSpec]] = {first: [] for _, first in groups}
    rows = parts[table[0].name]
    for spec in table:
        rows = parts.get(spec.name, rows)
        rows.append(spec)
    return {title: parts[first] for title, first in groups if parts[first]}


def groups_for_page(table: Sequence[ParameterSpec], groups: Groups) -> list[dict[str, object]]:
    """Return the groups as the browser's half of the panel wants them."""
    return [
        {
            "title": title,
            "rows": [
                {
                    "name": spec.name,
                    "kind": spec.kind.__name__,
                    "unit": spec.unit,
                    "meaning": spec.meaning,
                    "range": spec.range_text(),
                    "choices": list(spec.choices),
                }
                for spec in rows
            ],
        }
        for title, rows in grouped(table, groups).items()
    ]


def parameter_text(values: Mapping[str, ParameterValue], source: str, subject: Subject) -> str:
    """Return the file that the node reads, with all that it can change while it runs."""
    known = [spec for spec in subject.session_table(is_live=True) if spec.name in values]
    return format_values(known, values, f"Tuned on {printable(source)}.")


def values_from_text(text: str | None, name: str, subject: Subject) -> dict[str, ParameterValue]:
    """Read a file as `cable-tracker track --params` and `target --params` do.

    Parameters
    ----------
    text : str or None
        Content of the file; None if it is too large for a parameter file.
    name : str
        File name, for messages to the user.
    subject : Subject
        Kind of tracked object, which decides the parameter table.

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
        raise ParameterError(
            f"{name}: is too large for a file with parameters; choose another file"
        )
    values = parse_parameters(text, name, subject.kind.node)
    of_node = {spec.name: spec for spec in subject.kind.of_node}
    try:
        parameters = subject.kind.with_values(str(values.get("preset", "default")), values)
        named = values.keys() & of_node.keys()
        return parameters.as_mapping() | {
            each: of_node[each].coerce(values[each]) for each in sorted(named)
        }
    except ParameterError as error:
        raise ParameterError(f"{name}: {error}") from error


class ExistingFileError(GuiError):
    """A file lies there already; it is changed or replaced only if the user says so."""


def write_parameter_file(path: Path, text: str, subject: Subject, *, overwrite: bool) -> None:
    """Write the file, as a whole or not at all.

    Of a file with parameters of the node that lies there, the values that differ are changed; its
    comments, and what it says to other nodes, stay. Anything else is replaced.

    Raises
    ------
    ExistingFileError
        There is one already, and it must not be overwritten.
    GuiError
        There is a folder or a device of this name, or a file with parameters of the node that
        cannot be changed in place.
    OutputError
        It cannot be written; what lay there is as it was.
    """
    try:
        if path.exists() and not path.is_file():
            raise GuiError(f"{path}: is a folder or a device; name a file")
        if path.exists() and not overwrite:
            raise ExistingFileError(
                f"{path}: exists already; save once more to change the parameters in it, or to"
                f" replace it if it holds none of the {subject.kind.node}"
            )
        if path.exists():
            text = _changed(path, text, subject)
        write_text(path, text)
    except OSError as error:
        raise write_failure(path, error) from error


def _changed(path: Path, new: str, subject: Subject) -> str:
    """Return the text of a file with the values of another; the other where it holds none of these.

    A file may be of a form that cannot be changed in place: what comes of it is read again.

    Raises
    ------
    GuiError
        It holds parameters of the node, and cannot be changed in place.
    """
    defaults = {spec.name: spec.default for spec in subject.kind.of_node}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            old = file.read()
        parse_parameters(old, "", subject.kind.node)
    except (ParameterError, UnicodeDecodeError):
        return new
    wanted = values_from_text(new, "", subject)
    try:
        before = defaults | values_from_text(old, "", subject)
        differing = {name: each for name, each in wanted.items() if each != before[name]}
        text = edited_text(old, differing, subject.kind.node)
        after = defaults | values_from_text(text, "", subject)
    except (ParameterError, yaml.YAMLError) as error:
        raise _unchangeable(path) from error
    if any(after[name] != each for name, each in wanted.items()):
        raise _unchangeable(path)
    return text


def _unchangeable(path: Path) -> GuiError:
    return GuiError(
        f"{path}: the parameters in it cannot be changed without losing something else in it; save"
        " under another name"
    )
