"""Bags that are like another but for something that is wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import deserialise

Change = Callable[[str, Any, int], Iterator[tuple[str, Any, int]]]
"""Takes topic, message and time of receipt [ns]; gives what is written instead."""


def rewritten(bag: Path, path: Path, change: Change) -> Path:
    """Write a bag again, with changed messages; `vehicle.yaml` comes along."""
    storage = open_bag(bag)
    with BagWriter(path) as writer:
        for stored in storage.messages(list(storage.topics)):
            message = deserialise(stored, is_ros1=False)
            for topic, other, time in change(stored.topic, message, stored.time):
                kind = storage.topics[stored.topic].msgtype
                writer.write(topic, kind, other, time)
    (path / "vehicle.yaml").write_text((bag / "vehicle.yaml").read_text())
    return path


def shift(message: Any, seconds: int) -> None:
    """Move the stamp of a message."""
    message.header.stamp.sec += seconds
