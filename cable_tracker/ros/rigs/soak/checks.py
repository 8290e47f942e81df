"""How the numbers in a tracker's messages are looked at: none may be other than finite."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TypeAlias

import numpy as np

from cable_tracker.sequences.messages.cable import read_particles
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.target import read_target_particles

Check: TypeAlias = Callable[[Message], bool]


def _finite(values: Iterable[float]) -> bool:
    return all(math.isfinite(value) for value in values)


def _finite_text(text: str) -> bool:
    """Tell whether no word of a text is a number that is not finite."""
    return not {"nan", "inf", "-inf"} & set(text.lower().split())


def state_is_finite(message: Message) -> bool:
    """Look at the numbers of a `state`."""
    return _finite((*message.position, *message.velocity, *message.effort))


def centreline_is_finite(message: Message) -> bool:
    """Look at the numbers of a `centreline`."""
    pose = message.pose.pose
    place, turn = pose.position, pose.orientation
    numbers = (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)
    return _finite(numbers) and bool(np.isfinite(message.pose.covariance).all())


def cloud_is_finite(message: Message) -> bool:
    """Look at the numbers of `particles`."""
    return bool(np.isfinite(read_particles(message)).all())


def markers_are_finite(message: Message) -> bool:
    """Look at the numbers of `markers`."""
    points = (point for marker in message.markers for point in marker.points)
    return all(_finite((point.x, point.y, point.z)) for point in points)


def report_is_finite(message: Message) -> bool:
    """Look at the values of `/diagnostics` or of a frame's report."""
    return all(_finite_text(pair.value) for status in message.status for pair in status.values)


def picture_is_whole(message: Message) -> bool:
    """See that an overlay holds something."""
    return len(message.data) > 0


def points_are_finite(message: Message) -> bool:
    """Look at the numbers of a target's `particles`."""
    cloud = read_target_particles(message)
    return cloud is None or bool(np.isfinite(cloud).all())


def polygon_is_finite(message: Message) -> bool:
    """Look at the corners of `contour` or `box`."""
    return all(_finite((point.x, point.y, point.z)) for point in message.polygon.points)
