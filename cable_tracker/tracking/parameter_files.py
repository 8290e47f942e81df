"""Parameters in YAML files, in the form that ROS nodes read."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from cable_tracker.errors import ParameterError, one_line
from cable_tracker.tracking.parameter_table import (
    ParameterSet,
    ParameterSpec,
    ParameterValue,
    parameter_table,
)

ROS_KEY = "ros__parameters"
EVERY_NODE = ("/**:", f"  {ROS_KEY}:")
"""How a file for whichever node is started with it begins."""

PLAIN_WORD = re.compile(r"(?!(?:true|false|yes|no|on|off|y|n|null|nan|inf)$)[a-z][a-z_]*")
"""A text that YAML does not take for anything else."""

TEXT, INTEGER, FLOAT = (f"tag:yaml.org,2002:{kind}" for kind in ("str", "int", "float"))
"""Tags of scalars in YAML."""

ONLY_YAML_1_1 = re.compile("[_:]|^[-+]?0b")
"""What numbers of YAML 1.1 may hold, and those of ROS may not: 1_000, 1:30, 0b11."""


class _ParameterLoader(yaml.SafeLoader):
    """Takes for numbers what ROS does: also 1e-5, 1.5e2 and 08, words in YAML 1.1, and not 1_000.

    A whole number that begins with 0 is octal, as 010, and decimal where it cannot be, as 08.

    What is no number is left as text, so that it is refused in the words of the node.
    """

    def resolve(self, kind: type[yaml.Node], value: Any, implicit: Any) -> Any:  # noqa: ANN401
        """Return the tag of a node without one."""
        tag = super().resolve(kind, value, implicit)  # type: ignore[no-untyped-call]
        return TEXT if tag in {INTEGER, FLOAT} and ONLY_YAML_1_1.search(value) else tag


_ParameterLoader.add_implicit_resolver(
    FLOAT,
    re.compile(r"^[-+]?((\d+(\.\d*)?|\.\d+)[eE][-+]?\d+|0\d*[89]\d*)$"),
    list("-+.0123456789"),
)


def read_parameter_file(path: Path, node: str = "tracker") -> dict[str, object]:
    """Read the parameters of a ROS parameter file, or of a plain mapping of names to values.

    The names are not checked. In a ROS file, the sections `/**` and those of any node of the name
    `node`, in whatever namespace, count; later ones override earlier ones.

    Raises
    ------
    ParameterError
        The file cannot be read, has another form, or is for other nodes only.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise ParameterError(f"{path}: there is no such file; check the path") from error
    except (OSError, ValueError) as error:
        raise _unreadable(str(path), error) from error
    return parse_parameters(text, str(path), node)


def parse_parameters(text: str, path: str, node: str = "tracker") -> dict[str, object]:
    """Read the text of a parameter file; see `read_parameter_file`.

    Parameters
    ----------
    text : str
        Content of the file.
    path : str
        Name of the file in messages.
    node : str
        Name of the node whose sections count.

    Raises
    ------
    ParameterError
        The text has another form, or is for other nodes only.
    """
    try:
        # A SafeLoader with one more way of writing numbers.
        content = yaml.load(text, _ParameterLoader)
    except (ValueError, RecursionError, yaml.YAMLError) as error:
        raise _unreadable(path, error) from error
    if not isinstance(content, dict):
        raise ParameterError(f"{path}: holds no parameters by name; see config/default.yaml")
    named = list(_node_sections(content, "", set()))
    sections = [section for name, section in named if _is_for(node, name)]
    if named and not sections:
        raise ParameterError(
            f"{path}: holds nothing for the node {node}, only for"
            f" {', '.join(name for name, _ in named)}; name the section /**/{node}"
        )
    values: dict[str, object] = {}
    for section in sections or [content]:
        if not isinstance(section, dict):
            raise ParameterError(f"{path}: {ROS_KEY} is no mapping; see config/default.yaml")
        values.update({str(name): value for name, value in section.items()})
    return values


def _unreadable(path: str, error: Exception) -> ParameterError:
    return ParameterError(f"{path}: cannot be read as YAML ({one_line(error)})")


def _node_sections(content: object, namespace: str, seen: set[int]) -> Iterator[tuple[str, Any]]:
    """Yield the names of a ROS file's nodes, with namespaces, and their parameters.

    `content` is what `_entries` takes. `seen` are the namespaces that have been descended into:
    YAML's aliases may name one in itself.
    """
    for key, section in _entries(content):
        name = f"{namespace}/{key.strip('/')}"
        of_node = [values for each, values in _entries(section) if each == ROS_KEY]
        if of_node:
            yield from ((name, values) for values in of_node)
        elif id(section) not in seen:
            seen.add(id(section))
            yield from _node_sections(section, name, seen)


def _entries(content: object) -> list[tuple[str, Any]]:
    """Return what a mapping holds, read or as YAML's parser finds it; of anything else nothing."""
    if isinstance(content, yaml.MappingNode):
        return [(str(key.value), value) for key, value in content.value]
    return (
        [(str(key), value) for key, value in content.items()] if isinstance(content, dict) else []
    )


def _is_for(node: str, section: str) -> bool:
    return section.rsplit("/", maxsplit=1)[-1] in {"**", node}


def format_parameter_file(parameters: ParameterSet, title: str) -> str:
    """Write all parameters of the filter as a commented ROS parameter file."""
    return format_values(parameter_table(type(parameters)), parameters.as_mapping(), title)


def format_values(
    table: Iterable[ParameterSpec], values: Mapping[str, ParameterValue], title: str
) -> str:
    """Write the parameters of a table as a commented ROS parameter file.

    Parameters
    ----------
    table : iterable of ParameterSpec
        Parameters to write, in this order.
    values : mapping
        The value of each.
    title : str
        First line of the file.
    """
    lines = [
        f"# {' '.join(title.split())}",
        "# Lengths are for an image 320 px wide, variances per frame at 25 frames per second;",
        "# docs/parameters.md explains each.",
        *EVERY_NODE,
    ]
    for spec in table:
        text = _scalar(values[spec.name])
        unit = f" {spec.unit}," if spec.unit else ""
        lines.append(f"    {spec.name}: {text}  #{unit} {spec.range_text()}")
    return "\n".join(lines) + "\n"


def write_node_parameters(path: Path, parameters: Mapping[str, ParameterValue]) -> None:
    """Write values for whichever node is started with the file, as `--params-file` takes it.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    lines = [f"    {name}: {_scalar(value)}" for name, value in parameters.items()]
    path.write_text("\n".join([*EVERY_NODE, *lines, ""]), encoding="utf-8")


def edited_text(text: str, values: Mapping[str, ParameterValue], node: str) -> str:
    """Return the text of a parameter file with some values changed, and all else as it is.

    A value is changed where it counts, in the last section for the node that names it; what none
    names is added at the end of the last one. That needs a section of a line for each value: what
    comes of another form has to be read again.

    Parameters
    ----------
    text : str
        A file that `parse_parameters` reads for the node.
    values : mapping of str to ParameterValue
        Values by name.
    node : str
        Name of the node whose sections count.

    Raises
    ------
    ParameterError
        It holds no parameters by name.
    """
    root = yaml.compose(text, _ParameterLoader)
    if not isinstance(root, yaml.MappingNode):
        raise ParameterError("holds no parameters by name")
    sections = [
        values
        for name, values in _node_sections(root, "", set())
        if _is_for(node, name) and isinstance(values, yaml.MappingNode)
    ] or [root]
    places = {key.value: value for section in sections for key, value in section.value}
    edits = [
        (places[name].start_mark.index, places[name].end_mark.index, _scalar(value))
        for name, value in values.items()
        if name in places
    ]
    added = [f"{name}: {_scalar(value)}" for name, value in values.items() if name not in places]
    if added and sections[-1].value:
        first, last = sections[-1].value[0][0], sections[-1].value[-1][1]
        line_end = text.find("\n", last.end_mark.index)
        end = len(text) if line_end < 0 else line_end
        indent = "\n" + " " * first.start_mark.column
        edits.append((end, end, "".join(f"{indent}{line}" for line in added)))
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _scalar(value: ParameterValue) -> str:
    """Write a value so that YAML and ROS read it back; what is no plain word is quoted."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str) and not PLAIN_WORD.fullmatch(value):
        return yaml.safe_dump(value, default_style='"', width=math.inf).strip()
    return str(value)
