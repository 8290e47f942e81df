"""A node in a process of its own, started and stopped by ours."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from typing import Self

START_TIMEOUT = 300.0
"""Longest time in which nodes find each other, with the compiling at first use [s]."""

WARM_UP_TIMEOUT = 900.0
"""Compiling at first use may take minutes on a busy machine; no frame is used before [s]."""

ENTRY = "cable_tracker.ros.entry"
"""Module that runs the node whose name it is given."""

GRACE = 30.0
"""Time that a node gets to end by itself after SIGTERM [s]."""


class NodeProcess:
    """Runs one of our nodes; to be used as a context manager, which stops it.

    Parameters
    ----------
    node : str
        Name of the node in `cable_tracker.ros.entry.NODES`.
    arguments : sequence of str
        Command line arguments after ``--ros-args``.
    environment : mapping
        Environment of the process.
    module : str
        Python module to run, with the node's name as its first argument.
    """

    def __init__(
        self,
        node: str,
        arguments: Sequence[str],
        environment: Mapping[str, str],
        module: str = ENTRY,
    ) -> None:
        self._command = [sys.executable, "-m", module, node, "--ros-args", *arguments]
        # Written line by line: the log holds a dying node's words, in the order it said them.
        self._environment = {**environment, "PYTHONUNBUFFERED": "1"}

    def __enter__(self) -> Self:
        # A file, not a pipe: none is read while frames run, and a full pipe would stop the node.
        self._log = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")
        self._process = subprocess.Popen(
            self._command,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        return self

    def __exit__(self, *_error: object) -> None:
        self.stop()
        self._log.close()

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    @property
    def running(self) -> bool:
        """Whether the process is alive."""
        return self._process.poll() is None

    def wait(self, timeout: float) -> int | None:
        """Wait for the process to end by itself; return its exit code, or None if it has not."""
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            return None

    def stop(self) -> int:
        """Ask the process to end, kill it if it does not, and return its exit code."""
        return end_process(self._process, GRACE)

    def last_line(self) -> str:
        """Return the last line that the process printed."""
        self._log.seek(0)
        return last_line_of(self._log) or "it printed nothing"


def end_process(process: subprocess.Popen[bytes], grace: float) -> int:
    """Ask a process to end, kill it if it has not after a time [s], and return its exit code."""
    # SIGINT would be lost on a node that is still importing where our own parent ignores it, as a
    # shell does for what it runs in the background.
    process.terminate()
    try:
        return process.wait(grace)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def last_line_of(lines: Iterable[str]) -> str:
    """Return the last line that is not blank, without the blanks about it; empty without one."""
    return next((line.strip() for line in reversed(list(lines)) if line.strip()), "")
