"""The tracker node: an image in, `centreline` and `state` out."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header
from std_srvs.srv import SetBool, Trigger

from cable_tracker.cable.measure.response_table import load_table
from cable_tracker.cable.model.estimate import CableEstimate, TrackingStatus
from cable_tracker.cable.model.initial_state_text import parse_initial_state
from cable_tracker.cable.model.initialisation import StatePrior
from cable_tracker.cable.parameters.parameters import (
    PARAMETER_TABLE,
    PARAMETERS_BY_NAME,
    TrackerParameters,
)
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import FrameError
from cable_tracker.node_parameter_tables import (
    TRACKER_RUNTIME_PARAMETERS,
    TRACKER_START_PARAMETERS,
)
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.arrivals import GapCounter, moment_of_arrival
from cable_tracker.ros.diagnostics import (
    DISABLED,
    FROZEN_INPUT,
    STALE_INPUT,
    WARMING_UP,
    FrameStatistics,
    diagnostic_values,
    make_diagnostics,
)
from cable_tracker.ros.frame_tracker import FrameTracker
from cable_tracker.ros.frozen_input import FrozenInput
from cable_tracker.ros.metric_inputs import MetricInputs
from cable_tracker.ros.picture_remarks import remark_on
from cable_tracker.ros.process import ProcessNode
from cable_tracker.ros.qos_mismatch import input_mismatches, output_mismatches
from cable_tracker.ros.rclpy_messages import RclpyMessages
from cable_tracker.ros.tracker_outputs import TrackerOutputs
from cable_tracker.ros.warm_up import WarmUp
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.estimates import REFUSED
from cable_tracker.sequences.frame import CompressedImage as CompressedPicture
from cable_tracker.sequences.frame import RawImage
from cable_tracker.sequences.messages import (
    Message,
    make_header,
    read_compressed_image,
    read_image,
    read_prior,
)
from cable_tracker.sequences.serialised_images import (
    MessageHeader,
    read_serialised_compressed_image,
    read_serialised_image,
)
from cable_tracker.trackers import make_proposer, make_tracker

AnyImage: TypeAlias = RawImage | CompressedPicture

SLOWEST_WATCH, FASTEST_WATCH = 0.25, 0.025
"""Limits of the time between two looks at the clock [s]; it is half the shortest time-out."""

NO_TIME = (
    "the frame has no stamp, and there is no time to give it: use_sim_time is set and nothing has"
    " come on /clock"
)


@dataclass(frozen=True, slots=True, eq=False)
class _HeldFrame:
    """A frame that has come in, at a time of the performance counter [s]."""

    given: MessageHeader
    read: Callable[[], AnyImage]
    arrival: float


class TrackerNode(ProcessNode):
    """Wraps a `CableTracker`.

    Parameters
    ----------
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter given at start is not acceptable.
    """

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__("tracker", **node_arguments)
        self._factory = RclpyMessages()
        self._statistics = FrameStatistics()
        self._metric = MetricInputs(self, self._factory)
        self._watchdog: Any = None
        self._declare_parameters()
        self._enabled = True
        self._stale = False
        self._status = TrackingStatus.INITIALISING.value
        self._estimate: CableEstimate | None = None
        self._frame_id = ""
        self._held: _HeldFrame | None = None
        self._prior_while_disabled: StatePrior | None = None
        self._frozen = FrozenInput()
        self._is_frozen = False
        self._gaps = GapCounter()
        self._input: Any = None
        self._prior_input: Any = None
        self._look_for_mismatches = False
        self._mismatches: list[str] = []
        self._last_usable = time.monotonic()
        self._next_diagnostics = 0.0
        self._restart()
        self._outputs = TrackerOutputs(self, self._on_mismatch)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", qos.RESULTS)
        self._create_services()
        self._warm_up: WarmUp | None = WarmUp(self._tracker.parameters)
        if self._warm_up.running:
            self.get_logger().info("warming up: compiling or loading what a frame needs")
            self.publish_diagnostics()
        else:
            self._end_warm_up()

    @property
    def status(self) -> str:
        """What diagnostics say now."""
        if not self._enabled:
            return DISABLED
        if self._warm_up is not None:
            return WARMING_UP
        if self._stale:
            return STALE_INPUT
        return FROZEN_INPUT if self._is_frozen else self._status

    @property
    def statistics(self) -> FrameStatistics:
        """Counts and times of the frames that came in."""
        return self._statistics

    @property
    def tracker(self) -> FrameTracker:
        """The tracker inside."""
        return self._tracker

    def wait_until_warm(self) -> None:
        """Wait for the end of the warm-up; for who feeds frames by hand, without an executor."""
        if self._warm_up is not None:
            self._end_warm_up()

    def _declare_parameters(self) -> None:
        start = node_parameters.declare_all(self, TRACKER_START_PARAMETERS, read_only=True)
        values = preset(str(start["preset"]))
        given = {
            spec.name: node_parameters.declare(self, spec, values.as_mapping()[spec.name])
            for spec in PARAMETER_TABLE
        }
        runtime = node_parameters.declare_all(self, TRACKER_RUNTIME_PARAMETERS)
        self._compressed_input = start["image_transport"] == "compressed"
        self._reliability = str(start["image_reliability"])
        self._instrument_reliability = str(start["instrument_reliability"])
        self._tracker = self._make_tracker(values.replaced(given))
        self._apply_runtime_values(runtime)
        specs = {spec.name: spec for spec in TRACKER_RUNTIME_PARAMETERS} | dict(PARAMETERS_BY_NAME)
        node_parameters.watch(self, specs, self._validate_parameters, self._apply_parameters)
        node_parameters.warn_of_unknown_overrides(self)

    def _make_tracker(self, parameters: TrackerParameters) -> FrameTracker:
        """Make what tracks; a node that compares methods puts another one here."""
        return make_tracker(parameters)

    def _validate_parameters(self, values: Mapping[str, object]) -> None:
        own = {spec.name: spec for spec in TRACKER_RUNTIME_PARAMETERS}
        for name in values.keys() & own.keys():
            own[name].coerce(values[name])
        if "initial_state" in values:
            parse_initial_state(str(values["initial_state"]))
        present = self._tracker.parameters
        changed = present.replaced({name: values[name] for name in values.keys() - own.keys()})
        if changed.response_table != present.response_table:
            load_table(changed.response_table)

    def _apply_parameters(self, values: Mapping[str, object]) -> None:
        filter_values = {name: values[name] for name in values.keys() & PARAMETERS_BY_NAME.keys()}
        if filter_values:
            changed = self._tracker.parameters.replaced(filter_values)
            self._tracker.configure(changed, make_proposer(changed))
            self._warm_up_for_change()
        self._apply_runtime_values(values)

    def _apply_runtime_values(self, values: Mapping[str, object]) -> None:
        if "initial_state" in values:
            self._initial_state = parse_initial_state(str(values["initial_state"]))
        if "input_timeout" in values:
            self._input_timeout = float(cast(float, values["input_timeout"]))
        if "diagnostics_period" in values:
            self._diagnostics_period = float(cast(float, values["diagnostics_period"]))
        if "frozen_timeout" in values:
            self._frozen_timeout = float(cast(float, values["frozen_timeout"]))
        self._metric.apply(values)
        self._watch_as_often_as_needed()

    def _watch_as_often_as_needed(self) -> None:
        if self._watchdog is not None:
            self._watchdog.timer_period_ns = round(self._watchdog_period() * 1e9)

    def _watchdog_period(self) -> float:
        shortest = min(self._input_timeout, self._diagnostics_period)
        if self._metric.wait:
            shortest = min(shortest, self._metric.wait)
        return min(max(shortest / 2, FASTEST_WATCH), SLOWEST_WATCH)

    def _create_services(self) -> None:
        self.create_service(Trigger, "~/reset", self.on_reset)
        self.create_service(SetBool, "~/enable", self.on_enable)
        # Simulated time may stand still while frames stay away: the watchdog needs a clock that
        # does not.
        self._watchdog = self.create_timer(
            self._watchdog_period(),
            self.on_watchdog,
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )

    def _create_inputs(self) -> None:
        self._metric.subscribe(self._instrument_reliability, self._track_held)
        self._image_qos = qos.image_input(self._reliability)
        kind, topic, callback = (
            (CompressedImage, "image/compressed", self.on_serialised_compressed_image)
            if self._compressed_input
            else (Image, "image", self.on_serialised_image)
        )
        events = SubscriptionEventCallbacks(
            message_lost=self._on_frames_lost,
            incompatible_qos=self._on_mismatch,
            use_default_callbacks=False,
        )
        # As bytes: a message object would cost two more copies of the pixels.
        self._input = self.create_subscription(
            kind, topic, callback, self._image_qos, event_callbacks=events, raw=True
        )
        self._prior_input = self.create_subscription(
            PoseWithCovarianceStamped,
            "initial_state",
            self.on_initial_state,
            qos.RESULTS,
            event_callbacks=SubscriptionEventCallbacks(
                incompatible_qos=self._on_mismatch, use_default_callbacks=False
            ),
        )

        self.get_logger().info(f"waiting for images on {self._input.topic_name}")

    def _warm_up_for_change(self) -> None:
        """Stop tracking until another variant is compiled, and say so: a stall says nothing."""
        if self._input is None:
            return
        warm_up = WarmUp(self._tracker.parameters)
        if warm_up.running:
            self._warm_up = warm_up
            self.get_logger().warning("warming up: the change needs other code; no frame is used")
            self.publish_diagnostics()

    def _end_warm_up(self) -> None:
        assert self._warm_up is not None
        self._warm_up.finish()
        if self._warm_up.seconds > 0.1:
            self.get_logger().info(f"warmed up in {self._warm_up.seconds:.1f} s")
        self._warm_up = None
        # A camera that never sends is no better than one that has stopped.
        self._last_usable = time.monotonic()
        if self._input is None:
            self._create_inputs()
        self.publish_diagnostics()

    def on_serialised_image(self, message: bytes, info: Mapping[str, Any]) -> None:
        """Track on an uncompressed image, given as the bytes that came."""
        self._take_serialised(message, info, read_serialised_image)

    def on_serialised_compressed_image(self, message: bytes, info: Mapping[str, Any]) -> None:
        """Track on a JPEG or PNG, given as the bytes that came."""
        self._take_serialised(message, info, read_serialised_compressed_image)

    def _take_serialised(
        self,
        message: bytes,
        info: Mapping[str, Any],
        read: Callable[[bytes], tuple[MessageHeader, AnyImage]],
    ) -> None:
        arrival = moment_of_arrival(info)
        self._statistics.dropped += self._gaps.missing(info, self._count_cameras)
        try:
            header, image = read(message)
        except FrameError as error:
            self._note_refusal(str(error))
            return
        self._take(header, lambda: image, arrival)

    def _count_cameras(self) -> int:
        return int(self.count_publishers(self._input.topic_name))

    def on_image(self, message: Message) -> None:
        """Track on an uncompressed image, given as a message object."""
        self._take(_header_of(message), lambda: read_image(message), time.perf_counter())

    def on_compressed_image(self, message: Message) -> None:
        """Track on a JPEG or PNG, given as a message object."""
        self._take(_header_of(message), lambda: read_compressed_image(message), time.perf_counter())

    def _take(self, given: MessageHeader, read: Callable[[], AnyImage], arrival: float) -> None:
        """Answer one frame, at once or as soon as the instruments of its time have spoken.

        Parameters
        ----------
        given : MessageHeader
            Stamp and frame_id as the camera gave them.
        read : callable
            Returns the image.
        arrival : float
            When it came, on the clock of `time.perf_counter` [s].
        """
        self._statistics.arrived(time.monotonic())
        held = _HeldFrame(given, read, arrival)
        if not (self._enabled and self._metric.wait and given.stamp):
            self._track(held)
            return
        # The order of the frames counts for more than what the instruments may still say.
        self._track_held(at_once=True)
        self._held = held
        self._track_held()

    def _track_held(self, *, at_once: bool = False) -> None:
        """Track on the frame that is held back, if the instruments have spoken or it is time."""
        held = self._held
        if held is None:
            return
        waited = time.perf_counter() - held.arrival
        is_due = at_once or waited >= self._metric.wait
        if is_due or self._metric.has_all_of(held.given.stamp):
            self._held = None
            self._track(held)

    def _track(self, held: _HeldFrame) -> None:
        given, read, arrival = held.given, held.read, held.arrival
        self._frame_id = given.frame_id
        stamp = given.stamp or int(self.get_clock().now().nanoseconds)
        header = self._header_for_answer(given, stamp)
        if not self._enabled or self._warm_up_gates_frames():
            self._statistics.ignored += 1
            self._note_usable()
            self._outputs.answer_without_estimate(header, self.status, "")
            return
        try:
            if not stamp:
                raise FrameError(NO_TIME)
            self._use(header, stamp, read(), arrival)
        except FrameError as error:
            self._refuse(header, str(error))

    def _header_for_answer(self, given: MessageHeader, stamp: int) -> Message:
        if not given.stamp:
            return make_header(self._factory, stamp, given.frame_id)
        # To the letter, so that whoever sent the frame knows it again.
        time_sent = Time(sec=given.sec, nanosec=given.nanosec)
        return Header(stamp=time_sent, frame_id=given.frame_id)

    def _warm_up_gates_frames(self) -> bool:
        return self._warm_up is not None and self._input is not None

    def _use(self, header: Message, stamp: int, image: AnyImage, arrival: float) -> None:
        grey = decode_grey(image)
        if self._has_frozen(grey, stamp):
            self._answer_frozen(header)
            return
        begin = time.perf_counter()
        estimate = self._tracker.process(grey, stamp, self._metric.motion(stamp, grey))
        milliseconds = (time.perf_counter() - begin) * 1e3
        self._outputs.publish_centreline(header, estimate)
        self._metric.publish(header, estimate)
        self._statistics.latency.add((time.perf_counter() - arrival) * 1e3)
        self._statistics.tracked += 1
        self._estimate = estimate
        self._outputs.publish_pictures(header, estimate, self._tracker.particles, grey)
        self._outputs.publish_state(header, estimate, milliseconds)
        self._is_frozen = False
        self._note_usable()
        self._note_event(estimate.event)
        self._change_status(estimate.status.value)

    def _has_frozen(self, grey: Any, stamp: int) -> bool:  # noqa: ANN401
        seconds = self._frozen.take(grey, stamp)
        return 0.0 < self._frozen_timeout <= seconds

    def _answer_frozen(self, header: Message) -> None:
        """Claim nothing: what stood still is no measurement, however well the cable shows on it."""
        self._statistics.frozen += 1
        self._note_usable()
        self._outputs.answer_without_estimate(header, FROZEN_INPUT, "the picture stands still")
        if not self._is_frozen:
            self._is_frozen = True
            self.get_logger().error(
                f"the camera has sent the same picture for {self._frozen.seconds:.1f} s;"
                " tracking goes on when it changes (parameter frozen_timeout)"
            )
            self.publish_diagnostics()

    def _note_usable(self) -> None:
        self._last_usable = time.monotonic()
        if self._stale:
            self._stale = False
            self.publish_diagnostics()

    def _note_event(self, event: str) -> None:
        if event:
            self._statistics.last_event = event
            self.get_logger().warning(f"tracking starts anew: {event}")

    def _note_refusal(self, reason: str) -> None:
        self._statistics.refused += 1
        self._statistics.last_bad_frame = reason
        self.get_logger().warning(f"frame refused: {reason}", throttle_duration_sec=1.0)

    def _refuse(self, header: Message, reason: str) -> None:
        self._note_refusal(reason)
        self._outputs.answer_without_estimate(header, REFUSED, reason)

    def on_initial_state(self, message: Message) -> None:
        """Start the next frame from an operator's or planner's prior."""
        try:
            self._check_frame_id(str(message.header.frame_id))
            prior = read_prior(message)
            self._tracker.initialise(prior)
        except FrameError as error:
            self.get_logger().warning(f"initial_state refused: {error}")
            return
        if not self._enabled:
            self._prior_while_disabled = prior

    def _check_frame_id(self, frame_id: str) -> None:
        if frame_id and self._frame_id and frame_id != self._frame_id:
            raise FrameError(f"it is in {frame_id!r}, not in the image frame {self._frame_id!r}")

    def on_reset(self, request: Message, response: Message) -> Message:
        """Forget everything and start as at the beginning."""
        self._prior_while_disabled = None
        self._restart()
        self._change_status(TrackingStatus.INITIALISING.value)
        response.success = True
        response.message = "the tracker starts anew with the next frame"
        return response

    def on_enable(self, request: Message, response: Message) -> Message:
        """Switch tracking on or off. Switching on starts anew, or where it was told meanwhile."""
        if request.data and not self._enabled:
            self._restart()
            if self._prior_while_disabled is not None:
                self._tracker.initialise(self._prior_while_disabled)
            self._prior_while_disabled = None
            self._status = TrackingStatus.INITIALISING.value
        self._enabled = bool(request.data)
        self.publish_diagnostics()
        response.success = True
        response.message = self.status
        return response

    def _restart(self) -> None:
        self._tracker.reset()
        self._frozen.forget()
        self._is_frozen = False
        self._estimate = None
        if self._initial_state is not None:
            self._tracker.initialise(StatePrior.around(self._initial_state))

    def _change_status(self, status: str) -> None:
        if status != self._status:
            self._status = status
            self.get_logger().info(status)
            self.publish_diagnostics()

    def _on_frames_lost(self, event: Any) -> None:  # noqa: ANN401
        self._statistics.lost += int(event.total_count_change)
        self.get_logger().warning(
            f"{self._statistics.lost} frames lost on the way; large frames need"
            " config/fastdds_loopback.xml, image_reliability:=reliable or compressed images",
            throttle_duration_sec=5.0,
        )

    def _on_mismatch(self, event: Any) -> None:  # noqa: ANN401
        # The event names no endpoint: who it is stands in the graph.
        self._look_for_mismatches = True
        self._find_mismatches()

    def _find_mismatches(self) -> None:
        """Say who cannot hear whom, until nobody is left."""
        if not self._look_for_mismatches:
            return
        found = [
            sentence
            for subscription, profile in self._inputs().items()
            for sentence in input_mismatches(self, subscription.topic_name, profile)
        ]
        for publisher, profile in self._outputs.publishers.items():
            found += output_mismatches(self, publisher.topic_name, profile)
        for sentence in found:
            if sentence not in self._mismatches:
                self.get_logger().error(sentence)
        # The graph may learn of an endpoint only after the event: an empty answer is not the last.
        self._look_for_mismatches = bool(found) or not self._mismatches
        self._mismatches = found

    def _inputs(self) -> dict[Any, Any]:
        if self._input is None:
            return {}
        return {self._input: self._image_qos, self._prior_input: qos.RESULTS}

    def on_watchdog(self) -> None:
        """See whether the input has stopped, and publish diagnostics when they are due."""
        self._track_held()
        now = time.monotonic()
        if self._warm_up is not None and not self._warm_up.running:
            self._end_warm_up()
        elif self._warm_up is None and self._is_silent(now) and not self._stale:
            self._stale = True
            self.get_logger().warning(self._words_on_silence())
            self.publish_diagnostics()
        elif now >= self._next_diagnostics:
            self.publish_diagnostics()

    def _is_silent(self, now: float) -> bool:
        return now - self._last_usable > self._input_timeout

    def _words_on_silence(self) -> str:
        topic = self._input.topic_name
        publishers = self.get_publishers_info_by_topic(topic)
        types = sorted({str(publisher.topic_type) for publisher in publishers})
        kinds = f" of type {', '.join(types)}" if types else ""
        refused = self._statistics.last_bad_frame
        reason = f"; the last was refused: {refused}" if refused else ""
        return (
            f"no usable image on {topic} for {self._input_timeout:g} s;"
            f" {len(publishers)} publishers there{kinds}{reason}"
        )

    def publish_diagnostics(self) -> None:
        """Publish status and figures on /diagnostics."""
        now = time.monotonic()
        self._next_diagnostics = now + self._diagnostics_period
        self._find_mismatches()
        values = diagnostic_values(self._statistics, self._estimate, now)
        values |= self._metric.diagnostics()
        values["picture"] = remark_on(self._frozen.picture)
        values["same picture for [s]"] = f"{self._frozen.seconds:.1f}"
        values["QoS mismatch"] = "; ".join(self._mismatches)
        for publisher in self._outputs.publishers:
            values[f"subscribers of {publisher.topic_name}"] = str(
                publisher.get_subscription_count()
            )
        for publisher in self._metric.publishers:
            values[f"readers of {publisher.topic_name}"] = str(publisher.get_subscription_count())
        header = make_header(self._factory, self.get_clock().now().nanoseconds, "")
        name = self.get_fully_qualified_name()
        self._diagnostics.publish(
            make_diagnostics(self._factory, header, name, self.status, values)
        )


def _header_of(message: Message) -> MessageHeader:
    header = message.header
    return MessageHeader(int(header.stamp.sec), int(header.stamp.nanosec), str(header.frame_id))
