"""Nodes that work together, each in a process of its own."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Self

from cable_tracker.ros.process.child_process import ENTRY, NodeProcess
from cable_tracker.ros.process.environment import local_environment
from cable_tracker.sequences.node_topics import DIAGNOSTICS
from cable_tracker.tracking.parameter_files import write_node_parameters
from cable_tracker.tracking.parameter_table import ParameterValue


class NodeGroup:
    """Starts nodes under one namespace; to be used as a context manager, which stops them all.

    Parameters
    ----------
    namespace : str
        Namespace of the nodes. One that contains this process's id keeps them from meeting others.
    remappings : mapping
        Other names of topics, for all of them; `/diagnostics` goes into the namespace anyhow.
    """

    def __init__(self, namespace: str, remappings: Mapping[str, str] | None = None) -> None:
        self._namespace = namespace
        self._remappings = {DIAGNOSTICS.global_name: DIAGNOSTICS.name, **(remappings or {})}
        self._running: list[tuple[NodeProcess, str, bool]] = []

    def __enter__(self) -> Self:
        self._stack = ExitStack()
        self._folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory()))
        return self

    def __exit__(self, *_error: object) -> None:
        self._stack.close()

    def start(
        self,
        name: str,
        parameters: Mapping[str, ParameterValue],
        remappings: Mapping[str, str] | None = None,
        *,
        may_end: bool = False,
        module: str = ENTRY,
    ) -> NodeProcess:
        """Start a node.

        Parameters
        ----------
        name : str
            Name of the node, unique in its group.
        parameters : mapping
            Parameters of the node; others keep their defaults.
        remappings : mapping
            Other names of topics, for this node.
        may_end : bool
            It ends by itself when its work is done.
        module : str
            Python module to run, with the node's name as its first argument.
        """
        arguments = ["-r", f"__ns:={self._namespace}"]
        if parameters:
            file = self._folder / f"{name}.yaml"
            write_node_parameters(file, parameters)
            arguments += ["--params-file", str(file)]
        for old, new in {**self._remappings, **(remappings or {})}.items():
            arguments += ["-r", f"{old}:={new}"]
        process = self._stack.enter_context(
            NodeProcess(name, arguments, local_environment(), module)
        )
        self._running.append((process, name, may_end))
        return process

    def what_has_died(self) -> str:
        """Return which node has died, with its last words; empty if none has.

        A node that may end has not died if its exit code is 0.
        """
        for process, name, may_end in self._running:
            if not process.running and not (may_end and process.wait(0.0) == 0):
                return f"the {name} node has died: {process.last_line()}"
        return ""
