"""Whether the nodes that a replay sends to have subscribed, and what is logged until they have."""

from __future__ import annotations

import time

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from cable_tracker.errors import RosError
from cable_tracker.node_parameter_tables import ReplayStartParameters
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import subscription
from cable_tracker.ros.health.tracker_health import TrackerHealth
from cable_tracker.ros.nodes.replay_instruments import InstrumentReplay
from cable_tracker.sequences import node_topics

PATIENCE = 3.0
"""Longest time for discovery [s]; only then a missing subscriber is worth a warning."""

WARNING_PAUSE = 5.0
"""Least time between two log messages about what is waited for [s]."""


class ReplaySubscribers:
    """Waits for the subscribers of a replay, and in lockstep for the publisher of `state`.

    Parameters
    ----------
    node : Node
        The replay.
    own : ReplayStartParameters
        Its parameters.
    image : Publisher
        Publishes the frames.
    state : Subscription
        Receives the tracker's answers.
    instruments : InstrumentReplay or None
        Publishes the messages of the instruments.

    Attributes
    ----------
    is_there : bool
        Whether the replay may play: what is waited for has been found, or is not waited for.
    """

    def __init__(
        self,
        node: Node,
        own: ReplayStartParameters,
        image: Publisher,
        state: Subscription,
        instruments: InstrumentReplay | None,
    ) -> None:
        self._node = node
        self._own = own
        self._image = image
        self._state = state
        self._instruments = instruments
        self.is_there = False
        self._waits_since = time.monotonic()
        self._health = TrackerHealth()
        topic = node_topics.DIAGNOSTICS
        subscription(node, topic, self._health.take, qos.RESULTS, name=topic.global_name)

    def warming(self) -> list[str]:
        """Return the full names of the trackers that are warming up."""
        return self._health.warming()

    def check(self) -> bool:
        """Check whether all have subscribed; log what is missing if not, and return `is_there`.

        Raises
        ------
        RosError
            In lockstep something is missing for too long.
        """
        lockstep = self._own.lockstep
        is_heard = self._image.get_subscription_count() > 0
        # A tracker subscribes to instruments before it subscribes to images.
        all_heard = self._instruments is None or not self._instruments.unheard()
        in_step = not lockstep or (all_heard and self._is_answered())
        is_ready = is_heard and in_step and not self.warming()
        self.is_there = is_ready or not (lockstep or self._own.wait_for_tracker)
        if not self.is_there:
            self._log_waiting()
        elif not is_heard:
            self._node.get_logger().warning(
                f"no node subscribes to {self._image.topic_name}: the first frames reach none"
            )
        return self.is_there

    def _log_waiting(self) -> None:
        """Log what is waited for; in lockstep give up in time, unless one is warming up."""
        warming = self.warming()
        if warming:
            # The compiler takes as long as it takes, on a slow computer minutes.
            self._waits_since = time.monotonic()
            self._node.get_logger().info(
                f"waiting: {', '.join(warming)} is WARMING UP, which takes seconds, or once per"
                " installation about half a minute of a laptop's processor",
                throttle_duration_sec=WARNING_PAUSE,
            )
            return
        waited = time.monotonic() - self._waits_since
        if waited < min(PATIENCE, self._own.answer_timeout):
            return
        missing = self._missing_message()
        if self._own.lockstep and waited > self._own.answer_timeout:
            raise RosError(missing)
        self._node.get_logger().warning(
            f"waiting: {missing}"
            + ("" if self._own.lockstep else " (wait_for_tracker:=false plays all the same)"),
            throttle_duration_sec=WARNING_PAUSE,
        )

    def _missing_message(self) -> str:
        """Say which subscriber, or in lockstep which answer, is waited for, and what to do."""
        if not self._image.get_subscription_count():
            return (
                f"no node subscribes to {self._image.topic_name}{self._other_topics_message()}; is"
                " the tracker running, and is its image_transport that of this recording?"
            )
        unheard = self._instruments.unheard() if self._instruments is not None else []
        if unheard:
            topics = ", ".join(each.value for each in unheard)
            choices = " ".join(f"{each.value}_topic:=none" for each in unheard)
            return (
                f"images are subscribed to, but not {topics}; leave out what the tracker does not"
                f" read: {choices}"
            )
        return f"images are subscribed to, but no node publishes {self._state.topic_name}"

    def _other_topics_message(self) -> str:
        """Name the topics on which images are awaited and none come."""
        own = self._image.topic_name
        kinds = {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"}
        awaited = sorted(
            name
            for name, types in self._node.get_topic_names_and_types()
            if kinds.intersection(types)
            and name != own
            and self._node.count_subscribers(name)
            and not self._node.count_publishers(name)
        )
        return f"; images are awaited on {', '.join(awaited)}" if awaited else ""

    def _is_answered(self) -> bool:
        """Tell whether a node that hears the images publishes `state`.

        Anything else may hear them, too, such as a recorder or rviz, before the tracker does. Where
        `state` is remapped, what answers need not be what hears.
        """
        node, name = self._node, node_topics.STATE.name
        answering = node.get_publishers_info_by_topic(self._state.topic_name)
        if node.resolve_topic_name(name) != node.resolve_topic_name(name, only_expand=True):
            return bool(answering)
        hearing = node.get_subscriptions_info_by_topic(self._image.topic_name)
        return bool(set(map(qos.endpoint_name, answering)) & set(map(qos.endpoint_name, hearing)))
