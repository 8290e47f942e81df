"""Subscriptions to the vehicle's instruments, shared by the tracker nodes.

And whether the instruments have told of the time of a frame.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, Generic

from rclpy.node import Node

from cable_tracker.metric.instrument_fusion import AnyFusion, VehicleParameters
from cable_tracker.node_parameter_tables import RELIABLE
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import subscription
from cable_tracker.ros.node_parameters import with_those_in
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.instruments import TOPICS, Instrument
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.node_topics import NodeTopic


class InstrumentsSent:
    """Whether all messages of the instruments have come that a replay has sent before a frame.

    Keeps the newest message of the topic `instruments_sent`, and what was heard. Messages are
    counted as their sender counts them: then it does not matter when the node began to listen.

    Parameters
    ----------
    topics : collection of NodeTopic
        Instruments that the node listens to; what a replay says of others does not count.
    """

    def __init__(self, topics: Collection[NodeTopic]) -> None:
        self._names = frozenset(topic.name for topic in topics)
        self._stamp: int | None = None
        self._counts: dict[str, float] = {}
        self._heard: dict[str, int] = {}

    def hear(self, name: str, number: int | None) -> None:
        """Take note of a message of a topic, the sender's `number`th, or one more if None."""
        self._heard[name] = self._heard.get(name, 0) + 1 if number is None else number

    def has_heard(self, name: str) -> bool:
        """Tell whether a message of a topic has come."""
        return name in self._heard

    def take(self, message: Message) -> None:
        """Take how much a replay has sent before a frame."""
        self._stamp = stamp_of(message.header)
        told = zip(message.name, message.position, strict=False)
        counts = {name: count for name, count in told if name in self._names}
        if any(count < self._counts.get(name, 0) for name, count in counts.items()):
            # Another replay, which counts from its own start: what was heard is of the one before.
            for name, count in counts.items():
                if self._heard.get(name, 0) > count:
                    self._heard[name] = 0
        self._counts = counts

    def tells_of(self, stamp: int) -> bool:
        """Tell whether the newest message is about the frame of a time [ns]."""
        return self._stamp == stamp

    def has_come(self) -> bool:
        """Tell whether all of it has come."""
        return all(self._heard.get(name, 0) >= count for name, count in self._counts.items())


class InstrumentInputs(Generic[AnyFusion, VehicleParameters]):
    """Listens to the instruments, and knows whether they have told of the time of a frame.

    Parameters
    ----------
    node : Node
        The tracker's node.
    parameters : CableVehicleParameters or TargetVehicleParameters
        Parameters of the fusion, as the node has them at its start.
    make_fusion : callable
        Makes the fusion, given its parameters.
    instruments : collection of Instrument
        Instruments to subscribe to: the calibration, and those with stamped measurements.
    required : collection of Instrument
        Stamped instruments that a frame waits for even before their first message.

    Attributes
    ----------
    fusion : InstrumentFusion
        Fusion of the messages so far, with the parameters in force.
    """

    def __init__(
        self,
        node: Node,
        parameters: VehicleParameters,
        make_fusion: Callable[[VehicleParameters], AnyFusion],
        instruments: Collection[Instrument],
        required: Collection[Instrument] = (),
    ) -> None:
        self._node = node
        self.fusion = make_fusion(parameters)
        self._instruments = tuple(instruments)
        self._required = frozenset(required)
        self._newest: dict[Instrument, int] = {}
        self._on_news: Callable[[], None] | None = None
        self._has_asked = False
        self._sent = InstrumentsSent([TOPICS[each] for each in self._instruments])

    def subscribe(self, reliability: str, on_news: Callable[[], None]) -> None:
        """Listen, `best_effort` or `reliable`; `on_news` is called after each message."""
        self._on_news = on_news
        profile = qos.instrument_input(reliability)
        for instrument in self._instruments:
            subscription(self._node, TOPICS[instrument], self._taking(instrument), profile)
        if reliability == RELIABLE:
            subscription(self._node, node_topics.INSTRUMENTS_SENT, self._take_counts, profile)

    def _take_counts(self, message: Message) -> None:
        """Take how much a replay has sent before a frame."""
        self._sent.take(message)
        assert self._on_news is not None
        self._on_news()

    def ask_for_calibration(self) -> None:
        """Ask for a calibration that was sent once and is kept for those that come later.

        Such a publisher keeps it for subscriptions alone that ask to be told; those cannot hear
        others, so that it takes one of its own.
        """
        topic = TOPICS[Instrument.CAMERA_INFO]
        if self._on_news is None or self._sent.has_heard(topic.name) or self._has_asked:
            return
        publishers = self._node.get_publishers_info_by_topic(
            self._node.resolve_topic_name(topic.name)
        )
        if any(qos.keeps_for_later(each.qos_profile) for each in publishers):
            self._has_asked = True
            subscription(self._node, topic, self._taking(Instrument.CAMERA_INFO), qos.LATCHED)

    def _taking(self, instrument: Instrument) -> Callable[[Message, Mapping[str, Any]], None]:
        on_news = self._on_news
        assert on_news is not None

        def taken(message: Message, info: Mapping[str, Any]) -> None:
            self.take_message(instrument, message, info.get("publication_sequence_number"))
            on_news()

        return taken

    def take_message(
        self, instrument: Instrument, message: Message, number: int | None = None
    ) -> None:
        """Take a message of an instrument, which is the sender's `number`th, if that is known."""
        stamp = stamp_of(message.header) or int(self._node.get_clock().now().nanoseconds)
        self._sent.hear(instrument.value, number)
        if instrument is not Instrument.CAMERA_INFO:
            self._newest[instrument] = stamp
        self.fusion.take_message(instrument, stamp, message)

    def has_all_of(self, stamp: int) -> bool:
        """Tell whether the calibration is known, and the measurements of a time [ns].

        Each of those required, and of those that have spoken before, must have spoken of that time
        or later: who comes first must not decide whose measurement is taken. Where a replay says
        how much it has sent before the frame of that time, all of it must have come.
        """
        if self._sent.tells_of(stamp):
            return self._sent.has_come()
        awaited = self._required | self._newest.keys()
        return (
            self._sent.has_heard(Instrument.CAMERA_INFO.value)
            and bool(awaited)
            and all(self._newest.get(each, -1) >= stamp for each in awaited)
        )

    def apply(self, values: Mapping[str, object]) -> None:
        """Take those of the fusion's parameters that are given, by name."""
        changed = with_those_in(self.fusion.parameters, values)
        if changed != self.fusion.parameters:
            self.fusion.configure(changed)
