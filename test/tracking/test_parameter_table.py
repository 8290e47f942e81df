from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_table import (
    ParameterSet,
    check_name,
    flag,
    named,
    number,
    parameter_table,
    word,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class LampParameters(ParameterSet):
    IN_ORDER: ClassVar = (("dimmest", "brightest"),)

    dimmest: float = number(0.1, "lux", 0.0, 100.0, "Least light.")
    brightest: float = number(10.0, "lux", 0.0, 100.0, "Most light.")
    bulbs: int = number(2, "", 1, 9, "How many.")
    colour: str = word("white", ("white", "red"), "Of the light.")
    place: str = word("desk", (), "Where it stands.")
    note: str = word("", (), "What is written on it.")
    lit: bool = flag(True, "Whether it gives light.")

    def check_together(self):
        if self.colour == "red" and self.bulbs > 1:
            raise ParameterError("colour = red needs bulbs = 1")


def test_every_field_is_a_row_in_the_order_of_the_fields():
    table = parameter_table(LampParameters)
    assert [spec.name for spec in table] == [
        "dimmest", "brightest", "bulbs", "colour", "place", "note", "lit",
    ]  # fmt: skip
    assert [spec.kind for spec in table] == [float, float, int, str, str, str, bool]
    assert table[0].range_text() == "0 .. 100"
    assert (table[-1].default, table[-1].range_text()) == (True, "true | false")


def test_values_are_checked_one_by_one():
    assert LampParameters(bulbs=3.0).bulbs == 3
    with pytest.raises(ParameterError, match="bulbs"):
        LampParameters(bulbs=10)


def test_only_a_text_whose_default_is_empty_may_be_so():
    with pytest.raises(ParameterError, match="place: it is empty; give for instance desk"):
        LampParameters(place="")
    assert LampParameters(place="shelf", note="").note == ""


def test_values_are_checked_together():
    with pytest.raises(ParameterError, match="dimmest = 20 must not exceed brightest = 10"):
        LampParameters(dimmest=20.0)
    with pytest.raises(ParameterError, match="colour = red needs bulbs = 1"):
        LampParameters(colour="red")
    assert LampParameters().replaced({"colour": "red", "bulbs": 1}).colour == "red"


def test_replacing_is_all_or_nothing():
    before = LampParameters()
    with pytest.raises(ParameterError, match="bulbs"):
        before.replaced({"dimmest": 1.0, "bulbs": -1})
    assert before == LampParameters()
    after = before.replaced({"dimmest": 1.0, "bulbs": 3})
    assert (after.dimmest, after.bulbs) == (1.0, 3)


@given(
    st.dictionaries(
        st.sampled_from(["dimmest", "bulbs", "colour", "place", "lit"]), st.none() | st.integers()
    )
)
def test_any_set_of_values_is_taken_or_refused_with_a_reason_in_one_line(values):
    try:
        replaced = LampParameters().replaced(values)
    except ParameterError as error:
        assert "\n" not in str(error)
    else:
        assert {name: getattr(replaced, name) for name in values} == values


def test_unknown_names_are_refused_and_named():
    with pytest.raises(ParameterError, match="unknown parameter height, smell;"):
        LampParameters().replaced({"smell": 1, "bulbs": 2, "height": 1})


def test_a_misspelled_name_is_met_with_the_right_one():
    with pytest.raises(ParameterError, match=r"unknown parameter colur \(did you mean colour\?\);"):
        LampParameters().replaced({"colur": "red"})


def test_an_unknown_name_is_refused_with_those_that_are_known():
    check_name("lamp", "night", ("day", "night"))
    with pytest.raises(ParameterError, match=r"lamp: 'dusk' is none of day \| night"):
        check_name("lamp", "dusk", ("day", "night"))


def test_words_are_the_parameters_with_choices():
    assert LampParameters(bulbs=1).choices() == LampParameters(bulbs=2).choices() == ("white",)
    assert LampParameters(bulbs=1, colour="red").choices() == ("red",)


@pytest.mark.parametrize(
    ("name", "value", "plain"),
    [
        ("bulbs", np.int64(3), 3),
        ("bulbs", np.uint8(3), 3),
        ("bulbs", np.float32(3.0), 3),
        ("bulbs", Fraction(3), 3),
        ("brightest", np.float32(0.5), 0.5),
        ("brightest", np.float64(0.5), 0.5),
        ("brightest", np.int32(1), 1.0),
        ("brightest", Fraction(1, 2), 0.5),
    ],
)
def test_numbers_of_other_kinds_are_taken_and_kept_as_plain_ones(name, value, plain):
    kept = getattr(LampParameters().replaced({name: value}), name)
    assert kept == plain
    assert type(kept) is type(plain)


@pytest.mark.parametrize(
    "value", [np.float32(2.5), 2.5, np.nan, np.inf, np.bool_(True), True, 2j, "2", [], None]
)
def test_a_bad_whole_number_is_refused(value):
    with pytest.raises(ParameterError, match=r"bulbs: .* is not a whole number"):
        LampParameters().replaced({"bulbs": value})


@pytest.mark.parametrize("value", [np.bool_(True), True, 2j, "2", np.ones(2), [1.0], None])
def test_a_bad_number_is_refused(value):
    with pytest.raises(ParameterError, match=r"brightest: .* is not a number"):
        LampParameters().replaced({"brightest": value})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("bulbs", 0),
        ("bulbs", 10),
        ("brightest", -1.0),
        ("brightest", 101),
        ("brightest", np.nan),
        ("brightest", np.inf),
        pytest.param("brightest", 10**400, id="brightest-beyond any float"),
    ],
)
def test_a_number_outside_its_range_is_refused(name, value):
    with pytest.raises(ParameterError, match=rf"{name}: .* is outside [01] \.\. (9|100)"):
        LampParameters().replaced({name: value})


@pytest.mark.parametrize(("name", "value"), [("colour", 3), ("place", 3), ("place", None)])
def test_a_bad_word_is_refused(name, value):
    with pytest.raises(ParameterError, match=rf"{name}: .* is not a word"):
        LampParameters().replaced({name: value})


@pytest.mark.parametrize("value", ["blue", ""])
def test_a_word_outside_the_choices_is_refused(value):
    with pytest.raises(ParameterError, match=rf"colour: '{value}' is none of white \| red"):
        LampParameters(colour=value)


@pytest.mark.parametrize("value", [1, 0.0, "true", None])
def test_a_switch_is_true_or_false_and_nothing_else(value):
    assert LampParameters(lit=False).lit is False
    with pytest.raises(ParameterError, match=r"lit: .* not true or false"):
        LampParameters().replaced({"lit": value})


def test_a_name_stands_for_its_entry_and_another_is_refused_with_those_that_are_known():
    table = {"S1": 1, "S2": 2}
    assert named("scenario", "S2", table) == 2
    with pytest.raises(ParameterError, match=r"scenario: 'S9' is none of S1 \| S2"):
        named("scenario", "S9", table)
