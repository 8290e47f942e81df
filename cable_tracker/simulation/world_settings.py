"""Settings that every simulated vehicle in its world has."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.simulation.setting_checks import LARGEST_SIDE, SMALLEST_SIDE
from cable_tracker.tracking.parameter_table import ParameterSet, number


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldSettings(ParameterSet):
    """Seed and camera of a world; each kind of world adds its own."""

    seed: int = number(
        0,
        "",
        0,
        2**31 - 1,
        "Seed of the random numbers; the same seed gives the same world and the same errors.",
    )
    image_width: int = number(
        320, "", SMALLEST_SIDE, LARGEST_SIDE, "Width of the camera's images [px]."
    )
    image_height: int = number(
        240, "", SMALLEST_SIDE, LARGEST_SIDE, "Height of the camera's images [px]."
    )
    rate: float = number(12.5, "1/s", 1.0, 100.0, "Frame rate.")

    @property
    def image_size(self) -> tuple[int, int]:
        """Width and height of the images [px]."""
        return self.image_width, self.image_height
