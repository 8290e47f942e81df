"""What Numba makes of entries and of parts: machine code, and code to be linked.

Numba optimises every function on its own and turns it into machine code, then does both again in
each function that calls it. The machine code of a part is never run. So while an entry is compiled,
the functions that it calls are kept as they were translated; all of them are linked into the entry
once, and optimised there as a whole.

The classes derive from Numba's own, and override what is not of its documented interface; the
versions that are tested are those of the constraints files.
"""

from __future__ import annotations

import gc
import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import llvmlite.binding as llvm
import numba
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.environment import lookup_environment
from numba.core.types.functions import BaseFunction
from numba.core.types.misc import unliteral
from numba.core.typing.templates import infer_global
from numba.extending import models, register_model

Function = TypeVar("Function", bound=Callable[..., Any])

ENVIRONMENT = "_ZN08NumbaEnv"
"""Beginning of the names of variables that hold what a function needs of Python."""

FLAGS_HASH = hash(Flags())
"""Numba hashes the names of the options alone."""

OPERATORS = frozenset(each for each in vars(operator).values() if callable(each))
"""Operators of Python, which do not depend on the options of a compiler."""

FUNCTION_TYPE: Any = BaseFunction
"""The type of what Numba knows several implementations of."""


class _NoEngine:
    """Takes what Numba would tell the engine of a function that has machine code."""

    def set_env(self, name: str, environment: object) -> None:
        """Do nothing: entries set the variables of all that is linked into them."""


class PartLibrary(JITCodeLibrary):  # type: ignore[misc]
    """A function that is linked into entries.

    A function that is not of this package may need it too: Numba keeps what it compiled once. For
    such a one it is made as Numba would have made it, with machine code of its own.
    """

    def __init__(self, codegen: Any, name: str) -> None:  # noqa: ANN401
        super().__init__(codegen, name)
        self._exported: list[str] = []
        self._on_its_own: EntryLibrary | None = None

    @property
    def codegen(self) -> _NoEngine:
        """What is told of the function's machine code, which it has not."""
        return _NoEngine()

    def _optimize_functions(self, ll_module: Any) -> None:  # noqa: ANN401
        ll_module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        """Make the function ready to be linked; what it calls is linked into the entry."""
        self._raise_if_finalized()
        for library in self._linking_libraries:
            _inherit_initialisers(self, library)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                # Several entries may have it, and none keeps it that has no use for it.
                function.linkage = llvm.Linkage.linkonce_odr
                self._exported.append(function.name)
        self._finalize_dynamic_globals()
        self._finalized = True

    def translated(self) -> Any:  # noqa: ANN401
        """Return the module of the function alone, neither optimised nor linked."""
        self._ensure_finalized()
        return self._final_module

    def get_pointer_to_function(self, name: str) -> int:
        """Return the address of what Python calls; 0 if Python does not call this function."""
        self._ensure_finalized()
        return self._compiled_alone().get_pointer_to_function(name) if name in self._exported else 0

    def _get_module_for_linking(self) -> Any:  # noqa: ANN401
        return self._compiled_alone()._get_module_for_linking()

    def _compiled_alone(self) -> EntryLibrary:
        self._ensure_finalized()
        if self._on_its_own is None:
            library = EntryLibrary(self._codegen, self.name)
            library._final_module = self._final_module.clone()
            for name in self._exported:
                library._final_module.get_function(name).linkage = llvm.Linkage.external
            library._linking_libraries = self._linking_libraries
            library.finalize()
            self._on_its_own = library
        return self._on_its_own

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> Any:  # noqa: ANN401
        # What is on disk is an entry, also where another one calls it.
        with _making(codegen, JITCodeLibrary):
            return JITCodeLibrary._unserialize(codegen, state)


class EntryLibrary(JITCodeLibrary):  # type: ignore[misc]
    """A function that Python calls, with all that it calls in turn."""

    def finalize(self) -> None:
        """Link, optimise, and make machine code."""
        self._raise_if_finalized()
        for library in _needed_by(self):
            _inherit_initialisers(self, library)
            self._final_module.link_in(_linkable(library), preserve=True)
        self._optimize_final_module()
        self._final_module.verify()
        self._finalize_final_module()
        self._set_environments()

    def _set_environments(self) -> None:
        for variable in self._final_module.global_variables:
            if variable.name.startswith(ENVIRONMENT):
                environment = lookup_environment(variable.name)
                if environment is not None:
                    self._codegen.set_env(variable.name, environment)


def _linkable(library: JITCodeLibrary) -> Any:  # noqa: ANN401
    """Return the module of a function that an entry calls; parts come without what they call."""
    if isinstance(library, PartLibrary):
        return library.translated()
    return library._get_module_for_linking()


def _needed_by(library: JITCodeLibrary) -> list[JITCodeLibrary]:
    """Return what a function calls, directly or through parts, each once."""
    found: dict[int, JITCodeLibrary] = {}
    left = list(library._linking_libraries)
    while left:
        each = left.pop(0)
        if id(each) not in found:
            found[id(each)] = each
            if isinstance(each, PartLibrary):
                left += each._linking_libraries
    return list(found.values())


def _inherit_initialisers(library: JITCodeLibrary, needed: JITCodeLibrary) -> None:
    """Let a function run, when it is loaded from disk, what one that it calls needs."""
    # Older versions of Numba keep them elsewhere.
    if hasattr(library, "_reload_init"):
        library._reload_init.update(needed._reload_init)


@contextmanager
def _making(codegen: Any, kind: type) -> Iterator[None]:  # noqa: ANN401
    """Let Numba keep functions as libraries of a kind. Its lock of the compiler is held."""
    before = codegen._library_class
    codegen._library_class = kind
    try:
        yield
    finally:
        codegen._library_class = before


@contextmanager
def _without_collection() -> Iterator[None]:
    """Do without the collector of garbage. Numba's lock of the compiler is held.

    A compiler makes millions of objects, of which most live until it ends: to look through them
    again and again takes a fifth of its time.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _same_flags(self: Flags, other: object) -> bool:
    """Tell whether two compilers have the same options: those that neither sets are the same."""
    if not isinstance(other, Flags):
        return False
    if bool(self._values == other._values):
        return True
    either = self._values.keys() | other._values.keys()
    return all(getattr(self, name) == getattr(other, name) for name in either)


def _hash_of_flags(self: Flags) -> int:
    """Return what Numba does, the same number for all."""
    return FLAGS_HASH


@contextmanager
def _quickly_compared_flags() -> Iterator[None]:
    """Let Numba compare options of compilers by those that are set. Its lock is held.

    It does so some 100 000 times for a large entry, and reads all options each time: an eighth of
    the time of compiling.
    """
    before = Flags.__eq__, Flags.__hash__
    Flags.__eq__, Flags.__hash__ = _same_flags, _hash_of_flags
    try:
        yield
    finally:
        Flags.__eq__, Flags.__hash__ = before


@contextmanager
def _operators_typed_once() -> Iterator[None]:
    """Let Numba find the type of an operator's result once for each kind of operands.

    Its lock is held. A large entry adds, multiplies and indexes thousands of times, with operands
    of a few dozen kinds, and each time Numba goes through all implementations that it knows: an
    eighth of the time of compiling.
    """
    before = FUNCTION_TYPE.get_call_type
    known: dict[tuple[BaseFunction, tuple[types.Type, ...]], Any] = {}

    def get_call_type(function: BaseFunction, context: Any, args: Any, kws: Any) -> Any:  # noqa: ANN401
        if kws or function.typing_key not in OPERATORS:
            return before(function, context, args, kws)
        operands = (function, tuple(args))
        if operands not in known:
            known[operands] = before(function, context, args, kws)
        return known[operands]

    FUNCTION_TYPE.get_call_type = get_call_type
    try:
        yield
    finally:
        FUNCTION_TYPE.get_call_type = before


@contextmanager
def _quick_compiler() -> Iterator[None]:
    """Let Numba do what takes long for large entries in less time. Its lock is held."""
    with _without_collection(), _quickly_compared_flags(), _operators_typed_once():
        yield


class EntryCompiler(Compiler):  # type: ignore[misc]
    """Compiles an entry; all that it calls is compiled as parts."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:  # noqa: ANN401
        """Return what Numba's compiler does."""
        codegen = self.state.targetctx.codegen()
        self.state.library = EntryLibrary(codegen, func.__qualname__)
        self.state.library.enable_object_caching()
        with _making(codegen, PartLibrary), _quick_compiler():
            return super().compile_extra(func)


class PartType(types.Dispatcher):
    """The type of a part within compiled code: it is compiled once for each kind of arguments.

    Numba would compile it anew for each kind of function that calls it, and for each number that
    stands in a call.
    """

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:  # noqa: ANN401
        """Return what Numba's type does, numbers in the call being variables."""
        plain = {name: unliteral(each) for name, each in kws.items()}
        return super().get_call_type(context, tuple(unliteral(each) for each in args), plain)


register_model(PartType)(models.OpaqueModel)

_PARTS: list[Any] = []
"""What compiles the parts: types refer to it weakly."""


def register_part(function: Function, options: dict[str, Any]) -> Function:
    """Let compiled functions call a function, which stays as it is for Python."""
    if not numba.config.DISABLE_JIT:
        part = numba.njit(**options)(function)
        _PARTS.append(part)
        infer_global(function, PartType(part))
    return function
