"""The replay node: a recording in, images and ground truth out."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool, Trigger

from cable_tracker.errors import ParameterError, RecordingError, RosError
from cable_tracker.node_parameter_tables import ReplayRuntimeParameters, ReplayStartParameters
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.endpoints import POLL_PERIOD, LastMessages, publisher, subscription
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.nodes.replay_instruments import InstrumentReplay
from cable_tracker.ros.nodes.replay_subscribers import ReplaySubscribers
from cable_tracker.ros.process.process_node import WAKE_UP, ProcessNode
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.instruments import Instrument, InstrumentChoice
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.sequences.messages.cable import make_state
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header, make_time, stamp_of
from cable_tracker.sequences.messages.images import make_compressed_image, make_image
from cable_tracker.sequences.source import open_source
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import parameter_table

LONGEST_PAUSE = 3600.0
"""A clock that goes farther ahead from one frame to the next was set [s of the recording]."""

WORTH_TELLING = 10.0
"""Pauses of the recording that are longer are told of [s]."""

NO_FRAME_THERE = "no frame after that time"

WAY_BACK = "nothing is played until it is less and ~/restart is called"


class ReplayNode(ProcessNode):
    """Feeds a recording into topics, with its own timing or in lockstep with the tracker.

    Parameters
    ----------
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter is not acceptable.
    RecordingError
        The recording cannot be opened.
    """

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__("replay", **node_arguments)
        self._declare_parameters()
        parameters = self._own
        if not parameters.source:
            raise ParameterError(
                "source: name the recording, for instance --ros-args -p source:=/data/dive.mcap"
            )
        # Time between two frames, for what comes after the last [s]; a single frame tells of none.
        self._interval = 1.0 / parameters.frame_rate
        self._source = open_source(
            Path(parameters.source),
            topic=parameters.topic or None,
            rate=parameters.frame_rate,
            truth=Path(parameters.truth) if parameters.truth else None,
            skip_bad_frames=parameters.skip_bad_frames,
            allow_outside=parameters.allow_outside,
        )
        self._source.__enter__()
        if self._source.note:
            self.get_logger().warning(self._source.note)
        self._paused = parameters.paused
        self._steps = 0
        self._sent = 0
        self._started = time.monotonic()
        self._create_publishers()
        self._instruments = self._instrument_replay()
        self._subscribers = ReplaySubscribers(
            self, self._own, self._image, self._state, self._instruments
        )
        self._begin()

    @property
    def sent(self) -> int:
        """Number of frames that are published."""
        return self._sent

    def _declare_parameters(self) -> None:
        self._own = node_parameters.declare_set(self, ReplayStartParameters(), read_only=True)
        self._playing = node_parameters.declare_set(self, ReplayRuntimeParameters())
        node_parameters.watch(self, parameter_table(ReplayRuntimeParameters), self._apply)
        node_parameters.warn_of_unknown_overrides(self)

    def _apply(self, values: Mapping[str, object]) -> None:
        self._playing = self._playing.replaced(values)

    def _instrument_replay(self) -> InstrumentReplay | None:
        if not self._own.instruments:
            return None
        parameters = self._own
        chosen = {each: getattr(parameters, f"{each.value}_topic") for each in Instrument}
        choice = InstrumentChoice({each: topic for each, topic in chosen.items() if topic})
        vehicle = Path(parameters.vehicle) if parameters.vehicle else None
        return InstrumentReplay(
            self, MESSAGES, self._source, choice, vehicle, in_lockstep=parameters.lockstep
        )

    def _create_publishers(self) -> None:
        if self._source.compressed:
            self._image = publisher(self, node_topics.COMPRESSED_IMAGE, qos.PICTURES)
        else:
            self._image = publisher(self, node_topics.IMAGE, qos.PICTURES)
        self._truth = publisher(self, node_topics.GROUND_TRUTH, qos.RESULTS)
        self._clock_publisher = None
        if self._own.publish_clock:
            self._clock_publisher = publisher(
                self, node_topics.CLOCK, qos.RESULTS, name=node_topics.CLOCK.global_name
            )
        self._state = subscription(self, node_topics.STATE, self.on_state, qos.NEWEST_RESULT)
        self.create_service(SetBool, "~/pause", self.on_pause)
        self.create_service(Trigger, "~/step", self.on_step)
        self.create_service(Trigger, "~/restart", self.on_restart)

    def _begin(self) -> None:
        if self._instruments is not None:
            self._instruments.begin()
        # What lies before the start is passed over unread: to seek takes no decoding.
        self._frames: Iterator[Frame] = self._source.chosen_frames(self._is_from_start_on)
        self._first_stamp: int | None = None
        # Kept: a change of the parameter takes effect at the next restart only.
        self._start = _nanoseconds(self._playing.start)
        self._found_start = False
        self._last_stamp: int | None = None
        self._be_due_now()
        self._awaited: int | None = None
        self._awaited_index = 0
        self._answer_deadline = 0.0
        self._damage: RecordingError | None = None
        self._last: LastMessages | None = None
        self._awaits_restart = False
        self._next = self._read_next()

    def _be_due_now(self) -> None:
        """Let the next frame be due at once."""
        self._since, self._pause = time.monotonic(), 0.0

    @property
    def _due(self) -> float:
        """When the next frame is due, on the monotonic clock [s]; a change of `rate` counts."""
        return self._since + self._pause / self._playing.rate

    def _read_next(self) -> Frame | None:
        try:
            return self._next_frame_wanted()
        except RecordingError as error:
            # Told at the end, when the frames before the damage have arrived.
            self._damage = error
            return None

    def _is_from_start_on(self, stamp: int) -> bool:
        """Tell whether the next frame, of a time [ns], is at the start or comes after it."""
        if self._first_stamp is None:
            self._first_stamp = stamp
        # Only looked for once: where the recording's clock jumps back, no frame is left out.
        self._found_start = self._found_start or stamp - self._first_stamp >= self._start
        return self._found_start

    def _next_frame_wanted(self) -> Frame | None:
        frame = next(self._frames, None)
        if frame is None or self._first_stamp is None:
            return None
        duration = _nanoseconds(self._playing.duration)
        elapsed = frame.stamp - self._first_stamp - self._start
        return None if 0 < duration <= elapsed else frame

    def seconds_until_due(self) -> float:
        """Return how long the executor may sleep [s]."""
        waits = self._awaited is not None or self._awaits_restart
        if self._paused or waits or not self._subscribers.is_there:
            return WAKE_UP
        if self._last is not None:
            return POLL_PERIOD
        return 0.0 if self._own.lockstep else self._due - time.monotonic()

    def work(self) -> None:
        """Send the next frame if it is due; end, or begin again, after the last."""
        if self._awaited is not None:
            self._check_answer_deadline()
            return
        if self._next is None:
            if not self._awaits_restart:
                self._end_or_loop()
            return
        if not self._subscribers.is_there:
            self._be_due_now()
            if not self._subscribers.check():
                return
        if self._paused and not self._steps:
            return
        if not self._own.lockstep and not self._steps and time.monotonic() < self._due:
            return
        self._send(self._next)

    def _send(self, frame: Frame) -> None:
        self._steps = max(self._steps - 1, 0)
        if frame.image.missing:
            # A message has no room for the reason: the tracker is sent an image without pixels.
            self.get_logger().warning(
                f"frame {frame.index} cannot be decoded ({frame.image.missing}): an empty image is"
                " sent"
            )
        header = make_header(MESSAGES, frame.stamp, frame.frame_id)
        if self._clock_publisher is not None:
            self._clock_publisher.publish(Clock(clock=make_time(MESSAGES, frame.stamp)))
        if self._source.has_truth:
            self._truth.publish(make_state(MESSAGES, header, frame.truth))
        if isinstance(frame.image, RawImage):
            message = make_image(MESSAGES, frame.image, header)
        else:
            message = make_compressed_image(MESSAGES, frame.image, header)
        if self._instruments is not None:
            self._instruments.send_until(frame)
        if self._own.lockstep:
            self._awaited, self._awaited_index = frame.stamp, frame.index
            self._answer_deadline = time.monotonic() + self._own.answer_timeout
        self._image.publish(message)
        self._sent += 1
        self._last_stamp = frame.stamp
        self._next = self._read_next()
        self._schedule()

    def _schedule(self) -> None:
        if self._next is None or self._last_stamp is None:
            return
        pause = (self._next.stamp - self._last_stamp) / NANOSECONDS
        # A clock that is set, back or far ahead, is passed on, not waited for; and time lost to a
        # slow disk is not made up for by a burst of frames.
        self._since = max(self._due, time.monotonic() - WAKE_UP)
        self._pause = pause if 0.0 <= pause <= LONGEST_PAUSE else 0.0
        if 0.0 < pause <= WORTH_TELLING:
            self._interval = pause
        if pause > WORTH_TELLING:
            self.get_logger().warning(
                f"from frame {self._next.index - 1} to the next the recording's clock goes"
                f" {pause:.0f} s ahead: "
                + ("it is passed on" if pause > LONGEST_PAUSE else "a higher rate waits less")
            )

    def on_state(self, message: Message) -> None:
        """Take note of the tracker's answer (lockstep)."""
        # Stamp 0 means "no time given": the tracker answers with the time at which it came.
        if self._awaited in (0, stamp_of(message.header)):
            self._awaited = None

    def _check_answer_deadline(self) -> None:
        if self._subscribers.warming():
            # A changed parameter may need other code; the frame is answered all the same.
            self._answer_deadline = time.monotonic() + self._own.answer_timeout
        if time.monotonic() < self._answer_deadline:
            return
        raise RosError(
            f"no `state` came for frame {self._awaited_index} within"
            f" {self._own.answer_timeout:g} s; is the tracker running, is its"
            " image_transport that of this recording, and its image_reliability `reliable`?"
        )

    def _end_or_loop(self) -> None:
        if self._playing.loop and self._sent and self._damage is None:
            self._begin_next_round()
            if self._next is not None:
                return
            if self._damage is None:
                self._awaits_restart = True
                self.get_logger().warning(f"start: {NO_FRAME_THERE}; {WAY_BACK}")
                return
        if self._paused and self._sent:
            # The user may look at the last frame, and begin again; without the steps that are left.
            self._steps = 0
            return
        if not self._has_arrived():
            return
        if self._damage is not None:
            raise self._damage
        if not self._sent:
            raise ParameterError(f"start: {NO_FRAME_THERE} in {self._source.path}; give less")
        self.finished = True

    def _begin_next_round(self) -> None:
        """Begin again, the first frame as long after the last as frames follow on each other."""
        due = self._due
        self._begin()
        self._since, self._pause = max(due, time.monotonic() - WAKE_UP), self._interval

    def _has_arrived(self) -> bool:
        if self._last is None:
            # In lockstep the answer has come; the middleware's own acknowledgement takes longer.
            is_answered = self._own.lockstep
            self._last = LastMessages([self._truth] if is_answered else [self._image, self._truth])
        return self._last.have_arrived()

    def report(self) -> str:
        """Return how many frames were sent, in words."""
        seconds = time.monotonic() - self._started
        return f"sent {self._sent} frames of {self._source.path} in {seconds:.1f} s"

    def on_pause(self, request: Message, response: Message) -> Message:
        """Pause (true) or go on (false)."""
        self._paused = bool(request.data)
        self._be_due_now()
        response.success = True
        response.message = "paused" if self._paused else "playing"
        return response

    def on_step(self, request: Message, response: Message) -> Message:
        """Send one frame while paused."""
        if not self._paused or self._next is None:
            response.success = False
            response.message = self._end_message() if self._paused else "not paused"
            return response
        self._steps += 1
        response.success = True
        response.message = f"frame {self._next.index + self._steps - 1}"
        return response

    def _end_message(self) -> str:
        return "at the end" if self._damage is None else str(self._damage)

    def on_restart(self, request: Message, response: Message) -> Message:
        """Go to the time in the parameter `start`, which also makes it the way to seek."""
        self._begin()
        response.success = self._next is not None
        if self._next is not None:
            response.message = f"at frame {self._next.index}"
        else:
            response.message = str(self._damage) if self._damage is not None else NO_FRAME_THERE
            # Not the end of the node: the next restart may name a better time.
            self._awaits_restart = True
        return response

    def destroy_node(self) -> None:
        """Log how many frames were sent, close the recording and destroy the node."""
        self.get_logger().info(self.report())
        if self._instruments is not None:
            for remark in self._instruments.remarks():
                self.get_logger().warning(remark)
            self._instruments.close()
        self._source.__exit__(None, None, None)
        super().destroy_node()


def _nanoseconds(seconds: float) -> int:
    return round(seconds * NANOSECONDS)
