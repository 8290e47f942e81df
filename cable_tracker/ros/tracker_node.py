"""The tracker node: an image in, `centreline` and `state` out."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any, cast

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.publisher import Publisher
from sensor_msgs.msg import CompressedImage, Image, JointState, PointCloud2
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from cable_tracker.arrays import FloatArray
from cable_tracker.arrays import Image as Picture
from cable_tracker.cable.estimate import CableEstimate, TrackingStatus
from cable_tracker.cable.initial_state_text import parse_initial_state
from cable_tracker.cable.initialisation import StatePrior
from cable_tracker.cable.parameters import PARAMETER_TABLE, PARAMETERS_BY_NAME
from cable_tracker.cable.presets import preset
from cable_tracker.cable.response_table import load_table
from cable_tracker.cable.state import CableState
from cable_tracker.cable.tracker import CableTracker
from cable_tracker.errors import FrameError
from cable_tracker.node_parameter_tables import (
    TRACKER_RUNTIME_PARAMETERS,
    TRACKER_START_PARAMETERS,
)
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.diagnostics import (
    DISABLED,
    STALE_INPUT,
    FrameStatistics,
    diagnostic_values,
    make_diagnostics,
)
from cable_tracker.ros.process import ProcessNode
from cable_tracker.ros.rclpy_messages import RclpyMessages
from cable_tracker.sequences import frame as frames
from cable_tracker.sequences.encodings import decode_grey, raw_from_array
from cable_tracker.sequences.estimates import REFUSED
from cable_tracker.sequences.jpeg import encode_jpeg
from cable_tracker.sequences.messages import (
    Message,
    cloud_of,
    make_centreline,
    make_compressed_image,
    make_header,
    make_image,
    make_markers,
    make_particles,
    make_report,
    make_state,
    read_compressed_image,
    read_image,
    read_prior,
    report_values,
    stamp_of,
)
from cable_tracker.trackers import make_proposer, make_tracker
from cable_tracker.visualisation.overlay import draw_overlay

WATCHDOG_PERIOD = 0.05


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
        self._declare_parameters()
        self._enabled = True
        self._stale = False
        self._status = TrackingStatus.INITIALISING.value
        self._estimate: CableEstimate | None = None
        self._frame_id = ""
        self._prior_while_disabled: StatePrior | None = None
        # A camera that never sends is no better than one that has stopped.
        self._last_arrival = time.monotonic()
        self._next_diagnostics = 0.0
        self._restart()
        self._create_publishers()
        self._create_inputs()
        self.publish_diagnostics()
        self.get_logger().info(f"waiting for images on {self._input.topic_name}")

    @property
    def status(self) -> str:
        """What diagnostics say now."""
        if not self._enabled:
            return DISABLED
        return STALE_INPUT if self._stale else self._status

    @property
    def statistics(self) -> FrameStatistics:
        """Counts and times of the frames that came in."""
        return self._statistics

    @property
    def tracker(self) -> CableTracker:
        """The tracker inside."""
        return self._tracker

    def _declare_parameters(self) -> None:
        start = {
            spec.name: node_parameters.declare(self, spec, spec.default, read_only=True)
            for spec in TRACKER_START_PARAMETERS
        }
        values = preset(str(start["preset"]))
        given = {
            spec.name: node_parameters.declare(self, spec, values.as_mapping()[spec.name])
            for spec in PARAMETER_TABLE
        }
        runtime = {
            spec.name: node_parameters.declare(self, spec, spec.default)
            for spec in TRACKER_RUNTIME_PARAMETERS
        }
        self._compressed_input = start["image_transport"] == "compressed"
        self._reliability = str(start["image_reliability"])
        self._tracker = make_tracker(values.replaced(given))
        self._apply_runtime_values(runtime)
        specs = {spec.name: spec for spec in TRACKER_RUNTIME_PARAMETERS} | dict(PARAMETERS_BY_NAME)
        node_parameters.watch(self, specs, self._validate_parameters, self._apply_parameters)
        for name in node_parameters.unknown_overrides(self):
            self.get_logger().warning(
                f"unknown parameter '{name}' is ignored; docs/parameters.md lists all"
            )

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
        self._apply_runtime_values(values)

    def _apply_runtime_values(self, values: Mapping[str, object]) -> None:
        if "initial_state" in values:
            self._initial_state = parse_initial_state(str(values["initial_state"]))
        if "input_timeout" in values:
            self._input_timeout = float(cast(float, values["input_timeout"]))
        if "diagnostics_period" in values:
            self._diagnostics_period = float(cast(float, values["diagnostics_period"]))

    def _create_publishers(self) -> None:
        self._state = self.create_publisher(JointState, "state", qos.LATEST_RESULT)
        self._centreline = self.create_publisher(
            PoseWithCovarianceStamped, "centreline", qos.RESULTS
        )
        self._particles = self.create_publisher(PointCloud2, "particles", qos.PICTURES)
        self._markers = self.create_publisher(MarkerArray, "markers", qos.PICTURES)
        self._overlay = self.create_publisher(Image, "~/overlay", qos.PICTURES)
        self._overlay_compressed = self.create_publisher(
            CompressedImage, "~/overlay/compressed", qos.PICTURES
        )
        self._report = self.create_publisher(DiagnosticArray, "~/frame_report", qos.RESULTS)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", qos.RESULTS)

    def _create_inputs(self) -> None:
        profile = qos.image_input(self._reliability)
        events = SubscriptionEventCallbacks(message_lost=self._on_frames_lost)
        if self._compressed_input:
            self._input = self.create_subscription(
                CompressedImage,
                "image/compressed",
                self.on_compressed_image,
                profile,
                event_callbacks=events,
            )
        else:
            self._input = self.create_subscription(
                Image, "image", self.on_image, profile, event_callbacks=events
            )
        self.create_subscription(
            PoseWithCovarianceStamped, "initial_state", self.on_initial_state, qos.RESULTS
        )
        self.create_service(Trigger, "~/reset", self.on_reset)
        self.create_service(SetBool, "~/enable", self.on_enable)
        # Simulated time may stand still while frames stay away: the watchdog needs a clock that
        # does not.
        self.create_timer(
            WATCHDOG_PERIOD, self.on_watchdog, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def on_image(self, message: Message) -> None:
        """Track on an uncompressed image."""
        self._take(message.header, lambda: read_image(message))

    def on_compressed_image(self, message: Message) -> None:
        """Track on a JPEG or PNG."""
        self._take(message.header, lambda: read_compressed_image(message))

    def _take(
        self, header: Message, read: Callable[[], frames.RawImage | frames.CompressedImage]
    ) -> None:
        arrival = time.perf_counter()
        self._note_arrival()
        self._frame_id = str(header.frame_id)
        stamp = stamp_of(header)
        if not stamp:
            stamp = self.get_clock().now().nanoseconds
            header = make_header(self._factory, stamp, header.frame_id)
        if not self._enabled:
            self._statistics.ignored += 1
            self._answer_without_estimate(header, DISABLED, "")
            return
        try:
            grey = decode_grey(read())
            begin = time.perf_counter()
            estimate = self._tracker.process(grey, stamp)
        except FrameError as error:
            self._refuse(header, str(error))
            return
        milliseconds = (time.perf_counter() - begin) * 1e3
        self._statistics.tracked += 1
        self._estimate = estimate
        self._publish_estimate(header, estimate, grey, milliseconds)
        self._statistics.finished((time.perf_counter() - arrival) * 1e3)
        self._note_event(estimate.event)
        self._change_status(estimate.status.value)

    def _note_arrival(self) -> None:
        now = time.monotonic()
        self._last_arrival = now
        self._statistics.arrived(now)
        if self._stale:
            self._stale = False
            self.publish_diagnostics()

    def _note_event(self, event: str) -> None:
        if event:
            self._statistics.last_event = event
            self.get_logger().warning(f"tracking starts anew: {event}")

    def _refuse(self, header: Message, reason: str) -> None:
        self._statistics.refused += 1
        self._statistics.last_bad_frame = reason
        self.get_logger().warning(f"frame refused: {reason}", throttle_duration_sec=1.0)
        self._answer_without_estimate(header, REFUSED, reason)

    def _answer_without_estimate(self, header: Message, status: str, reason: str) -> None:
        """Publish that there is no estimate for this frame; every frame gets an answer."""
        if self._report.get_subscription_count():
            self._report.publish(make_report(self._factory, header, status, {"event": reason}))
        self._state.publish(make_state(self._factory, header, None))

    def _publish_estimate(
        self, header: Message, estimate: CableEstimate, grey: Picture, milliseconds: float
    ) -> None:
        claimed = estimate.state if estimate.status is TrackingStatus.TRACKING else None
        sigma = estimate.standard_deviations()[:4]
        if claimed is not None:
            self._centreline.publish(
                make_centreline(self._factory, header, claimed, estimate.covariance)
            )
        self._publish_pictures(header, estimate, claimed, grey, sigma)
        if self._report.get_subscription_count():
            self._report.publish(
                make_report(
                    self._factory,
                    header,
                    estimate.status.value,
                    report_values(estimate, milliseconds),
                )
            )
        # Last, because a lockstep replay sends the next frame upon it.
        self._state.publish(make_state(self._factory, header, claimed, sigma))

    def _publish_pictures(
        self,
        header: Message,
        estimate: CableEstimate,
        claimed: CableState | None,
        grey: Picture,
        sigma: FloatArray,
    ) -> None:
        particles = self._tracker.particles
        assert particles is not None
        if self._particles.get_subscription_count():
            self._particles.publish(make_particles(self._factory, header, cloud_of(particles)))
        if self._markers.get_subscription_count():
            self._markers.publish(make_markers(self._factory, header, claimed, estimate.image_size))
        if not (
            self._overlay.get_subscription_count()
            or self._overlay_compressed.get_subscription_count()
        ):
            return
        picture = draw_overlay(
            grey,
            state=claimed,
            status=estimate.status.value,
            sigma=sigma,
            cloud=cloud_of(particles),
            hypotheses=estimate.hypotheses,
            presence=estimate.presence,
        )
        self._publish_overlay(header, picture)

    def _publish_overlay(self, header: Message, picture: Picture) -> None:
        if self._overlay.get_subscription_count():
            raw = raw_from_array(picture, "bgr8")
            self._overlay.publish(make_image(self._factory, raw, header))
        if self._overlay_compressed.get_subscription_count():
            jpeg = make_compressed_image(self._factory, encode_jpeg(picture), header)
            self._overlay_compressed.publish(jpeg)

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
        self._estimate = None
        if self._initial_state is not None:
            self._tracker.initialise(StatePrior.around(self._initial_state))

    def _change_status(self, status: str) -> None:
        if status != self._status:
            self._status = status
            self.get_logger().info(status)
            self.publish_diagnostics()

    def _on_frames_lost(self, event: Any) -> None:  # noqa: ANN401
        self._statistics.dropped += int(event.total_count_change)
        self.get_logger().warning(
            f"{self._statistics.dropped} frames lost on the way; large frames need"
            " config/fastdds_loopback.xml, image_reliability:=reliable or compressed images",
            throttle_duration_sec=5.0,
        )

    def on_watchdog(self) -> None:
        """See whether the input has stopped, and publish diagnostics when they are due."""
        now = time.monotonic()
        if now - self._last_arrival > self._input_timeout and not self._stale:
            self._stale = True
            topic = self._input.topic_name
            publishers = self.count_publishers(topic)
            self.get_logger().warning(
                f"no image on {topic} for {self._input_timeout:g} s; {publishers} publishers there"
            )
            self.publish_diagnostics()
        elif now >= self._next_diagnostics:
            self.publish_diagnostics()

    def publish_diagnostics(self) -> None:
        """Publish status and figures on /diagnostics."""
        now = time.monotonic()
        self._next_diagnostics = now + self._diagnostics_period
        values = diagnostic_values(self._statistics, self._estimate, now)
        for publisher in self._on_demand_publishers():
            values[f"subscribers of {publisher.topic_name}"] = str(
                publisher.get_subscription_count()
            )
        header = make_header(self._factory, self.get_clock().now().nanoseconds, "")
        name = self.get_fully_qualified_name()
        self._diagnostics.publish(
            make_diagnostics(self._factory, header, name, self.status, values)
        )

    def _on_demand_publishers(self) -> tuple[Publisher, ...]:
        return (
            self._state,
            self._centreline,
            self._particles,
            self._markers,
            self._overlay,
            self._overlay_compressed,
            self._report,
        )
