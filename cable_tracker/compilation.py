"""Compiling loops with Numba.

A kernel stands beside what uses it. Functions that Python calls are entries, `compiled`: their
machine code is kept on disk. What they call in turn are parts; a part that Python calls, a test for
example, is plain Python. `NUMBA_DISABLE_JIT=1` in the environment leaves all of it as it is, for a
debugger.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.extending import register_jitable

Function = TypeVar("Function", bound=Callable[..., Any])

COMMON: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
PART: dict[str, Any] = COMMON | {"no_cpython_wrapper": True}
"""To unpack what Python hands over takes longest to compile, and a part is never called so."""

FAST = {"reassoc", "contract", "nsz", "arcp"}
"""Liberties of the `fast` ones: sums may be taken in any order, so the processor vectorises."""


def compiled(function: Function) -> Function:
    """Compile a function that Python calls, at its first call, and keep the machine code."""
    return _entry(function)


def compiled_fast(function: Function) -> Function:
    """Compile such a function whose sums may be taken in any order.

    Not for code that compares with infinity or NaN.
    """
    return _entry(function, fastmath=FAST)


def compiled_part(function: Function) -> Function:
    """Compile a function as a part of compiled ones that call it."""
    return cast(Function, register_jitable(**PART)(function))


def compiled_fast_part(function: Function) -> Function:
    """Compile a part whose sums may be taken in any order; see `compiled_fast`."""
    return cast(Function, register_jitable(fastmath=FAST, **PART)(function))


def compiled_inside(function: Function) -> Function:
    """Compile a part into each place that calls it: a small one that is called very often."""
    return cast(Function, register_jitable(forceinline=True, **PART)(function))


def _entry(function: Function, **options: Any) -> Function:  # noqa: ANN401
    options |= COMMON
    try:
        return cast(Function, numba.njit(cache=True, **options)(function))
    except RuntimeError:
        # Neither beside the package nor in the user's folders can anything be written.
        return cast(Function, numba.njit(**options)(function))
