"""A live tracker node, watched and commanded through its topics, parameters and services."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.exceptions import NameValidationException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future
from rclpy.validate_full_topic_name import validate_full_topic_name
from std_srvs.srv import SetBool, Trigger

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.initial_state import GivenState, usual_sigma
from cable_tracker.errors import ParameterError, RosError
from cable_tracker.gui.session.session import AnySnapshot, AnyStart, CableSnapshot, Session
from cable_tracker.gui.subject import CABLE, TARGET, Subject
from cable_tracker.ros import qos
from cable_tracker.ros.clients.live_frames import LiveFrames, LiveTargetFrames
from cable_tracker.ros.clients.live_topics import IMAGE_READERS, LiveConnection, find_topics
from cable_tracker.ros.endpoints import subscription
from cable_tracker.ros.health.tracker_health import TrackerHealth
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.process.environment import check_profile
from cable_tracker.ros.process.ros_context import made_node, started_context
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.cable import make_centreline
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.sequences.messages.target import make_polygon
from cable_tracker.target.model.start import TargetStart
from cable_tracker.tracking.parameter_table import ParameterSpec, ParameterValue
from cable_tracker.tracking.status import DISABLED

ANSWER_TIMEOUT = 30.0
"""Longest time for the answer of a service [s]; a node that is gone is seen on the graph."""

UPDATE_PERIOD = 0.5
"""Interval between two checks that the node is still there [s]."""

STALL = 2.0
"""Time without a picture after which the window shows the words of the diagnostics [s]."""

SILENCE = 3.0
"""Diagnostics older than this are no news; they come once a second [s]."""

UNSEEN_WIDTH = 320
"""Width of the camera's pictures before one has come [px]."""


def _make_window_node(context: Context) -> Node:
    return Node("cable_tracker_window", context=context)


class LiveSession(Session):
    """Watches the node `tracker` in a namespace.

    The node may come later, go, and come again. Its topics are found on the graph, by what the node
    publishes and subscribes to: remapped ones too.

    Parameters
    ----------
    namespace : str
        Namespace of the node; "/" or empty for none.

    Raises
    ------
    RosError
        ROS does not start.
    ResourceError
        The Fast DDS profile that the environment names cannot be read.
    """

    subject: Subject = CABLE
    frames: type[LiveFrames] = LiveFrames

    def __init__(self, namespace: str) -> None:
        super().__init__()
        place = ("/" + namespace.strip("/")).rstrip("/")
        self.name = f"{place}/{self.subject.kind.node}"
        self.table: Sequence[ParameterSpec] = self.subject.session_table(is_live=True)
        self._health = TrackerHealth()
        self._others: list[str] = []
        self._silent_since: float | None = None
        self._frames = self.frames(self._take)
        check_profile()
        _check_namespace(namespace, self.name)
        self._context = started_context()
        try:
            self._node = made_node(_make_window_node, self._context)
        except RosError:
            rclpy.try_shutdown(context=self._context)
            raise
        self._connection = LiveConnection(self._node, self._frames)
        self._parameters = AsyncParameterClient(self._node, self.name)
        self._reset = self._node.create_client(Trigger, f"{self.name}/reset")
        self._enable = self._node.create_client(SetBool, f"{self.name}/enable")
        topic = node_topics.DIAGNOSTICS
        subscription(self._node, topic, self._health.take, qos.RESULTS, name=topic.global_name)
        self._node.create_timer(UPDATE_PERIOD, self._update_connection)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="live session", daemon=True)
        self._thread.start()

    @property
    def trouble(self) -> str:
        """Trouble that keeps frames from coming."""
        topics = self._connection.topics
        if not topics:
            others = f"; there is {', '.join(self._others)}" if self._others else ""
            return f"no node {self.name}{others}; waiting for it"
        if not topics.keys() & IMAGE_READERS.keys():
            return f"{self.name} is there, and waits for no images yet"
        if self._silent_since is not None and time.monotonic() - self._silent_since > STALL:
            is_news = self._health.age(self.name) <= SILENCE
            status = self._health.status(self.name)
            state = f"says {status}" if is_news and status else "says nothing"
            return f"no pictures from {self.name}, which {state}"
        return ""

    @property
    def is_enabled(self) -> bool:
        """Whether the node takes frames, as far as is known."""
        return self._health.status(self.name) != DISABLED

    def parameters(self) -> dict[str, ParameterValue]:
        """Return the values in force on the node.

        Raises
        ------
        RosError
            The node does not answer.
        """
        self._need_node()
        names = [spec.name for spec in self.table]
        response = self._answer(self._parameters.get_parameters(names))
        values = (parameter_value_to_python(value) for value in response.values)
        return {
            name: value for name, value in zip(names, values, strict=False) if value is not None
        }

    def change(self, values: Mapping[str, object]) -> None:
        """Change parameters on the node, all of them or none.

        Raises
        ------
        ParameterError
            The node refuses a value, and says why.
        RosError
            The node does not answer.
        """
        self._need_node()
        specs = {spec.name: spec for spec in self.table}
        unknown = sorted(values.keys() - specs.keys())
        if unknown:
            raise ParameterError(
                f"{', '.join(unknown)}: the node has no such parameter at runtime; give it when"
                " the node starts"
            )
        changed = [
            Parameter(name, value=specs[name].coerce(value)) for name, value in values.items()
        ]
        result = self._answer(self._parameters.set_parameters_atomically(changed)).result
        if not result.successful:
            raise ParameterError(str(result.reason))

    def initialise(self, start: AnyStart) -> None:
        """Publish where the user sees the cable or the target on the node's topic for a start.

        That of a cable says nothing of width and skew; the node searches for them.

        Raises
        ------
        RosError
            The node is gone.
        """
        self._need_node()
        # Another thread, which looks for the node's topics, may replace it.
        publisher = self._connection.start
        if publisher is None:
            raise RosError(f"{self.name} takes no start yet; wait until it has warmed up")
        latest = self._latest
        header = make_header(MESSAGES, latest.row.stamp if latest is not None else 0, "")
        publisher.publish(self._start_message(header, start))

    def _start_message(self, header: Message, start: AnyStart) -> Message:
        assert isinstance(start, GivenState), "a cable is not marked with an outline"
        latest = self._latest
        width = latest.image.shape[1] if isinstance(latest, CableSnapshot) else UNSEEN_WIDTH
        return make_centreline(MESSAGES, header, start.state, _covariance(start, width))

    def reset(self) -> None:
        """Call the service `~/reset`."""
        self._need_node()
        self._answer(self._reset.call_async(Trigger.Request()))

    def enable(self, wanted: bool) -> None:
        """Call the service `~/enable`."""
        self._need_node()
        self._answer(self._enable.call_async(SetBool.Request(data=wanted)))

    def close(self) -> None:
        """End the thread and the node."""
        rclpy.try_shutdown(context=self._context)
        self._thread.join()
        self._node.destroy_node()

    def _spin(self) -> None:
        try:
            while self._context.ok():
                self._spin_once()
        except ExternalShutdownException:
            pass  # `close` has shut the context down.
        finally:
            self._executor.shutdown()

    def _spin_once(self) -> None:
        """Run the next callback; an error with one message must not stop the others."""
        try:
            self._executor.spin_once(timeout_sec=0.1)
        except ExternalShutdownException:
            raise
        except Exception as error:
            if not self._context.ok():
                raise ExternalShutdownException from error
            self._node.get_logger().error(f"not shown: {traceback.format_exc()}")

    def _need_node(self) -> None:
        if not self._connection.topics:
            raise RosError(
                self.trouble or f"no node {self.name}; is it running, and in this ROS domain?"
            )

    def _answer(self, future: Future) -> Any:  # noqa: ANN401
        done = threading.Event()
        future.add_done_callback(lambda _future: done.set())
        if not done.wait(ANSWER_TIMEOUT):
            future.cancel()
            raise RosError(f"{self.name} has not answered for {ANSWER_TIMEOUT:g} s; try again")
        return future.result()

    def _take(self, snapshot: AnySnapshot) -> None:
        self._silent_since = time.monotonic()
        self._publish(snapshot)

    def _update_connection(self) -> None:
        """Find the node's topics on the graph, which may have changed, and listen to them."""
        self._frames.hand_on_due_frame()
        topics = find_topics(self._node, self.name, self._frames.TOPICS)
        self._others = self._other_trackers()
        self._connection.change(topics)
        if not topics:
            self._silent_since = None
        elif self._silent_since is None:
            self._silent_since = time.monotonic()

    def _other_trackers(self) -> list[str]:
        """Return the full names of trackers in other namespaces."""
        found = {
            f"{namespace.rstrip('/')}/{name}"
            for name, namespace in self._node.get_node_names_and_namespaces()
            if name == self.subject.kind.node
        }
        return sorted(found - {self.name})


class LiveTargetSession(LiveSession):
    """Watches the node `target_tracker` in a namespace; of several targets the first."""

    subject = TARGET
    frames = LiveTargetFrames

    def _start_message(self, header: Message, start: AnyStart) -> Message:
        assert isinstance(start, TargetStart), "a target is marked with a box or an outline"
        return make_polygon(MESSAGES, header, start.corners)


def _covariance(prior: GivenState, image_width: int) -> FloatArray:
    """Return the covariance, shape (8, 8), that a prior stands for."""
    sigma = np.where(np.isnan(prior.sigma), usual_sigma(image_width), prior.sigma)
    covariance: FloatArray = np.diag(np.minimum(sigma**2, UNKNOWN_VARIANCE))
    return covariance


def _check_namespace(namespace: str, node: str) -> None:
    """Refuse a namespace in which no node can be.

    Raises
    ------
    RosError
        It is none.
    """
    try:
        validate_full_topic_name(node)
    except NameValidationException as error:
        raise RosError(
            f"{namespace!r} is no namespace of ROS: give letters, digits, _ and / alone, and no"
            " digit after a /"
        ) from error
