"""Named sets of parameters."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_table import named

TARGET_PRESETS: Mapping[str, TargetParameters] = MappingProxyType(
    {
        "default": TargetParameters(),
        # Ha (2008): Table 7 with the weights of (30), N = 50, L = 5, variances of section 6.2.
        "thesis": TargetParameters(filter="blobs", particle_count=50, position_variance=7.0),
        # Rigid, of known size, approached slowly.
        "docking": TargetParameters(
            shape_rate=0.02, angle_sigma=1.5, scale_sigma=0.02, prior_softness=0.06,
            grey_prior_softness=0.06, position_variance=4.0,
        ),
        # Arms and legs move: a shape that is hardly to be relied on.
        "diver": TargetParameters(
            shape_rate=0.25, prior_softness=0.2, grey_prior_softness=0.2, angle_sigma=4.0,
            scale_sigma=0.05,
        ),
    }
)  # fmt: skip


def target_preset(name: str) -> TargetParameters:
    """Return the parameters of a preset.

    Raises
    ------
    ParameterError
        There is no such preset.
    """
    return named("preset", name, TARGET_PRESETS)
