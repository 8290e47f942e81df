"""Named scalars with their rates and standard deviations."""

from __future__ import annotations

from collections.abc import Sequence

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.messages.factory import Message, MessageFactory


def make_joint_state(
    factory: MessageFactory,
    header: Message,
    *,
    names: Sequence[str],
    values: FloatArray,
    rates: FloatArray,
    sigma: Sequence[float] | FloatArray,
) -> Message:
    """Pack named scalars as a sensor_msgs/JointState.

    Parameters
    ----------
    names : sequence of str
        Names of the K scalars.
    values : FloatArray
        Shape (K,), or (0,) if they are not known; so are the others.
    rates : FloatArray
        Their rates [per second], shape (K,).
    sigma : sequence of float
        One standard deviation of each; empty if there is none.
    """
    return factory.make(
        "sensor_msgs/msg/JointState",
        header=header,
        name=list(names),
        position=factory.doubles(values),
        velocity=factory.doubles(rates),
        effort=factory.doubles(sigma),
    )
