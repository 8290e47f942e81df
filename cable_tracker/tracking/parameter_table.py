"""How the parameters of trackers, nodes and worlds are declared, checked and replaced.

A set of parameters is a frozen dataclass; everything that is shown or checked of a parameter stands
in the declaration of its field. ROS descriptors, validation, the preset files in config/ and the
page in docs/ are all made from that.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from numbers import Integral, Real
from typing import Any, ClassVar, Self, TypeAlias, TypeVar, cast

from cable_tracker.errors import ParameterError

ParameterValue: TypeAlias = bool | int | float | str

REFERENCE_WIDTH = 320.0
"""Image width that lengths in parameters are given for [px]."""

REFERENCE_RATE = 25.0
"""Frame rate that variances and rates in parameters are given for [1/s]."""


def pixel_scale(image_width: float) -> float:
    """Return pixels of an image of a width [px] per pixel of one of the reference width."""
    return image_width / REFERENCE_WIDTH


@dataclass(frozen=True, slots=True)
class ParameterSpec:
    """One row of a table of parameters, a filter's or a node's.

    Attributes
    ----------
    name : str
        Name in YAML files and on the node, and of the field of a `ParameterSet`.
    kind : type
        bool, int, float or str.
    default : ParameterValue
        Value where none is given; for a filter, that of the preset `default`.
    unit : str
        Unit, for people; empty for pure numbers.
    meaning : str
        One sentence.
    minimum, maximum : float or None
        Range of a number, both ends included.
    choices : tuple of str
        Allowed words.
    """

    name: str
    kind: type
    default: ParameterValue
    unit: str
    meaning: str
    minimum: float | None
    maximum: float | None
    choices: tuple[str, ...]

    def range_text(self) -> str:
        """Describe the accepted values in a few words."""
        if self.choices:
            return " | ".join(self.choices)
        if self.kind is bool:
            return "true | false"
        if self.minimum is None or self.maximum is None:
            return "any text"
        form = ".0f" if self.kind is int else "g"
        return f"{self.minimum:{form}} .. {self.maximum:{form}}"

    def coerce(self, value: object) -> ParameterValue:
        """Return the value as this parameter's type.

        A whole number is accepted where a float is meant, and 500.0 where 500 is meant.

        Raises
        ------
        ParameterError
            The value is of another type, not finite, out of range, or an empty text that is needed.
        """
        return _check_range(self, _check_type(self, value))


def _check_type(spec: ParameterSpec, value: object) -> ParameterValue:
    # `Real` has those of NumPy, too; what is kept, written to files and declared is a plain number.
    if isinstance(value, Real) and not isinstance(value, bool):
        if spec.kind is int and isinstance(value, Integral):
            return int(value)
        plain = _to_float(value)
        if spec.kind is float:
            return plain
        if spec.kind is int and plain.is_integer():
            return int(plain)
    if spec.kind in (bool, str) and isinstance(value, spec.kind):
        return cast(ParameterValue, value)
    wanted = {bool: "true or false", int: "a whole number", float: "a number", str: "a word"}
    raise ParameterError(f"{spec.name}: {value!r} is not {wanted[spec.kind]}")


def _to_float(value: Real) -> float:
    try:
        return float(value)
    except OverflowError:  # A whole number may have any length.
        return math.inf


def _check_range(spec: ParameterSpec, value: ParameterValue) -> ParameterValue:
    if isinstance(value, str):
        if spec.choices and value not in spec.choices:
            raise ParameterError(f"{spec.name}: {value!r} is none of {spec.range_text()}")
        # Where a text may be left out, the default is without one.
        if spec.default and not value:
            raise ParameterError(f"{spec.name}: it is empty; give for instance {spec.default}")
        return value
    if spec.minimum is None or spec.maximum is None:
        return value
    # Written so that NaN fails too.
    if not spec.minimum <= value <= spec.maximum:
        unit = f" {spec.unit}" if spec.unit else ""
        raise ParameterError(f"{spec.name}: {value!r} is outside {spec.range_text()}{unit}")
    return value


def number(default: float, unit: str, minimum: float, maximum: float, meaning: str) -> Any:  # noqa: ANN401
    """Declare a field of a `ParameterSet` that is a number; a whole one if its default is."""
    metadata = {"unit": unit, "minimum": minimum, "maximum": maximum, "meaning": meaning}
    return dataclasses.field(default=default, metadata=metadata)


def word(default: str, choices: tuple[str, ...], meaning: str) -> Any:  # noqa: ANN401
    """Declare a field of a `ParameterSet` that is one of some words, or any text without them."""
    return dataclasses.field(default=default, metadata={"choices": choices, "meaning": meaning})


def flag(default: bool, meaning: str) -> Any:  # noqa: ANN401
    """Declare a field of a `ParameterSet` that is a switch."""
    return dataclasses.field(default=default, metadata={"meaning": meaning})


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterSet:
    """Base of parameters of a tracker, node or world: their values are checked when they are set.

    Raises
    ------
    ParameterError
        A value is out of range, or values contradict each other.
    """

    IN_ORDER: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Pairs of names; the value of the first must not exceed that of the second."""

    def __post_init__(self) -> None:
        for spec in parameter_table(type(self)):
            object.__setattr__(self, spec.name, spec.coerce(getattr(self, spec.name)))
        for low, high in self.IN_ORDER:
            if getattr(self, low) > getattr(self, high):
                raise ParameterError(
                    f"{low} = {getattr(self, low):g} must not exceed"
                    f" {high} = {getattr(self, high):g}; set both together"
                )
        self.check_together()

    def check_together(self) -> None:
        """Refuse values that contradict each other; overridden where there are such.

        Raises
        ------
        ParameterError
            They do.
        """

    def replaced(self, values: Mapping[str, object]) -> Self:
        """Return a copy with some values changed, all of them or none.

        Raises
        ------
        ParameterError
            A name is unknown, a value is not acceptable, or the set contradicts itself.
        """
        specs = {spec.name: spec for spec in parameter_table(type(self))}
        unknown = sorted(set(values) - set(specs))
        if unknown:
            raise ParameterError(
                f"unknown parameter {', '.join(unknown)}{_similar_name(unknown[0], specs)};"
                " docs/parameters.md lists them all"
            )
        coerced = {name: specs[name].coerce(value) for name, value in values.items()}
        return dataclasses.replace(self, **cast(dict[str, Any], coerced))

    def as_mapping(self) -> dict[str, ParameterValue]:
        """Return the values by name, in the order of the table."""
        return {spec.name: getattr(self, spec.name) for spec in parameter_table(type(self))}

    def remarks(self) -> tuple[str, ...]:
        """Say which values are accepted but hardly meant, one sentence each."""
        return ()

    def choices(self) -> tuple[str, ...]:
        """Return the values that have choices: they choose which code runs, numbers do not."""
        return tuple(
            getattr(self, spec.name) for spec in parameter_table(type(self)) if spec.choices
        )


def _similar_name(unknown: str, known: Iterable[str]) -> str:
    """Return a question whether a known name was meant; empty where none is similar."""
    similar = get_close_matches(unknown, known, n=1)
    return f" (did you mean {similar[0]}?)" if similar else ""


def parameter_table(kind: type[ParameterSet]) -> tuple[ParameterSpec, ...]:
    """Return a row for each parameter of a kind of set, in the order of its fields."""
    return _table_of(dataclasses.fields(kind))


@cache
def _table_of(fields: tuple[dataclasses.Field[Any], ...]) -> tuple[ParameterSpec, ...]:
    return tuple(_spec_of_field(field) for field in fields)


def _spec_of_field(field: dataclasses.Field[Any]) -> ParameterSpec:
    return ParameterSpec(
        name=field.name,
        kind=type(field.default),
        default=cast(ParameterValue, field.default),
        unit=field.metadata.get("unit", ""),
        meaning=field.metadata["meaning"],
        minimum=field.metadata.get("minimum"),
        maximum=field.metadata.get("maximum"),
        choices=field.metadata.get("choices", ()),
    )


Parameters = TypeVar("Parameters", bound=ParameterSet)
Entry = TypeVar("Entry")


def check_name(what: str, name: str, known: Collection[str]) -> None:
    """See that a name is one of those that are known.

    Parameters
    ----------
    what : str
        Kind of thing that is named, for the message.

    Raises
    ------
    ParameterError
        It is not.
    """
    if name not in known:
        raise ParameterError(f"{what}: {name!r} is none of {' | '.join(known)}")


def named(what: str, name: str, table: Mapping[str, Entry]) -> Entry:
    """Return the entry of a table that a name stands for; see `check_name`."""
    check_name(what, name, table)
    return table[name]
