from __future__ import annotations

import operator
from itertools import product

import numba
import numpy as np
import pytest
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Flags
from numba.core.registry import cpu_target
from numba.core.types.functions import BaseFunction

from cable_tracker.compilation import compiled, compiled_loop, compiled_part
from cable_tracker.numba_linking import _operators_typed_once, _quickly_compared_flags


@compiled_part
def checked(value):
    if value < 0.0:
        raise ValueError("negative", value)
    return value


@compiled
def twice(value):
    return 2.0 * checked(value)


@compiled
def root(value):
    return np.sqrt(checked(value))


@compiled
def root_of_twice(value):
    return root(twice(value))


def kind_of_libraries():
    return cpu_target.target_context.codegen()._library_class


def test_a_part_serves_several_entries():
    assert twice(8.0) == 16.0
    assert root(9.0) == 3.0


@pytest.mark.parametrize("entry", [twice, root, root_of_twice])
def test_an_exception_of_a_part_is_raised_by_the_entry(entry):
    with pytest.raises(ValueError, match="negative") as raised:
        entry(-1.0)
    assert raised.value.args == ("negative", -1.0)


def test_an_entry_that_another_one_calls_answers_python_too():
    assert root_of_twice(8.0) == 4.0
    assert twice(2.0) == 4.0


def test_machine_code_is_made_of_entries_alone(monkeypatch):
    @compiled_part
    def half(value):
        return 0.5 * value

    @compiled
    def quarter(value):
        return half(half(value))

    engine = cpu_target.target_context.codegen()._engine
    made, original = [], engine.finalize_object
    monkeypatch.setattr(engine, "finalize_object", lambda: made.append(original()))
    assert quarter(8.0) == 2.0
    assert len(made) == 1


def test_functions_of_others_are_compiled_as_ever():
    @compiled
    def ours(count):
        return np.zeros(count).sum()

    @numba.njit
    def theirs(count):
        return np.zeros(count).sum() + 1.0

    assert ours(3) == 0.0
    assert theirs(3) == 1.0
    assert kind_of_libraries() is JITCodeLibrary


def test_a_function_of_others_serves_an_entry_python_and_others_in_turn():
    @numba.njit
    def zeros(count):
        if count < 0:
            raise ValueError("negative", count)
        return np.zeros(count).sum()

    @compiled
    def ours(count):
        return zeros(count)

    @numba.njit
    def theirs(count):
        return zeros(count) + 1.0

    assert [ours(3), theirs(3), zeros(3)] == [0.0, 1.0, 0.0]
    for function in (ours, theirs, zeros):
        with pytest.raises(ValueError, match="negative") as raised:
            function(-1)
        assert raised.value.args == ("negative", -1)


def test_a_failed_compilation_restores_the_compiler():
    @compiled
    def entry(value):
        return value.nothing_of_this_name

    with pytest.raises(numba.TypingError):
        entry(1.0)
    assert kind_of_libraries() is JITCodeLibrary


def test_a_loop_fills_arrays_that_it_is_given():
    @compiled_loop
    def fill(values, value):
        for index in range(len(values)):
            values[index] = value

    @compiled
    def filled(count, value):
        values = np.empty(count)
        fill(values[1:], value)
        values[0] = 0.0
        return values

    assert filled(3, 2.0).tolist() == [0.0, 2.0, 2.0]


def test_a_loop_that_makes_an_array_does_not_compile():
    @compiled_loop
    def made(count):
        return len(np.empty(count))

    @compiled
    def entry(count):
        return made(count)

    with pytest.raises(numba.core.errors.NumbaError):
        entry(3)


def flags(**options):
    made = Flags()
    for name, value in options.items():
        setattr(made, name, value)
    return made


def test_options_are_compared_as_numba_compares_them():
    options = [{}, {"nrt": True}, {"fastmath": True}, {"forceinline": False}]
    others = [{}, {"nrt": True}, {"nrt": False}, {"nrt": True, "forceinline": True}]
    for one, other in product([flags(**each) for each in options], [flags(**o) for o in others]):
        expected = one == other
        hashes = hash(one), hash(other)
        with _quickly_compared_flags():
            assert (one == other) is expected
            assert (hash(one), hash(other)) == hashes
            assert one != 3


def test_numba_compares_options_itself_where_no_entry_is_compiled():
    before = Flags.__eq__, Flags.__hash__
    with pytest.raises(ValueError, match="stop"), _quickly_compared_flags():
        assert Flags.__eq__ is not before[0]
        raise ValueError("stop")
    assert (Flags.__eq__, Flags.__hash__) == before


ONE_KIND_EACH = [
    (operator.add, (numba.int64, numba.float32)),
    (operator.lt, (numba.uint8, numba.float64)),
    (operator.getitem, (numba.float64[:, ::1], numba.types.UniTuple(numba.int64, 2))),
]


@pytest.mark.parametrize(("operation", "operands"), ONE_KIND_EACH)
def test_the_type_of_an_operators_result_is_what_numba_finds(operation, operands):
    context = cpu_target.typing_context
    context.refresh()
    expected = context.resolve_function_type(operation, operands, {})
    with _operators_typed_once():
        first = context.resolve_function_type(operation, operands, {})
        assert context.resolve_function_type(operation, operands, {}) is first
    assert first == expected


def test_operands_that_do_not_go_together_are_refused_each_time():
    context = cpu_target.typing_context
    context.refresh()
    with _operators_typed_once():
        for _ in range(2):
            with pytest.raises(numba.TypingError):
                context.resolve_function_type(
                    operator.add, (numba.int64, numba.types.unicode_type), {}
                )


def test_numba_finds_types_itself_where_no_entry_is_compiled():
    before = BaseFunction.get_call_type
    with pytest.raises(ValueError, match="stop"), _operators_typed_once():
        assert BaseFunction.get_call_type is not before
        raise ValueError("stop")
    assert BaseFunction.get_call_type is before
