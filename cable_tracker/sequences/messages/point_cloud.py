"""Tables of numbers as clouds of points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.messages.factory import Message, MessageFactory

FLOAT32 = 7
"""``PointField.FLOAT32``."""


def make_point_cloud(
    factory: MessageFactory, header: Message, names: Sequence[str], points: FloatArray
) -> Message:
    """Pack points (N, K) as a PointCloud2 of float32 whose K fields have names."""
    packed = points.astype("<f4")
    fields = [
        factory.make(
            "sensor_msgs/msg/PointField",
            name=name,
            offset=4 * column,
            datatype=FLOAT32,
            count=1,
        )
        for column, name in enumerate(names)
    ]
    step = 4 * len(names)
    return factory.make(
        "sensor_msgs/msg/PointCloud2",
        header=header,
        height=1,
        width=len(packed),
        fields=fields,
        is_bigendian=False,
        point_step=step,
        row_step=step * len(packed),
        data=factory.octets(packed.tobytes()),
        is_dense=True,
    )


def read_point_cloud(message: Message, names: Sequence[str]) -> FloatArray:
    """Read points packed by `make_point_cloud` with K fields of these names; shape (N, K)."""
    points = np.frombuffer(memoryview(message.data).cast("B"), dtype="<f4")
    return points.reshape(-1, len(names)).astype(np.float64)
