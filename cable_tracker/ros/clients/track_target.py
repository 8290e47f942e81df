"""Follow a target through a recording with both nodes in processes of their own, in lockstep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import ClassVar

from cable_tracker.errors import RecordingError
from cable_tracker.offline.target_folder import TargetFolder
from cable_tracker.offline.target_table import TargetRow, metres_row, refused_metres_row
from cable_tracker.ros.clients.lockstep import LockstepNodes, track_in_lockstep, write_messages
from cable_tracker.ros.clients.message_rows import target_row
from cable_tracker.ros.clients.recorder import RecordedFrame, Recorder
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import report_facts
from cable_tracker.sequences.messages.images import read_compressed_image
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_table import ParameterValue
from cable_tracker.tracking.status import REFUSED


class TargetRecorder(Recorder):
    """Subscribes to the outputs of a target tracker, and puts together those of one frame."""

    RECORDED: ClassVar[tuple[NodeTopic, ...]] = (
        node_topics.STATE,
        node_topics.TARGET_REPORT,
        node_topics.TARGET,
        node_topics.BOX,
        node_topics.CONTOUR,
        node_topics.BEARING,
        node_topics.RELATIVE_POSE,
        node_topics.PARTICLES,
        node_topics.MARKERS,
        node_topics.TARGET_OVERLAY,
        node_topics.DIAGNOSTICS,
    )
    REPORT: ClassVar[NodeTopic] = node_topics.TARGET_REPORT


def target_nodes(
    compressed: bool,
    replay: Mapping[str, ParameterValue],
    parameters: TargetParameters,
    initial_target: str,
    sight: Mapping[str, ParameterValue],
) -> LockstepNodes:
    """Return the nodes that follow a target.

    Parameters
    ----------
    compressed : bool
        Whether the pictures of the recording are compressed.
    replay : mapping
        Parameters of the replay node that name the recording, see `replay_parameters`.
    parameters : TargetParameters
        Parameters of the filter.
    initial_target : str
        `detect`, or a box.
    sight : mapping
        Parameters of the tracker about camera and instruments.
    """
    start: dict[str, ParameterValue] = {"initial_target": initial_target}
    own = {**parameters.as_mapping(), **sight, **start}
    return LockstepNodes("target_tracker", compressed, own, replay, TargetRecorder)


def track_target_over_ros(
    frames: Iterable[Frame],
    nodes: LockstepNodes,
    results: TargetFolder,
    *,
    with_metres: bool = False,
) -> RecordingError | None:
    """Follow a target with `target_nodes`, in metres too; see `track_in_lockstep`."""

    def take(frame: Frame, recorded: RecordedFrame) -> Message:
        write_messages(results.bag, frame, recorded)
        state = recorded.read(node_topics.STATE)
        picture = None
        if node_topics.TARGET_OVERLAY in recorded.messages:
            overlay = read_compressed_image(recorded.read(node_topics.TARGET_OVERLAY))
            picture = decode_bgr(overlay)
        facts = report_facts(recorded.read(node_topics.TARGET_REPORT))
        row = target_row(frame.index, frame.stamp, recorded.status, state, facts)
        # Of a frame that the recording cannot give the node is sent nothing, and knows no more.
        row = replace(row, event=frame.image.missing or row.event)
        if with_metres:
            results.metres.append(_metres_row(frame, facts, row))
        results.add(frame, row, picture)
        return state

    return track_in_lockstep(frames, nodes, take)


def _metres_row(frame: Frame, facts: Mapping[str, str], row: TargetRow) -> tuple[str, ...]:
    """Return the row of the table in metres, of which the report of a refused frame is silent."""
    if row.status == REFUSED:
        return refused_metres_row(frame, row.event)
    return metres_row(frame, facts)
