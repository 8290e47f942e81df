"""Palette that is safe for colour-blind viewers (Okabe and Ito, 2008).

Red, green, blue from 0 to 255. Words and line styles always say the same as a colour does.
"""

from __future__ import annotations

from typing import TypeAlias

from cable_tracker.tracking.status import TrackingStatus

Colour: TypeAlias = tuple[int, int, int]

GREEN: Colour = (0, 190, 130)
RED: Colour = (230, 95, 20)
AMBER: Colour = (240, 180, 0)
GREY: Colour = (170, 170, 170)
PINK: Colour = (255, 130, 200)
STRAW: Colour = (215, 205, 140)
SKY: Colour = (86, 180, 233)
WHITE: Colour = (255, 255, 255)
BLACK: Colour = (0, 0, 0)

ESTIMATE = GREEN
HYPOTHESES = STRAW
TRUTH = PINK
PARTICLES = SKY

STATUS_COLOURS = {
    TrackingStatus.TRACKING.value: GREEN,
    TrackingStatus.LOST.value: RED,
    TrackingStatus.INITIALISING.value: AMBER,
}
"""Colours of the statuses; every other one (REFUSED, STALE, DISABLED) is grey."""


def status_colour(status: str) -> Colour:
    """Return the colour of a status."""
    return STATUS_COLOURS.get(status, GREY)


def to_bgr(colour: Colour) -> Colour:
    """Reverse the order of the channels, as OpenCV has it."""
    return colour[::-1]


def to_unit(colour: Colour) -> tuple[float, float, float]:
    """Scale the channels to 0..1, as matplotlib has it."""
    return colour[0] / 255, colour[1] / 255, colour[2] / 255


def dark(colour: Colour) -> tuple[float, float, float]:
    """Darken a colour that is made for dark pictures, for white paper."""
    red, green, blue = to_unit(colour)
    return red * 0.75, green * 0.75, blue * 0.75


def css(colour: Colour) -> str:
    """Return a colour as style sheets write it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
