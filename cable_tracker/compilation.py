"""Compiling loops with Numba, and keeping the machine code.

A kernel stands beside what uses it. Functions that Python calls are entries, `compiled`: their
machine code is kept on disk. What they call in turn are parts; a part that Python calls, a test for
example, is plain Python. `NUMBA_DISABLE_JIT=1` in the environment leaves all of it as it is, for a
debugger.

Numba does not notice when a function changed that another file calls, and stumbles over modules
that are gone. So the machine code of a module lies in a folder named after what it was made of: the
text of that module and of all that it imports of this package, and Numba's version.
"""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.extending import register_jitable

from cable_tracker.numba_linking import EntryCompiler, register_part

Function = TypeVar("Function", bound=Callable[..., Any])

COMMON: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
ENTRY: dict[str, Any] = COMMON | {"pipeline_class": EntryCompiler}

PART: dict[str, Any] = COMMON | {"no_cpython_wrapper": True, "_nrt": True, "fastmath": False}
"""To unpack what Python hands over takes longest to compile, and a part is never called so."""

LOOP: dict[str, Any] = PART | {"_nrt": False}
"""Without counting references to arrays: that is half of the instructions of a small function."""

INSIDE: dict[str, Any] = {key: LOOP[key] for key in LOOP if key != "fastmath"} | {
    "forceinline": True
}

FAST = {"reassoc", "contract", "nsz", "arcp"}
"""Liberties of the `fast` ones: sums may be taken in any order, so the processor vectorises."""

PACKAGE = Path(__file__).resolve().parent

IMPORTED = re.compile(r"^(?:from|import) cable_tracker((?:\.\w+)+)", re.MULTILINE)
"""A module of this package that another one imports."""

DIGITS = 16
"""Of the digest in the name of a folder."""


def compiled(function: Function) -> Function:
    """Compile a function that Python calls, at its first call, and keep the machine code."""
    source = Path(function.__code__.co_filename)
    folder = _writable(_cache_folders(), digest_of(source)) if PACKAGE in source.parents else None
    if folder is None:
        return cast(Function, numba.njit(**ENTRY)(function))
    # Numba asks for the folder when the function is decorated; it is that of others again then.
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        entry = numba.njit(cache=True, **ENTRY)(function)
    finally:
        numba.config.CACHE_DIR = before
    _do_without_disk(entry)
    return cast(Function, entry)


def compiled_part(function: Function) -> Function:
    """Compile a function as a part of compiled ones that call it."""
    return register_part(function, PART)


def compiled_fast_part(function: Function) -> Function:
    """Compile a part whose sums may be taken in any order.

    Not for code that compares with infinity or NaN.
    """
    return register_part(function, PART | {"fastmath": FAST})


def compiled_loop(function: Function) -> Function:
    """Compile a part that makes and returns no arrays: it reads and fills those that it is given.

    What it calls must be of this kind or `compiled_inside`. To make an array in one does not
    compile; to return one would free it too early.
    """
    return register_part(function, LOOP)


def compiled_fast_loop(function: Function) -> Function:
    """Compile such a part whose sums may be taken in any order; see `compiled_fast_part`."""
    return register_part(function, LOOP | {"fastmath": FAST})


def compiled_inside(function: Function) -> Function:
    """Compile a `compiled_loop` into each place that calls it: a small one, called very often.

    Where the caller's sums may be taken in any order, so may those in here.
    """
    return cast(Function, register_jitable(**INSIDE)(function))


def _do_without_disk(entry: Any) -> None:  # noqa: ANN401
    """Let a function be compiled and run also when its machine code cannot be saved or read.

    A disk may be full, or a folder gone, long after it was found that it can be written to; Numba
    would raise that at the call, though it has compiled the function.
    """
    # Without Numba's compiler, for a debugger, the function is as it was.
    cache = getattr(entry, "_cache", None)
    if cache is not None:
        cache.load_overload = _or_warn(cache.load_overload)
        cache.save_overload = _or_warn(cache.save_overload)


def _or_warn(access: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that does the same, and warns where the disk refuses it."""

    def access_or_warn(*arguments: Any) -> Any:  # noqa: ANN401
        try:
            return access(*arguments)
        except OSError as error:
            _warn_of_disk(error.strerror or type(error).__name__)
            return None

    return access_or_warn


@cache
def _warn_of_disk(reason: str) -> None:
    """Warn that machine code is not kept; once, for all functions have the same reason."""
    warnings.warn(
        f"compiled code is not kept ({reason}), so that each start compiles anew; make room on the"
        " disk, or set NUMBA_CACHE_DIR",
        RuntimeWarning,
        stacklevel=1,
    )


def _cache_folders() -> Iterator[Path]:
    """Yield where machine code may be kept, the best place first.

    The folder that `NUMBA_CACHE_DIR` names, else that of the user, else the package's own.
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named:
        yield Path(named) / "cable_tracker"
        return
    of_user = os.environ.get("XDG_CACHE_HOME")
    if of_user:
        yield Path(of_user) / "cable_tracker"
    with suppress(RuntimeError):  # There may be no home.
        yield Path.home() / ".cache" / "cable_tracker"
    yield PACKAGE / "__pycache__" / "kernels"


def _writable(bases: Iterator[Path], digest: str) -> Path | None:
    """Return the folder of a digest in the first base that can be written to; None if none can."""
    for base in bases:
        folder = base / digest
        if _can_write(folder):
            return folder
    return None


@cache
def _can_write(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def digest_of(source: Path) -> str:
    """Return what names the machine code of a module of this package.

    It changes with the text of the module, of any that it imports, however far, and with Numba.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(_sources_of(source)):
        digest.update(_text_of(path).encode())
    return digest.hexdigest()[:DIGITS]


@cache
def _sources_of(source: Path) -> frozenset[Path]:
    """Return the files of a module and of all modules of this package that it needs."""
    found: set[Path] = set()
    left = [source]
    while left:
        path = left.pop()
        if path not in found:
            found.add(path)
            left += _imported_by(path)
    return frozenset(found)


@cache
def _imported_by(source: Path) -> tuple[Path, ...]:
    paths = []
    for dotted in IMPORTED.findall(_text_of(source)):
        path = PACKAGE.joinpath(*dotted.strip(".").split("."))
        # Of a folder any module may be meant.
        paths += sorted(path.glob("*.py")) if path.is_dir() else [path.with_suffix(".py")]
    return tuple(paths)


@cache
def _text_of(source: Path) -> str:
    return source.read_text(encoding="utf-8")
