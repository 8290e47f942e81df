"""Base of every node that tracks something in the frames of a camera."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from builtin_interfaces.msg import Time
from rclpy.clock import Clock, ClockType
from std_msgs.msg import Header
from std_srvs.srv import SetBool, Trigger

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError
from cable_tracker.node_parameter_tables import (
    RELIABLE,
    CameraRuntimeParameters,
    CameraStartParameters,
)
from cable_tracker.ros import node_parameters
from cable_tracker.ros.health.diagnostics import FROZEN_INPUT, FrameStatistics
from cable_tracker.ros.health.warm_up import WarmUp
from cable_tracker.ros.health.watched_endpoints import WatchedEndpoints
from cable_tracker.ros.inputs.frame_hold import FrameHold
from cable_tracker.ros.inputs.image_input import CameraFrame, ImageInput
from cable_tracker.ros.inputs.input_watch import InputWatch
from cable_tracker.ros.inputs.instrument_inputs import InstrumentInputs
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.nodes.camera_diagnostics import CameraDiagnostics
from cable_tracker.ros.nodes.frame_outputs import FrameOutputs
from cable_tracker.ros.process.process_node import ProcessNode
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import check_stamp, make_header
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import ParameterSpec
from cable_tracker.tracking.status import DISABLED, REFUSED, WARMING_UP, TrackingStatus

SLOWEST_WATCH, FASTEST_WATCH = 0.25, 0.025
"""Limits of the period of the watchdog [s]; it is half the shortest time-out."""

WORTH_TELLING = 0.1
"""A warm-up that took less is not reported [s]."""

NO_TIME = (
    "the frame has no stamp, and there is no time to give it: use_sim_time is set and nothing has"
    " come on /clock"
)


@dataclass(frozen=True, slots=True)
class FrameResult:
    """Outcome of a frame that was used.

    Attributes
    ----------
    status : str
        Status after the frame, as on /diagnostics.
    event : str
        Reason why tracking started anew with the frame; empty if it went on.
    publish_rest : callable
        Publishes the pictures for people and, last, the state: a controller waits for neither.
    """

    status: str
    event: str
    publish_rest: Callable[[], None]


class CameraNode(ProcessNode, ABC):
    """Answers each frame of a camera, and reports status and figures on /diagnostics.

    Holds what does not depend on what is tracked: the subscription of the camera, refused frames,
    stale and frozen input, the warm-up, `~/enable` and `~/reset`, quality of service that does not
    fit, diagnostics. A subclass makes its own parts after this constructor, `_instruments` and
    `_outputs` among them, calls `begin` when it is complete, and implements the methods of the
    section "to be implemented".

    Parameters
    ----------
    name : str
        Name of the node.
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter given at start is not acceptable.
    """

    EVENT_PREFIX: ClassVar[str] = "tracking starts anew: "
    """What the log says before the tracker's reason."""

    _decode = staticmethod(decode_grey)
    """Makes the picture that is tracked on; of grey levels, shape (H, W), unless overridden."""

    _instruments: InstrumentInputs[Any, Any]
    _instrument_reliability: str
    _outputs: FrameOutputs

    def __init__(self, name: str, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__(name, **node_arguments)
        self._statistics = FrameStatistics()
        self._watch = InputWatch(time.monotonic())
        self._enabled = True
        self._status = self._published_status = TrackingStatus.INITIALISING.value
        self._frame_id: str | None = None
        self._unchecked: dict[int, str] = {}
        self._warm_up: WarmUp | None = None
        self._watchdog: Any = None
        start = node_parameters.declare_set(self, CameraStartParameters(), read_only=True)
        self._camera_parameters = node_parameters.declare_set(self, CameraRuntimeParameters())
        self._answers_every_frame = start.image_reliability == RELIABLE
        self._input = ImageInput(
            self, start.image_transport, start.image_reliability, self._statistics
        )
        self._endpoints = WatchedEndpoints(self)
        self._diagnostics = CameraDiagnostics(
            self, self._statistics, self._watch, self._input, self._endpoints
        )

    # To be implemented by a subclass.

    @abstractmethod
    def _make_warm_up(self) -> WarmUp:
        """Start the warm-up of the code that the present parameters choose."""

    @abstractmethod
    def _use(self, header: Message, stamp: int, picture: Image) -> FrameResult:
        """Track on a frame and publish what is claimed; the rest is published afterwards.

        Parameters
        ----------
        header : Message
            Header of the answers.
        stamp : int
            Time of the frame [ns].
        picture : Image
            Decoded pixels, as returned by `_decode`.

        Raises
        ------
        FrameError
            The frame cannot be used.
        """

    @abstractmethod
    def _validate_parameters(self, values: Mapping[str, object]) -> None:
        """Refuse changed values, by name, that do not fit those that stay.

        Raises
        ------
        ParameterError
            They do not.
        """

    @abstractmethod
    def _apply_parameters(self, values: Mapping[str, object]) -> None:
        """Take changed values, by name."""

    @abstractmethod
    def _restart(self) -> None:
        """Forget what was tracked. That a picture stands still is the camera's, and stays known."""

    @abstractmethod
    def _figures(self) -> dict[str, str]:
        """Return what diagnostics say beside the camera's figures, with units in the keys."""

    def _subscribe_more(self) -> None:
        """Subscribe to what belongs to the camera's frames; called when the node is warm."""

    @abstractmethod
    def _drop_start(self, number: int, error: FrameError) -> None:
        """Forget a prior that was taken before the first image, and turns out to be wrong."""

    def _on_switched_on(self) -> None:
        """Do what follows the restart when the node is enabled again."""

    # For subclasses.

    def _end_declarations(self, table: Iterable[ParameterSpec], maximum_gap: float) -> None:
        """Put the camera's parameters into force, and react to changes from now on.

        Parameters
        ----------
        table : iterable of ParameterSpec
            The parameters that may be changed while the node runs.
        maximum_gap : float
            Longest pause between frames that the filter bears [s].
        """
        self._apply_camera_values({}, maximum_gap)
        node_parameters.watch(self, table, self._apply_parameters, self._validate_parameters)
        node_parameters.warn_of_unknown_overrides(self)

    # For callers and tests.

    @property
    def status(self) -> str:
        """Status that diagnostics report now."""
        if not self._enabled:
            return DISABLED
        if self._warm_up is not None:
            return WARMING_UP
        return self._watch.status or self._status

    @property
    def statistics(self) -> FrameStatistics:
        """Counts and times of the frames that came in."""
        return self._statistics

    def wait_until_warm(self) -> None:
        """Wait for the end of the warm-up; for callers that feed frames without an executor."""
        if self._warm_up is not None:
            self._end_warm_up()

    # Start and warm-up.

    def begin(self) -> None:
        """Offer the services and warm up; the camera is subscribed when that is done."""
        give_way = self._answer if self._answers_every_frame else self._give_way
        self._hold = FrameHold(self._answer, self._instruments.has_all_of, give_way)
        self.create_service(Trigger, "~/reset", self.on_reset)
        self.create_service(SetBool, "~/enable", self.on_enable)
        # Simulated time may stand still while frames stay away: the watchdog needs a clock that
        # does not.
        self._watchdog = self.create_timer(
            self._watchdog_period(),
            self.on_watchdog,
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )
        self._warm_up = self._make_warm_up()
        if self._warm_up.running:
            self.get_logger().info(
                "warming up: loading what a frame needs takes seconds; once per installation it is"
                " compiled, which takes about half a minute of a laptop's processor"
            )
            self.publish_diagnostics()
        else:
            self._end_warm_up()

    def _warm_up_for_change(self) -> None:
        """Stop tracking until another variant is compiled, and say so."""
        if self._watchdog is None:
            return  # `begin` warms up.
        before, warm_up = self._warm_up, self._make_warm_up()
        if before is not None:
            before.abandon()
            self._warm_up = warm_up
        elif warm_up.running:
            self._warm_up = warm_up
            self.get_logger().warning("warming up: the change needs other code; no frame is used")
            self.publish_diagnostics()

    def _end_warm_up(self) -> None:
        assert self._warm_up is not None
        self._warm_up.finish()
        if self._warm_up.seconds > WORTH_TELLING:
            self.get_logger().info(f"warmed up in {self._warm_up.seconds:.1f} s")
        self._warm_up = None
        self._watch.restart(time.monotonic())
        if not self._input.is_open:
            self._instruments.subscribe(self._instrument_reliability, self._hold.release_if_due)
            self._subscribe_more()
            self._input.subscribe(self._endpoints, self.on_image)
            self.get_logger().info(f"waiting for images on {self._input.topic}")
        self.publish_diagnostics()

    def _apply_camera_values(self, values: Mapping[str, object], maximum_gap: float) -> None:
        """Take what is given by name of the camera's and the instruments' parameters.

        Parameters
        ----------
        values : mapping
            Changed values of the node's parameters.
        maximum_gap : float
            Longest pause between frames that the filter bears [s].
        """
        self._camera_parameters = node_parameters.with_those_in(self._camera_parameters, values)
        self._watch.configure(self._camera_parameters, maximum_gap)
        self._diagnostics.period = self._camera_parameters.diagnostics_period
        self._instruments.apply(values)
        if self._watchdog is not None:
            self._watchdog.timer_period_ns = round(self._watchdog_period() * NANOSECONDS)

    def _watchdog_period(self) -> float:
        shortest = min(self._watch.timeout, self._diagnostics.period)
        return min(max(shortest / 2, FASTEST_WATCH), SLOWEST_WATCH)

    # Frames.

    def on_image(self, message: bytes, info: Mapping[str, Any]) -> None:
        """Answer a frame, at once or as soon as the instruments have told of its time.

        Parameters
        ----------
        message : bytes
            A sensor_msgs/Image or CompressedImage, serialised, as the middleware hands it over.
        info : mapping
            Message info from rclpy: `received_timestamp` and sequence number.
        """
        try:
            frame = self._input.read(message, info)
        except FrameError as error:
            # Without a header there is nothing that an answer could refer to.
            self._note_refusal(str(error))
            return
        self._statistics.arrivals.append(time.monotonic())
        is_held = self._enabled and frame.stamp
        wait = self._instruments.fusion.parameters.instrument_wait if is_held else 0.0
        # One that waits for nothing must not overtake those that do.
        if wait or self._hold.held:
            self._hold.take(frame, wait)
        else:
            self._answer(frame)

    def seconds_until_due(self) -> float:
        """Return how long the executor may sleep [s]: until a frame has waited long enough."""
        return self._hold.seconds_until_due()

    def work(self) -> None:
        """Answer the frames that have waited long enough for the instruments."""
        self._hold.release_if_due()

    def _give_way(self, frame: CameraFrame) -> None:
        """Leave a frame out for a newer one, as the middleware does of those that it keeps."""
        self._statistics.dropped += 1

    def _answer(self, frame: CameraFrame) -> None:
        self._frame_id = frame.header.frame_id
        if self._unchecked:
            self._check_early_starts()
        stamp = frame.stamp or self._time_of(frame.arrival)
        header = self._header_for_answer(frame, stamp)
        if not self._enabled or self._warm_up is not None:
            self._statistics.ignored += 1
            self._note_usable()
            self._publish_changed_status()
            self._outputs.answer_without_estimate(header, self.status, "")
            return
        try:
            if not stamp:
                raise FrameError(NO_TIME)
            # Before the filter moves: what is found could not be published.
            check_stamp(stamp)
            picture = self._decode(frame.image)
            if self._watch.is_frozen(picture, stamp):
                self._answer_frozen(header)
                return
            outcome = self._use(header, stamp, picture)
            self._statistics.latency.add((time.perf_counter() - frame.arrival) * 1e3)
            self._statistics.tracked += 1
            outcome.publish_rest()
        except FrameError as error:
            self._note_refusal(str(error))
            self._outputs.answer_without_estimate(header, REFUSED, str(error))
            return
        # Not before: a refused frame leaves the figures of before the picture stood still.
        self._watch.note_frozen(is_frozen=False)
        self._note_usable()
        self._note_event(outcome.event)
        self._change_status(outcome.status)

    def _time_of(self, arrival: float) -> int:
        """Return the node's time when a frame came [ns]; 0 while there is none.

        Simulated time may pass at another pace, or stand still: of that it is the time now.
        """
        clock = self.get_clock()
        now = int(clock.now().nanoseconds)
        if clock.ros_time_is_active:
            return now
        return now - round((time.perf_counter() - arrival) * NANOSECONDS)

    def _header_for_answer(self, frame: CameraFrame, stamp: int) -> Message:
        given = frame.header
        if not frame.stamp:
            return make_header(MESSAGES, stamp, given.frame_id)
        # To the letter, so that the sender of the frame knows it again.
        time_sent = Time(sec=given.sec, nanosec=given.nanosec)
        return Header(stamp=time_sent, frame_id=given.frame_id)

    def _answer_frozen(self, header: Message) -> None:
        """Claim nothing: a picture that stands still is no measurement."""
        self._statistics.frozen += 1
        self._note_usable()
        self._outputs.answer_without_estimate(header, FROZEN_INPUT, "the picture stands still")
        if self._watch.note_frozen(is_frozen=True):
            self.get_logger().error(
                f"the camera has sent the same picture for {self._watch.same_for:.1f} s;"
                " tracking goes on when it changes (parameter frozen_timeout)"
            )
        self._publish_changed_status()

    def _note_usable(self) -> None:
        self._statistics.refused_in_a_row = 0
        self._watch.note_usable(time.monotonic())

    def _note_event(self, event: str) -> None:
        if event:
            self._statistics.last_event = event
            self.get_logger().warning(f"{self.EVENT_PREFIX}{event}")

    def _note_refusal(self, reason: str) -> None:
        self._statistics.refused += 1
        self._statistics.refused_in_a_row += 1
        self._statistics.last_bad_frame = reason
        self.get_logger().warning(f"frame refused: {reason}", throttle_duration_sec=1.0)

    def _change_status(self, status: str) -> None:
        if status != self._status:
            self._status = status
            self.get_logger().info(status)
        self._publish_changed_status()

    def _publish_changed_status(self) -> None:
        """Publish diagnostics if they said another status than the present one.

        Also where one has hidden another, as that of a camera that was silent does.
        """
        if self.status != self._published_status:
            self.publish_diagnostics()

    def _check_frame_id(self, frame_id: str) -> None:
        """Refuse a prior that is given in the frame of something else than the camera."""
        if frame_id and self._frame_id and frame_id != self._frame_id:
            raise FrameError(f"it is in {frame_id!r}, not in the image frame {self._frame_id!r}")

    def _note_start(self, frame_id: str, number: int = 0) -> None:
        """Remember the frame of a prior that was taken, of a target by its number.

        Before the first image nothing is known that the prior's frame could be compared with.
        """
        if self._frame_id is None:
            self._unchecked[number] = frame_id

    def _check_early_starts(self) -> None:
        """Drop priors that were taken before the first image, and are in another frame."""
        unchecked, self._unchecked = self._unchecked, {}
        for number, frame_id in unchecked.items():
            try:
                self._check_frame_id(frame_id)
            except FrameError as error:
                self._drop_start(number, error)

    # Services.

    def on_reset(self, request: Message, response: Message) -> Message:
        """Forget everything and start as at the beginning."""
        self.get_logger().info("reset: the tracker starts anew with the next frame")
        self._unchecked = {}
        self._restart()
        self._change_status(TrackingStatus.INITIALISING.value)
        response.success = True
        response.message = "the tracker starts anew with the next frame"
        return response

    def on_enable(self, request: Message, response: Message) -> Message:
        """Switch tracking on or off. Switching on starts anew, or from a prior given meanwhile."""
        is_wanted = bool(request.data)
        if is_wanted != self._enabled:
            self.get_logger().info(
                "enabled: the tracker starts anew with the next frame"
                if is_wanted
                else "disabled: frames are answered without an estimate"
            )
        if is_wanted and not self._enabled:
            self._restart()
            self._on_switched_on()
            self._status = TrackingStatus.INITIALISING.value
        self._enabled = is_wanted
        self.publish_diagnostics()
        response.success = True
        response.message = self.status
        return response

    # Health.

    def on_watchdog(self) -> None:
        """See whether the input has stopped, and publish diagnostics when they are due."""
        self._instruments.ask_for_calibration()
        now = time.monotonic()
        if self._warm_up is not None and not self._warm_up.running:
            self._end_warm_up()
        elif self._warm_up is None and self._watch.falls_silent(now):
            self.get_logger().warning(self._input.describe_silence(self._watch.timeout))
            self.publish_diagnostics()
        elif self._diagnostics.is_due(now):
            self.publish_diagnostics()

    def publish_diagnostics(self) -> None:
        """Publish status and figures on /diagnostics."""
        self._published_status = self.status
        figures = self._figures()
        if self.status != self._status:
            # What was found in the last frame that was used is none of now.
            figures = dict.fromkeys(figures, "")
        self._diagnostics.publish(self.status, figures)
