"""Instruments that a bag holds besides pictures: calibration, altitude, attitude, odometry, fixes.

Topics are found by their types. Where several have the right one, the user chooses; without a
choice nothing is guessed, and a note says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from cable_tracker.errors import RecordingError
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_storage import Topic, image_topics, named_topics
from cable_tracker.sequences.node_topics import NodeTopic

MOST_ALTITUDE = 200.0
"""No larger altitude is one of a vehicle that sees the bottom [m]."""

NO_TOPIC = "none"
"""A choice that leaves an instrument out."""

TRUTH_NAMESPACE = node_topics.GROUND_TRUTH.name
"""Topics inside say how it was, not what an instrument said."""


class Instrument(str, Enum):
    """Instrument whose messages can be read besides pictures."""

    CAMERA_INFO = node_topics.CAMERA_INFO.name
    ALTITUDE = node_topics.ALTITUDE.name
    IMU = node_topics.IMU.name
    ODOMETRY = node_topics.ODOMETRY.name
    FIX = node_topics.FIX.name


TOPICS: Mapping[Instrument, NodeTopic] = {
    Instrument(topic.name): topic
    for topic in (
        node_topics.CAMERA_INFO,
        node_topics.ALTITUDE,
        node_topics.IMU,
        node_topics.ODOMETRY,
        node_topics.FIX,
    )
}
"""Topic of each instrument at our nodes; one of its type is taken from a bag without being asked
for."""

NUMBER_TYPES = ("std_msgs/msg/Float32", "std_msgs/msg/Float64")
"""An altitude may be one of these as well, where its topic is named: a number says not of what."""


@dataclass(frozen=True, slots=True)
class InstrumentChoice:
    """Which topics to read, by instrument; `NO_TOPIC` leaves one out.

    Attributes
    ----------
    topics : mapping of Instrument to str
        Topic of each instrument; absent instruments are found by their message type.
    """

    topics: Mapping[Instrument, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class FoundInstruments:
    """The topics that are read, and what the user should know about the others.

    Attributes
    ----------
    topics : dict of Instrument to str
        Topic of each instrument in the bag.
    notes : tuple of str
        One sentence for each instrument that could not be chosen.
    """

    topics: dict[Instrument, str]
    notes: tuple[str, ...]


def refuse_named_topics(path: Path, choice: InstrumentChoice | None) -> None:
    """Refuse topics of instruments for a recording that is no bag.

    Raises
    ------
    RecordingError
        The user has named one.
    """
    named = {} if choice is None else choice.topics
    options = [_options(each) for each, topic in named.items() if topic != NO_TOPIC]
    if options:
        raise RecordingError(
            f"{path}: is no bag and has no topics; leave out {' and '.join(options)}"
        )


def _options(instrument: Instrument) -> str:
    """Return the command line option and the node parameter that name a topic."""
    name = instrument.value
    return f"--{name.replace('_', '-')}-topic (node: {name}_topic)"


def find_instruments(
    topics: Mapping[str, Topic], image_topic: str, choice: InstrumentChoice
) -> FoundInstruments:
    """Find the topics of all instruments among those of a bag.

    Of several calibrations that beside the images counts. A single one may lie anywhere but beside
    the images of another camera.

    Raises
    ------
    RecordingError
        A topic that the user named is not there, or of no type that can be read.
    """
    found: dict[Instrument, str] = {}
    notes = []
    for instrument in Instrument:
        wanted = choice.topics.get(instrument)
        if wanted == NO_TOPIC:
            continue
        if wanted is not None:
            found[instrument] = _named(topics, instrument, wanted)
            continue
        candidates = _candidates(topics, instrument)
        is_of_other = False
        if instrument is Instrument.CAMERA_INFO:
            beside = _beside(candidates, image_topic)
            is_of_other = not beside and any(
                _beside(candidates, other) for other in _recorded_images(topics)
            )
            candidates = beside or candidates
        if len(candidates) == 1 and not is_of_other:
            found[instrument] = candidates[0]
        elif candidates:
            notes.append(_unchosen(instrument, candidates))
    return FoundInstruments(found, tuple(notes))


def _unchosen(instrument: Instrument, candidates: list[str]) -> str:
    """Say why no topic is read for an instrument, and how to choose one."""
    name = instrument.value
    options = _options(instrument)
    if len(candidates) > 1:
        listed = ", ".join(candidates)
        return (
            f"several topics for {name}, none of them is read; choose one with {options}: {listed}"
        )
    return (
        f"{candidates[0]} is not read: it stands beside the images of another camera; if it is that"
        f" of these images, choose it with {options}"
    )


def _recorded_images(topics: Mapping[str, Topic]) -> list[str]:
    return [name for name, topic in image_topics(topics).items() if topic.count]


def _candidates(topics: Mapping[str, Topic], instrument: Instrument) -> list[str]:
    return sorted(
        name
        for name, topic in topics.items()
        if topic.msgtype == TOPICS[instrument].type_name
        and topic.count
        and TRUTH_NAMESPACE not in name.split("/")
    )


def _beside(candidates: list[str], image_topic: str) -> list[str]:
    """Return the calibrations in the namespace of the images, or one level above it."""
    place = image_topic.strip("/").split("/")[:-1]
    for depth in (len(place), len(place) - 1):
        if depth < 0:
            break
        near = [name for name in candidates if name.strip("/").split("/")[:-1] == place[:depth]]
        if near:
            return near
    return []


def _named(topics: Mapping[str, Topic], instrument: Instrument, wanted: str) -> str:
    matching = named_topics(topics, wanted)
    if not matching:
        known = ", ".join(sorted(topics))
        raise RecordingError(
            f"there is no topic {wanted} for {instrument.value}; choose one of {known}"
        )
    name = matching[0]
    types: tuple[str, ...] = (TOPICS[instrument].type_name,)
    if instrument is Instrument.ALTITUDE:
        types = (*types, *NUMBER_TYPES)
    if topics[name].msgtype not in types:
        raise RecordingError(
            f"the topic {wanted} for {instrument.value} is of type {topics[name].msgtype};"
            f" name one of type {' or '.join(types)}"
        )
    return name
