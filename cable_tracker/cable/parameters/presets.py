"""Named sets of parameters."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.tracking.parameter_table import named

PRESETS: Mapping[str, TrackerParameters] = MappingProxyType(
    {
        "default": TrackerParameters(),
        # Pipes as inspections by ROV show them: wide, mostly up the picture, wider below. A shadow
        # beside one is often narrower than any pipe.
        "pipeline": TrackerParameters(
            width_minimum=24.0,
            width_maximum=260.0,
            initial_angle_range=60.0,
            initial_width_minimum=32.0,
            initial_width_maximum=230.0,
            initial_skew_minimum=-5.0,
        ),
        # Wirth's thesis: Tables 5.1 and 5.2, multinomial resampling, undamped rates, a point every
        # 20 px. Only its responses are read from scan lines, which costs less.
        "thesis": TrackerParameters(
            filter="bootstrap",
            observation="responses",
            resampling="multinomial",
            limit_handling="clip",
            distance_variance=0.5,
            angle_variance=0.01,
            width_variance=4.0,
            skew_variance=0.1,
            distance_rate_variance=8.0,
            angle_rate_variance=0.005,
            width_rate_variance=0.0,
            skew_rate_variance=0.0,
            rate_damping=1.0,
            diffusion_degrees_of_freedom=0.0,
            width_minimum=4.0,
            width_maximum=160.0,
            skew_limit=20.0,
            initial_distance_range=150.0,
            initial_angle_range=45.0,
            initial_width_minimum=5.0,
            initial_width_maximum=100.0,
            initial_skew_minimum=0.0,
            initial_skew_maximum=10.0,
            sample_spacing=20.0,
            light_correction=0.0,
            burned_in_time=0.0,
            detector="none",
            looks="borders",
            evidence_to_track=1.6,
            evidence_to_lose=1.0,
            confirmation_time=0.12,
            loss_time=0.4,
        ),
    }
)


def preset(name: str) -> TrackerParameters:
    """Return the parameters of a preset.

    Raises
    ------
    ParameterError
        There is no such preset.
    """
    return named("preset", name, PRESETS)
