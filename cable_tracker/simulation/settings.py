"""Settings that every simulated vehicle in its world has, and checks of settings."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_table import ParameterSet, number

SMALLEST_SIDE, LARGEST_SIDE = 32, 4096
"""Smallest and largest side of images [px]."""

SMALLEST_RATE, LARGEST_RATE = 1e-3, 1e6
"""Smallest and largest frame rate [frames per second]: stamps are in whole nanoseconds."""


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


def check_size(image_size: tuple[int, int]) -> None:
    """Check the size of images [px].

    Raises
    ------
    ParameterError
        A side is out of its limits.
    """
    if not all(SMALLEST_SIDE <= side <= LARGEST_SIDE for side in image_size):
        raise ParameterError(
            f"image_size is {image_size[0]}x{image_size[1]}: "
            f"give a width and height of {SMALLEST_SIDE} to {LARGEST_SIDE} px"
        )


def check_seed(seed: int, name: str = "seed") -> None:
    """Check that a seed is not negative.

    Raises
    ------
    ParameterError
        The seed is negative.
    """
    if seed < 0:
        raise ParameterError(f"{name} is {seed}: give a number that is not negative")


def check_frames(count: int, rate: float) -> None:
    """Check number and rate of the frames of a dive [frames per second].

    Raises
    ------
    ParameterError
        There are none, or the rate is out of its limits.
    """
    if count < 1:
        raise ParameterError(f"frame_count is {count}: simulate at least 1 frame")
    if not SMALLEST_RATE <= rate <= LARGEST_RATE:
        raise ParameterError(
            f"rate is {rate}: give {SMALLEST_RATE:g} to {LARGEST_RATE:.0f} frames per second"
        )


def check_range(name: str, value: float, limits: tuple[float, float], unit: str) -> None:
    """Check that a number is within its limits.

    Raises
    ------
    ParameterError
        The value is out of its limits, or NaN.
    """
    least, most = limits
    if not least <= value <= most:
        raise ParameterError(f"{name} is {value}: give {least:g} to {most:g} {unit}")
