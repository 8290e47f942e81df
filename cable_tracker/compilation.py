"""Compiling the inner loops, where Numba is installed.

Every compiled function has a twin in plain NumPy that gives the same numbers, so that the package
works without Numba, and so that tests can hold the one against the other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

try:
    import numba
except ImportError:
    numba = None

Function = TypeVar("Function", bound=Callable[..., Any])

NUMBA_IS_INSTALLED: bool = numba is not None


def compiled(function: Function) -> Function:
    """Compile a function at its first call, and keep the machine code on disk.

    Without Numba the function stays as it is: loops in plain Python. Nobody should call it
    then; see `uses_compiled_kernels`.
    """
    return _compiled(function)


def compiled_inside(function: Function) -> Function:
    """Compile a function as a part of those that call it: a small one that is called very often."""
    return _compiled(function, forceinline=True)


def compiled_fast(function: Function) -> Function:
    """Compile a function whose sums may be taken in any order, which lets the processor vectorise.

    Not for code that compares with infinity or NaN.
    """
    return _compiled(function, fastmath={"reassoc", "contract", "nsz", "arcp"})


def _compiled(function: Function, **options: Any) -> Function:  # noqa: ANN401
    if numba is None:
        return function
    options |= {"nogil": True, "error_model": "numpy"}
    try:
        return cast(Function, numba.njit(cache=True, **options)(function))
    except RuntimeError:
        # Neither beside the package nor in the user's folders can anything be written.
        return cast(Function, numba.njit(**options)(function))


def uses_compiled_kernels(kernels: str) -> bool:
    """Tell whether the parameter `kernels` (auto, compiled or numpy) means compiled ones here."""
    return kernels == "compiled" or (kernels == "auto" and NUMBA_IS_INSTALLED)
