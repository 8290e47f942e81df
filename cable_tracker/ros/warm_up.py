"""Compiles what the tracker needs before frames come, beside the node's own work."""

from __future__ import annotations

import threading
import time
from typing import TypeAlias

from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE, TrackerParameters
from cable_tracker.trackers import warm_up

Variant: TypeAlias = tuple[str, ...]

ENOUGH = 200
"""Particles of a warm-up: the compiler does not care how many there are."""

_WARM: set[Variant] = set()
"""Variants that this process has run already."""


def variant_of(parameters: TrackerParameters) -> Variant:
    """Return the words among the parameters: they choose which code runs, numbers do not."""
    values = parameters.as_mapping()
    return tuple(str(values[spec.name]) for spec in PARAMETER_TABLE if spec.choices)


def few_particles(parameters: TrackerParameters) -> TrackerParameters:
    """Return the parameters with no more particles than it takes to run every line once."""
    return parameters.replaced({"particle_count": min(parameters.particle_count, ENOUGH)})


class WarmUp:
    """Runs a tracker of its own on a few frames, in a thread.

    The node can answer services, publish its diagnostics and be stopped meanwhile. The thread is a
    daemon: whoever ends the process need not wait for the compiler.
    """

    def __init__(self, parameters: TrackerParameters) -> None:
        self._parameters = parameters
        self._variant = variant_of(parameters)
        self._begin = time.monotonic()
        self._error: Exception | None = None
        self._thread: threading.Thread | None = None
        if self._variant not in _WARM:
            self._thread = threading.Thread(target=self._run, name="warm-up", daemon=True)
            self._thread.start()

    def _run(self) -> None:
        try:
            warm_up(few_particles(self._parameters))
            _WARM.add(self._variant)
        except Exception as error:  # noqa: BLE001  Raised again in the node's own thread.
            self._error = error

    @property
    def running(self) -> bool:
        """Whether it still compiles."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def seconds(self) -> float:
        """Time since it began [s]."""
        return time.monotonic() - self._begin

    def finish(self) -> None:
        """Wait for the end, and raise what was raised in the thread."""
        if self._thread is not None:
            self._thread.join()
        if self._error is not None:
            raise self._error
