"""Track a whole recording with both nodes in processes of their own, over DDS, in lockstep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from cable_tracker.errors import RecordingError
from cable_tracker.metric.recorded_instruments import RecordedVehicle
from cable_tracker.offline.cable_folder import CableFolder
from cable_tracker.ros.clients.lockstep import (
    EVERY_MEASUREMENT,
    track_in_lockstep,
    write_messages,
)
from cable_tracker.ros.clients.message_rows import cable_row
from cable_tracker.ros.clients.recorder import RecordedFrame
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.frame_messages import write_truth
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.cable import read_particles
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import report_facts
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.tracking.parameter_table import ParameterValue


def track_cable_over_ros(
    frames: Iterable[Frame],
    parameters: Mapping[str, ParameterValue],
    replay: Mapping[str, ParameterValue],
    results: CableFolder,
    vehicle: RecordedVehicle,
) -> RecordingError | None:
    """Track a cable through all frames of a recording; see `track_in_lockstep`.

    Parameters
    ----------
    frames, replay
        See `track_in_lockstep`.
    parameters : mapping
        Parameters of the tracker, but those of the vehicle.
    results : CableFolder
        Takes what is published.
    vehicle : RecordedVehicle
        Vehicle of the recording, with its instruments.
    """

    def take(frame: Frame, recorded: RecordedFrame) -> Message:
        write_truth(results.bag, frame)
        write_messages(results.bag, frame, recorded)
        state = recorded.read(node_topics.STATE)
        cloud = None
        if node_topics.PARTICLES in recorded.messages:
            cloud = read_particles(recorded.read(node_topics.PARTICLES))
        results.add(frame, _row(frame, recorded, state, in_metres=vehicle.wants_metres), cloud)
        return state

    own = {**parameters, **_vehicle_parameters(vehicle)}
    return track_in_lockstep(frames, node_topics.CABLE_TOPICS, own, replay, take)


def _vehicle_parameters(vehicle: RecordedVehicle) -> dict[str, ParameterValue]:
    if not vehicle.wants_metres:
        return {}
    values = vehicle.vehicle.parameters.as_mapping()
    # Without instruments nothing is sent that a frame could wait for.
    return {**values, **EVERY_MEASUREMENT} if vehicle.has_instruments else values


def _row(frame: Frame, recorded: RecordedFrame, state: Message, *, in_metres: bool) -> EstimateRow:
    """Return the row of the table for an answered frame.

    The node always says why it has no metres. Without `in_metres` none are wanted: the row says
    nothing of them, as without ROS.
    """
    facts = report_facts(recorded.read(node_topics.FRAME_REPORT))
    row = cable_row(frame.index, frame.stamp, recorded.status, state, facts)
    if not in_metres:
        row = replace(row, metres=None, no_metres="")
    # Of a frame that the recording cannot give the node is sent nothing, and knows no more.
    return replace(row, event=frame.image.missing or row.event)
