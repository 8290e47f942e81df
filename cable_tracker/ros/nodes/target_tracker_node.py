"""The target tracker: an image in; `target`, `state`, outline, bearing and range out."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError, ParameterError
from cable_tracker.metric.frames import mounting_of
from cable_tracker.metric.messages import relative_messages, target_facts
from cable_tracker.node_parameter_tables import (
    TARGET_RUNTIME_PARAMETERS,
    TargetRuntimeParameters,
    TargetStartParameters,
    TargetVehicleParameters,
)
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.health.diagnostics import target_values
from cable_tracker.ros.health.warm_up import WarmUp
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.nodes.camera_node import CameraNode, FrameResult
from cable_tracker.ros.nodes.frame_outputs import FrameOutputs
from cable_tracker.ros.nodes.target_inputs import TargetInputs
from cable_tracker.sequences.encodings import decode_bgr_levels
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.target import (
    messages_without_target,
    read_start,
    target_messages,
)
from cable_tracker.sequences.node_topics import TARGET_TOPICS
from cable_tracker.sequences.pictures.shown_levels import shown_levels
from cable_tracker.target.group import TargetGroup
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.target.model.start import StartText, TargetStart, parse_start_text
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.parameters.presets import target_preset
from cable_tracker.target.tracker import warm_up_target
from cable_tracker.tracking.parameter_table import parameter_table
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.visualisation.target_overlay import draw_target


class TargetTrackerNode(CameraNode):
    """Wraps a `TargetGroup`.

    Parameters
    ----------
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter given at start is not acceptable.
    """

    EVENT_PREFIX = ""

    _decode = staticmethod(decode_bgr_levels)

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__("target_tracker", **node_arguments)
        self._estimates: Sequence[TargetEstimate] = ()
        self._starts: dict[int, TargetStart] = {}
        self._marks: dict[int, TargetStart] = {}
        self._declare_parameters()
        self._restart()
        self._outputs = FrameOutputs(
            self._endpoints,
            TARGET_TOPICS,
            messages_without_target,
            (*TARGET_TOPICS.results, *TARGET_TOPICS.metres),
            self._prefixes,
        )
        self.begin()

    @property
    def group(self) -> TargetGroup:
        """The trackers inside."""
        return self._group

    def _declare_parameters(self) -> None:
        start = node_parameters.declare_set(self, TargetStartParameters(), read_only=True)
        count = start.target_count
        self._prefixes = [""] if count == 1 else [f"target_{number}/" for number in range(count)]
        preset = target_preset(start.preset)
        self._filter_parameters = node_parameters.declare_set(self, preset)
        runtime = node_parameters.declare_set(self, TargetRuntimeParameters())
        vehicle = node_parameters.declare_set(self, TargetVehicleParameters())
        self._instrument_reliability = start.instrument_reliability
        self._begins = self._read_start(runtime.initial_target)
        self._group = TargetGroup(count, self._with_detector())
        self._instruments: TargetInputs = TargetInputs(self, vehicle, count)
        table = (*parameter_table(TargetParameters), *TARGET_RUNTIME_PARAMETERS)
        self._end_declarations(table, self._filter_parameters.maximum_gap)

    def _read_start(self, text: str) -> StartText:
        try:
            start = parse_start_text(text)
        except ParameterError as error:
            raise ParameterError(f"initial_target: {error}") from error
        if len(start.boxes) > len(self._prefixes):
            raise ParameterError(
                f"initial_target marks {len(start.boxes)} targets; target_count is"
                f" {len(self._prefixes)}: mark fewer, or raise target_count"
            )
        return start

    def _with_detector(self) -> TargetParameters:
        """Return the filter's parameters, with a detector where the start needs one."""
        parameters = self._filter_parameters
        return parameters.with_detector() if self._begins.detects else parameters

    def _validate_parameters(self, values: Mapping[str, object]) -> None:
        if "initial_target" in values:
            self._read_start(str(values["initial_target"]))
        node_parameters.with_those_in(self._filter_parameters, values)

    def _apply_parameters(self, values: Mapping[str, object]) -> None:
        if "initial_target" in values:
            self._begins = self._read_start(str(values["initial_target"]))
        self._filter_parameters = node_parameters.with_those_in(self._filter_parameters, values)
        effective = self._with_detector()
        if effective != self._group.parameters:
            self._group.configure(effective)
            self._warm_up_for_change()
        self._apply_camera_values(values, self._filter_parameters.maximum_gap)

    def _make_warm_up(self) -> WarmUp:
        parameters = self._group.parameters
        return WarmUp(("target", *parameters.choices()), partial(warm_up_target, parameters))

    def _subscribe_more(self) -> None:
        for number, prefix in enumerate(self._prefixes):
            topic = TARGET_TOPICS.start
            take = partial(self.on_initial_target, number=number)
            self._endpoints.subscription(topic, take, qos.RESULTS, name=f"{prefix}{topic.name}")

    def _use(self, header: Message, stamp: int, picture: Image) -> FrameResult:
        begin = time.perf_counter()
        size = (picture.shape[1], picture.shape[0])
        self._take_marks(size)
        motion = self._instruments.fusion.camera_motion(stamp, size)
        estimates = self._group.process(picture, stamp, motion)
        for number, tracker in enumerate(self._group.trackers):
            if tracker.has_begun:
                self._instruments.forget(number)
        metres = self._instruments.take(estimates)
        milliseconds = (time.perf_counter() - begin) * 1e3
        clouds = [tracker.particles for tracker in self._group.trackers]
        vehicle = self._instruments.fusion.parameters
        camera_position = mounting_of(vehicle).position
        make = partial(target_messages, MESSAGES, header, ms=milliseconds)
        makers = [
            make(estimate, cloud, metres=partial(target_facts, told, camera_position))
            | relative_messages(MESSAGES, header, vehicle.base_frame, told, camera_position)
            for estimate, cloud, told in zip(estimates, clouds, metres, strict=True)
        ]
        self._outputs.publish_results(makers)
        self._estimates = estimates
        draw = partial(_draw, picture, estimates, clouds)
        rest = partial(self._outputs.publish_rest, makers, header, draw)
        events = dict.fromkeys(estimate.event for estimate in estimates if estimate.event)
        return FrameResult(status_of(estimates), "; ".join(events), rest)

    def _take_marks(self, size: tuple[int, int]) -> None:
        """Start the trackers at the marks that came, if a frame of this size can hold them."""
        marks = self._starts | self._marks
        self._starts, self._marks = {}, {}
        for number, start in sorted(marks.items()):
            try:
                start.check(size)
            except FrameError as error:
                self._refuse_mark(number, error)
                continue
            self._group.initialise(number, start)

    def _refuse_mark(self, number: int, error: FrameError) -> None:
        reason = f"{self._prefixes[number]}initial_target refused: {error}"
        self._statistics.last_event = reason
        self.get_logger().warning(reason)

    def _restart(self) -> None:
        self._group.reset()
        self._instruments.forget()
        self._estimates = ()
        # Apart from marks: what was marked while the node is switched off is followed when it is
        # on again, but the boxes of a parameter that has changed meanwhile are not.
        self._starts = dict(enumerate(self._begins.boxes))

    def on_reset(self, request: Message, response: Message) -> Message:
        """Forget everything, also a mark, and start as at the beginning."""
        self._marks = {}
        return super().on_reset(request, response)

    def on_initial_target(self, message: Message, number: int = 0) -> None:
        """Follow from the next frame on what is marked: two corners of a box, or an outline."""
        frame_id = str(message.header.frame_id)
        try:
            self._check_frame_id(frame_id)
            start = read_start(message)
            if self._estimates:
                start.check(self._estimates[0].image_size)
        except FrameError as error:
            self._refuse_mark(number, error)
            return
        self._note_start(frame_id, number)
        self._marks[number] = start

    def _drop_start(self, number: int, error: FrameError) -> None:
        """Forget a mark that was taken before the first image, and start as without it."""
        self._refuse_mark(number, error)
        self._marks.pop(number, None)

    def _figures(self) -> dict[str, str]:
        figures: dict[str, str] = {}
        for number, prefix in enumerate(self._prefixes):
            name = prefix.replace("/", " ")
            estimate = self._estimates[number] if self._estimates else None
            own = target_values(estimate) | self._instruments.figures(number)
            figures |= {f"{name}{key}": value for key, value in own.items()}
        unaided = self._instruments.fusion.unaided
        return figures | {"no motion aid": "" if unaided is None else unaided.why}


def status_of(estimates: Sequence[TargetEstimate]) -> str:
    """Return the status of a node by that of its targets: the worst of those that were found."""
    statuses = {estimate.status for estimate in estimates}
    for status in (TrackingStatus.LOST, TrackingStatus.TRACKING):
        if status in statuses:
            return str(status.value)
    return str(TrackingStatus.INITIALISING.value)


def _draw(
    picture: Image, estimates: Sequence[TargetEstimate], particles: Sequence[Particles | None]
) -> Image:
    """Draw all targets on a frame, blue-green-red, with levels 0..255."""
    drawn = shown_levels(picture)
    for line, (estimate, cloud) in enumerate(zip(estimates, particles, strict=True)):
        states = cloud.states if cloud is not None else None
        drawn = draw_target(drawn, estimate, states, line=line)
    return drawn
