"""Static transforms between the vehicle's frames, from `/tf_static`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.poses import unit_quaternion

TF_STATIC = "/tf_static"

TF_TYPE = "tf2_msgs/msg/TFMessage"


@dataclass(frozen=True, slots=True, eq=False)
class StaticTransform:
    """Transform from a frame to its parent.

    Attributes
    ----------
    parent, child : str
        Names without a leading slash.
    rotation : FloatArray
        From the child to the parent, shape (3, 3).
    translation : FloatArray
        Position of the child's origin in the parent, shape (3,) [m].
    """

    parent: str
    child: str
    rotation: FloatArray
    translation: FloatArray


def read_transform(message: Message) -> StaticTransform | None:
    """Read a TransformStamped; None if it is no rotation, or not finite."""
    q, t = message.transform.rotation, message.transform.translation
    quaternion = unit_quaternion(q)
    origin = np.array([float(t.x), float(t.y), float(t.z)])
    if quaternion is None or not np.isfinite(origin).all():
        return None
    x, y, z, w = quaternion
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    parent = str(message.header.frame_id).strip("/")
    return StaticTransform(parent, str(message.child_frame_id).strip("/"), rotation, origin)


def pose_in(
    transforms: tuple[StaticTransform, ...], frame: str, base: str
) -> tuple[FloatArray, FloatArray] | None:
    """Return rotation (3, 3) and origin (3,) [m] of a frame in another; None: not connected.

    Transforms are followed from the frame up to the base, and from the base up where it hangs
    below.
    """
    up = _chain(transforms, frame.strip("/"))
    down = _chain(transforms, base.strip("/"))
    for name, (rotation, origin) in up.items():
        if name in down:
            base_rotation, base_origin = down[name]
            return base_rotation.T @ rotation, base_rotation.T @ (origin - base_origin)
    return None


def _chain(
    transforms: tuple[StaticTransform, ...], frame: str
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return rotation and origin of a frame in itself and in each of its ancestors."""
    by_child = {each.child: each for each in transforms}
    rotation, origin = np.eye(3), np.zeros(3)
    chain = {frame: (rotation, origin)}
    while frame in by_child:
        step = by_child[frame]
        frame = step.parent
        if frame in chain:
            break
        rotation, origin = step.rotation @ rotation, step.rotation @ origin + step.translation
        chain[frame] = (rotation, origin)
    return chain
