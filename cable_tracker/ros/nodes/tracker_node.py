"""The tracker node: an image in, `centreline` and `state` out."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import Any

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.borders.response_table import load_table
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.parameters import (
    PARAMETER_TABLE,
    TrackerParameters,
)
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.detection.line_pairs import pair_limits
from cable_tracker.errors import FrameError
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.messages import cable_facts, cross_track_messages
from cable_tracker.node_parameter_tables import (
    TRACKER_RUNTIME_PARAMETERS,
    CableVehicleParameters,
    TrackerRuntimeParameters,
    TrackerStartParameters,
)
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.ros import node_parameters, qos
from cable_tracker.ros.health.diagnostics import cable_values
from cable_tracker.ros.health.warm_up import WarmUp
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.nodes.cable_inputs import CableInputs
from cable_tracker.ros.nodes.camera_node import CameraNode, FrameResult
from cable_tracker.ros.nodes.frame_outputs import FrameOutputs
from cable_tracker.ros.nodes.initial_search import InitialSearch
from cable_tracker.sequences.messages.cable import (
    cable_messages,
    cloud_of,
    messages_without_cable,
    read_prior,
)
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.node_topics import CABLE_TOPICS
from cable_tracker.trackers import CableTracker, make_tracker, warm_up
from cable_tracker.visualisation.overlay import draw_estimate


class TrackerNode(CameraNode):
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
        self._estimate: CableEstimate | None = None
        self._prior_while_disabled: GivenState | None = None
        self._declare_parameters()
        self._restart()
        self._outputs = FrameOutputs(
            self._endpoints,
            CABLE_TOPICS,
            messages_without_cable,
            (*CABLE_TOPICS.metres, *CABLE_TOPICS.results),
        )
        self.begin()

    @property
    def tracker(self) -> CableTracker:
        """The tracker inside."""
        return self._tracker

    def _declare_parameters(self) -> None:
        start = node_parameters.declare_set(self, TrackerStartParameters(), read_only=True)
        parameters = node_parameters.declare_set(self, preset(start.preset))
        runtime = node_parameters.declare_set(self, TrackerRuntimeParameters())
        vehicle = node_parameters.declare_set(self, CableVehicleParameters())
        self._instrument_reliability = start.instrument_reliability
        self._instruments: CableInputs = CableInputs(self, vehicle)
        self._tracker = self._make_tracker(parameters)
        self._warn_of_remarks(())
        self._search = InitialSearch(runtime.initial_state, pair_limits(parameters))
        table = (*PARAMETER_TABLE, *TRACKER_RUNTIME_PARAMETERS)
        self._end_declarations(table, parameters.maximum_gap)

    def _make_tracker(self, parameters: TrackerParameters) -> CableTracker:
        """Make what tracks; a node that compares methods puts another one here."""
        return make_tracker(parameters)

    def _validate_parameters(self, values: Mapping[str, object]) -> None:
        if "initial_state" in values:
            InitialSearch(str(values["initial_state"]))
        present = self._tracker.parameters
        changed = node_parameters.with_those_in(present, values)
        if changed.response_table != present.response_table:
            load_table(changed.response_table)

    def _apply_parameters(self, values: Mapping[str, object]) -> None:
        filter_values = node_parameters.those_in(TrackerParameters, values)
        if filter_values:
            before = self._tracker.parameters.remarks()
            changed = self._tracker.parameters.replaced(filter_values)
            self._tracker.configure(changed)
            self._search.limit(pair_limits(changed))
            self._warm_up_for_change()
            self._warn_of_remarks(before)
        if "initial_state" in values:
            limits = pair_limits(self._tracker.parameters)
            self._search = self._search.changed_to(str(values["initial_state"]), limits)
        self._apply_camera_values(values, self._tracker.parameters.maximum_gap)

    def _warn_of_remarks(self, known: tuple[str, ...]) -> None:
        """Log what is hardly meant about the filter's parameters, unless it was said before."""
        for remark in self._tracker.parameters.remarks():
            if remark not in known:
                self.get_logger().warning(remark)

    def _make_warm_up(self) -> WarmUp:
        parameters = self._tracker.parameters
        return WarmUp(parameters.choices(), partial(warm_up, parameters))

    def _subscribe_more(self) -> None:
        self._endpoints.subscription(CABLE_TOPICS.start, self.on_initial_state, qos.RESULTS)

    def _use(self, header: Message, stamp: int, picture: Image) -> FrameResult:
        begin = time.perf_counter()
        fusion = self._instruments.fusion
        found = self._search.detect(picture) if self._search.is_seeking else None
        if found is not None:
            self._tracker.initialise(found)
        estimate = self._tracker.process(picture, stamp, fusion.motion(stamp, picture))
        milliseconds = (time.perf_counter() - begin) * 1e3
        particles = self._tracker.particles
        makers = cable_messages(
            MESSAGES, header, estimate, particles, ms=milliseconds,
            metres=lambda: cable_facts(self._instruments.result),
        )  # fmt: skip
        self._outputs.publish_results([makers])
        # After the centreline: a controller that needs no metres does not wait for them.
        metres = self._instruments.take(estimate)
        if isinstance(metres, CrossTrack):
            base_frame = fusion.parameters.base_frame
            self._outputs.publish_results(
                [cross_track_messages(MESSAGES, header, base_frame, metres)]
            )
        if estimate.is_claimed:
            self._search.stop()
        self._estimate = estimate
        draw = partial(_draw, picture, estimate, particles)
        rest = partial(self._outputs.publish_rest, [makers], header, draw)
        return FrameResult(estimate.status.value, estimate.event, rest)

    def _restart(self) -> None:
        self._tracker.reset()
        self._instruments.forget()
        self._estimate = None
        prior = self._search.restart()
        if prior is not None:
            self._tracker.initialise(prior)

    def on_initial_state(self, message: Message) -> None:
        """Start the next frame from an operator's or planner's prior."""
        frame_id = str(message.header.frame_id)
        try:
            self._check_frame_id(frame_id)
            prior = read_prior(message)
            self._tracker.initialise(prior)
            self._search.stop()
        except FrameError as error:
            self._refuse_prior(error)
            return
        self._note_start(frame_id)
        self.get_logger().info(f"initial_state taken: {prior.describe()}")
        if not self._enabled:
            self._prior_while_disabled = prior

    def _refuse_prior(self, error: FrameError) -> None:
        self.get_logger().warning(f"initial_state refused: {error}")

    def _drop_start(self, number: int, error: FrameError) -> None:
        """Forget a prior that was taken before the first image, and start as without it."""
        self._refuse_prior(error)
        self._prior_while_disabled = None
        self._restart()

    def on_reset(self, request: Message, response: Message) -> Message:
        """Forget everything, also a prior, and start as at the beginning."""
        self._prior_while_disabled = None
        return super().on_reset(request, response)

    def _on_switched_on(self) -> None:
        prior, self._prior_while_disabled = self._prior_while_disabled, None
        if prior is not None:
            self._tracker.initialise(prior)
            self._search.stop()

    def _figures(self) -> dict[str, str]:
        return cable_values(self._estimate) | self._instruments.diagnostics()


def _draw(grey: Image, estimate: CableEstimate, particles: Particles | None) -> Image:
    cloud = cloud_of(particles) if particles is not None else None
    return draw_estimate(grey, estimate, cloud)
