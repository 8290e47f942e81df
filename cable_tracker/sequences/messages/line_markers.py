"""Lines in an image as markers for rviz, 0.01 m to the pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.sequences.messages.poses import make_pose_at_origin

METRES_PER_PIXEL = 0.01
"""Scale of the markers, so that an image is a few metres wide in rviz."""

LINE_WIDTH = 2 * METRES_PER_PIXEL

LIFETIME = 2
"""Lines are drawn for so long if none come after them [s]: a tracker may be switched off or die."""

LINE_LIST, ADD, DELETE_ALL = 5, 0, 3
"""``Marker.LINE_LIST``, ``Marker.ADD`` and ``Marker.DELETEALL``."""

Colour = tuple[float, float, float]
"""Red, green and blue, each 0 to 1."""

GREY: Colour = (0.5, 0.5, 0.5)
GREEN: Colour = (0.0, 0.75, 0.375)
AMBER: Colour = (1.0, 0.75, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Straight lines of one kind.

    Attributes
    ----------
    name : str
        Namespace of their marker.
    ends : FloatArray
        Ends of K lines, one line after the other, in the image frame: origin at the image centre,
        x right, y up [px]; shape (2K, 2).
    colour : Colour
        In which they are drawn.
    """

    name: str
    ends: FloatArray
    colour: Colour


def make_line_markers(factory: MessageFactory, header: Message, drawn: Sequence[Lines]) -> Message:
    """Pack lines as a MarkerArray that first deletes those of before."""
    clear = factory.make(
        "visualization_msgs/msg/Marker",
        header=header,
        action=DELETE_ALL,
        pose=make_pose_at_origin(factory),
    )
    markers = [_line_marker(factory, header, number, lines) for number, lines in enumerate(drawn)]
    return factory.make("visualization_msgs/msg/MarkerArray", markers=[clear, *markers])


def sides_of_polygon(corners: FloatArray) -> FloatArray:
    """Return the ends of the sides of a polygon (K, 2), one side after the other, (2K, 2)."""
    return np.stack((corners, np.roll(corners, -1, axis=0)), axis=1).reshape(-1, 2)


def _line_marker(factory: MessageFactory, header: Message, number: int, lines: Lines) -> Message:
    red, green, blue = lines.colour
    return factory.make(
        "visualization_msgs/msg/Marker",
        header=header,
        ns=lines.name,
        id=number,
        type=LINE_LIST,
        action=ADD,
        pose=make_pose_at_origin(factory),
        scale=factory.make("geometry_msgs/msg/Vector3", x=LINE_WIDTH, y=0.0, z=0.0),
        color=factory.make("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0),
        lifetime=factory.make("builtin_interfaces/msg/Duration", sec=LIFETIME, nanosec=0),
        points=[_point(factory, float(x), float(y)) for x, y in lines.ends],
    )


def _point(factory: MessageFactory, x: float, y: float) -> Message:
    return factory.make(
        "geometry_msgs/msg/Point", x=x * METRES_PER_PIXEL, y=y * METRES_PER_PIXEL, z=0.0
    )
