"""Stands for launch 3.4 and launch_ros 0.26 of ROS 2 Jazzy, which PyPI does not have.

Strict: it has only what is listed here, takes arguments by the names and kinds that Jazzy takes,
and refuses every type that Jazzy refuses. `run` plays a launch file; it returns what would start.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import yaml


class Substitution:
    def perform(self, context: LaunchContext) -> str:
        raise NotImplementedError


def substitutions(value: Any) -> list[Substitution]:
    """Normalise what Jazzy calls SomeSubstitutionsType: str, Substitution, or iterable of these."""

    def one(item: Any) -> Substitution:
        if isinstance(item, Substitution):
            return item
        if isinstance(item, str):
            return TextSubstitution(text=item)
        raise TypeError(f"Failed to normalize given item of type '{type(item)}'")

    if isinstance(value, (str, Substitution)):
        return [one(value)]
    return [one(item) for item in value]


def perform(context: LaunchContext, parts: Iterable[Substitution]) -> str:
    return "".join(part.perform(context) for part in parts)


def need(value: Any, *kinds: type) -> None:
    if not isinstance(value, kinds):
        raise TypeError(f"{value!r} is none of {kinds}")


def is_true(text: str) -> bool:
    if text.lower() in ("true", "1"):
        return True
    if text.lower() in ("false", "0"):
        return False
    raise ValueError(f"{text!r} is no boolean")


class TextSubstitution(Substitution):
    def __init__(self, *, text: str) -> None:
        need(text, str)
        self._text = text

    def perform(self, context: LaunchContext) -> str:
        return self._text


class LaunchConfiguration(Substitution):
    def __init__(self, variable_name: Any) -> None:
        self._name = substitutions(variable_name)

    def perform(self, context: LaunchContext) -> str:
        name = perform(context, self._name)
        context.read.add(name)
        if name not in context.configurations:
            raise RuntimeError(f"launch configuration '{name}' does not exist")
        return context.configurations[name]


class PathJoinSubstitution(Substitution):
    def __init__(self, substitutions: Iterable[Any]) -> None:
        self._parts = globals()["substitutions"](substitutions)

    def perform(self, context: LaunchContext) -> str:
        return str(Path(*(part.perform(context) for part in self._parts)))


class IfElseSubstitution(Substitution):
    def __init__(self, condition: Any, if_value: Any = "", else_value: Any = "") -> None:
        if if_value == else_value == "":
            raise RuntimeError("One of if_value and else_value must be specified")
        self._condition = substitutions(condition)
        self._values = (substitutions(if_value), substitutions(else_value))

    def perform(self, context: LaunchContext) -> str:
        chosen = 0 if is_true(perform(context, self._condition)) else 1
        return perform(context, self._values[chosen])


class EqualsSubstitution(Substitution):
    def __init__(self, left: Any, right: Any) -> None:
        self._left, self._right = substitutions(left), substitutions(right)

    def perform(self, context: LaunchContext) -> str:
        return str(perform(context, self._left) == perform(context, self._right)).lower()


class FindPackageShare(Substitution):
    def __init__(self, package: Any) -> None:
        self._package = substitutions(package)

    def perform(self, context: LaunchContext) -> str:
        name = perform(context, self._package)
        if name not in context.shares:
            raise RuntimeError(f"package '{name}' not found")
        return str(context.shares[name])


class LaunchDescriptionEntity:
    def visit(self, context: LaunchContext) -> None:
        raise NotImplementedError


class Action(LaunchDescriptionEntity):
    pass


class DeclareLaunchArgument(Action):
    def __init__(
        self,
        name: str,
        *,
        default_value: Any = None,
        description: str | None = None,
        choices: list[str] | None = None,
    ) -> None:
        need(name, str)
        need(description, str, type(None))
        need(choices, list, type(None))
        for choice in choices or ():
            need(choice, str)
        self.name, self.description, self.choices = name, description, choices
        self.default = None if default_value is None else substitutions(default_value)

    def visit(self, context: LaunchContext) -> None:
        context.declared.append(self)
        if self.name not in context.configurations:
            if self.default is None:
                raise RuntimeError(f"Required launch argument '{self.name}' was not provided")
            context.configurations[self.name] = perform(context, self.default)
        value = context.configurations[self.name]
        if self.choices is not None and value not in self.choices:
            raise RuntimeError(f"{self.name}: {value!r} is none of {self.choices}")


class LaunchDescription(LaunchDescriptionEntity):
    def __init__(self, initial_entities: Iterable[LaunchDescriptionEntity]) -> None:
        self.entities = list(initial_entities)
        for entity in self.entities:
            need(entity, LaunchDescriptionEntity)

    def visit(self, context: LaunchContext) -> None:
        for entity in self.entities:
            entity.visit(context)


class PythonLaunchDescriptionSource:
    def __init__(self, launch_file_path: Any) -> None:
        self.path = substitutions(launch_file_path)


class IncludeLaunchDescription(Action):
    def __init__(
        self,
        launch_description_source: PythonLaunchDescriptionSource,
        *,
        launch_arguments: Iterable[tuple[Any, Any]] | None = None,
    ) -> None:
        need(launch_description_source, PythonLaunchDescriptionSource)
        self._source = launch_description_source
        self._arguments = [
            (substitutions(name), substitutions(value)) for name, value in launch_arguments or ()
        ]

    def visit(self, context: LaunchContext) -> None:
        given = {perform(context, name): perform(context, value) for name, value in self._arguments}
        # Not scoped: what is set here stays visible in the file that includes.
        context.configurations.update(given)
        description = description_of(Path(perform(context, self._source.path)))
        names = {each.name for each in description.entities if hasattr(each, "default")}
        unknown = given.keys() - names
        if unknown:
            raise RuntimeError(f"the included file declares no {unknown}")
        description.visit(context)


class ParameterValue:
    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        if value_type not in (None, bool, int, float, str):
            raise TypeError(f"value_type {value_type!r}")
        self._value, self._type = value, value_type

    def evaluate(self, context: LaunchContext) -> Any:
        if isinstance(self._value, (bool, int, float)):
            return self._value
        text = perform(context, substitutions(self._value))
        value = text if self._type is str else yaml.safe_load(text)
        if self._type is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if self._type is not None and type(value) is not self._type:
            raise ValueError(f"{text!r} is no {self._type.__name__}")
        return value


@dataclass(frozen=True, eq=False)
class StartedNode:
    """A node as it would be started.

    `parameters` holds paths of files and dicts of values, in their order.
    """

    package: str
    executable: str
    namespace: str
    parameters: tuple[Any, ...]
    remappings: dict[str, str]
    ros_arguments: tuple[str, ...]

    def values(self) -> dict[str, Any]:
        """Return the values that do not stand in files."""
        return {name: value for each in self.parameters if isinstance(each, dict)
                for name, value in each.items()}  # fmt: skip

    def files(self) -> list[Path]:
        return [each for each in self.parameters if isinstance(each, Path)]

    def arguments(self, folder: Path) -> list[str]:
        """Return what follows ``--ros-args``, as launch_ros passes it; dicts go into files."""
        words = [*self.ros_arguments]
        if self.namespace:
            words += ["-r", f"__ns:=/{self.namespace.strip('/')}"]
        for number, each in enumerate(self.parameters):
            path = each
            if isinstance(each, dict):
                path = folder / f"{self.executable}_{number}.yaml"
                path.write_text(yaml.safe_dump({"/**": {"ros__parameters": each}}))
            words += ["--params-file", str(path)]
        for source, target in self.remappings.items():
            words += ["-r", f"{source}:={target}"]
        return words


class Node(Action):
    def __init__(
        self,
        *,
        executable: Any,
        package: Any,
        namespace: Any = "",
        parameters: Any = (),
        remappings: Any = (),
        ros_arguments: Any = (),
        output: Any = "log",
    ) -> None:
        need(parameters, list, tuple)
        substitutions(output)
        self._texts = [substitutions(each) for each in (package, executable, namespace)]
        self._parameters = [self._checked(each) for each in parameters]
        self._remappings = [
            (substitutions(source), substitutions(target)) for source, target in remappings
        ]
        self._ros_arguments = [substitutions(each) for each in ros_arguments]

    @staticmethod
    def _checked(each: Any) -> Any:
        if not isinstance(each, Mapping):
            return substitutions(each)
        for key, value in each.items():
            substitutions(key)
            if not isinstance(value, (ParameterValue, bool, int, float)):
                substitutions(value)
        return each

    def _evaluated(self, context: LaunchContext, each: Any) -> Any:
        if not isinstance(each, Mapping):
            path = Path(perform(context, each))
            if not path.is_file():
                raise RuntimeError(f"Parameter file path is not a file: {path}")
            return path
        return {
            perform(context, substitutions(key)): (
                value if isinstance(value, ParameterValue) else ParameterValue(value)
            ).evaluate(context)
            for key, value in each.items()
        }

    def visit(self, context: LaunchContext) -> None:
        context.started.append(
            StartedNode(
                *(perform(context, each) for each in self._texts),
                tuple(self._evaluated(context, each) for each in self._parameters),
                {perform(context, a): perform(context, b) for a, b in self._remappings},
                tuple(perform(context, each) for each in self._ros_arguments),
            )
        )


class Shutdown:
    pass


class EmitEvent(Action):
    def __init__(self, *, event: Shutdown) -> None:
        need(event, Shutdown)
        self.event = event

    def visit(self, context: LaunchContext) -> None:
        raise AssertionError("visited only when something has happened")


class OnProcessExit:
    def __init__(self, *, on_exit: list[Action]) -> None:
        for each in on_exit:
            need(each, Action)
        self.on_exit = on_exit


class RegisterEventHandler(Action):
    def __init__(self, event_handler: OnProcessExit) -> None:
        need(event_handler, OnProcessExit)
        self.handler = event_handler

    def visit(self, context: LaunchContext) -> None:
        context.handlers.append(self.handler)


@dataclass
class LaunchContext:
    """What is known while a launch file is played."""

    configurations: dict[str, str]
    shares: dict[str, Path]
    declared: list[DeclareLaunchArgument] = field(default_factory=list)
    read: set[str] = field(default_factory=set)
    started: list[StartedNode] = field(default_factory=list)
    handlers: list[OnProcessExit] = field(default_factory=list)


MODULES: dict[str, tuple[Any, ...]] = {
    "launch": (LaunchDescription, LaunchContext, LaunchDescriptionEntity, Action, Substitution),
    "launch.actions": (
        DeclareLaunchArgument, EmitEvent, IncludeLaunchDescription, RegisterEventHandler,
    ),
    "launch.event_handlers": (OnProcessExit,),
    "launch.events": (Shutdown,),
    "launch.launch_description_sources": (PythonLaunchDescriptionSource,),
    "launch.substitutions": (
        EqualsSubstitution, IfElseSubstitution, LaunchConfiguration, PathJoinSubstitution,
        TextSubstitution,
    ),
    "launch_ros": (),
    "launch_ros.actions": (Node,),
    "launch_ros.parameter_descriptions": (ParameterValue,),
    "launch_ros.substitutions": (FindPackageShare,),
}  # fmt: skip


@contextmanager
def installed() -> Iterator[None]:
    """Let `import launch` find the stand-in."""
    before = {name: sys.modules.get(name) for name in MODULES}
    for name, members in MODULES.items():
        module = ModuleType(name)
        module.__path__ = []
        for member in members:
            setattr(module, member.__name__, member)
        sys.modules[name] = module
    try:
        yield
    finally:
        for name, module in before.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module


def description_of(path: Path) -> LaunchDescription:
    """Load a launch file, and ask it for its description."""
    spec = importlib.util.spec_from_file_location(f"launch_file_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with installed():
        spec.loader.exec_module(module)
        make: Callable[[], Any] = module.generate_launch_description
        description = make()
    need(description, LaunchDescription)
    return description


def run(path: Path, shares: Mapping[str, Path], **arguments: str) -> LaunchContext:
    """Play a launch file as ``ros2 launch PACKAGE FILE name:=value ...`` would."""
    context = LaunchContext(dict(arguments), dict(shares))
    description_of(path).visit(context)
    return context
