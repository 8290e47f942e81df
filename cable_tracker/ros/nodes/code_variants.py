"""Which compiled code the parameters of the cable tracker choose."""

from __future__ import annotations

from typing import TypeAlias

from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE, TrackerParameters

Variant: TypeAlias = tuple[str, ...]

ENOUGH = 200
"""Number of particles of a warm-up; compilation does not depend on it."""


def variant_of(parameters: TrackerParameters) -> Variant:
    """Return the words among the parameters: they choose which code runs, numbers do not."""
    values = parameters.as_mapping()
    return tuple(str(values[spec.name]) for spec in PARAMETER_TABLE if spec.choices)


def few_particles(parameters: TrackerParameters) -> TrackerParameters:
    """Return the parameters with no more particles than it takes to run every line once."""
    return parameters.replaced({"particle_count": min(parameters.particle_count, ENOUGH)})
