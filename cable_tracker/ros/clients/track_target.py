"""Follow a target through a recording with both nodes in processes of their own, in lockstep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from cable_tracker.errors import RecordingError
from cable_tracker.offline.target_folder import TargetFolder
from cable_tracker.offline.target_table import TargetRow, metres_row, refused_metres_row
from cable_tracker.ros.clients.lockstep import track_in_lockstep, write_messages
from cable_tracker.ros.clients.message_rows import target_row
from cable_tracker.ros.clients.recorder import RecordedFrame
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import report_facts
from cable_tracker.sequences.messages.images import read_compressed_image
from cable_tracker.tracking.parameter_table import ParameterValue
from cable_tracker.tracking.status import REFUSED


def track_target_over_ros(
    frames: Iterable[Frame],
    parameters: Mapping[str, ParameterValue],
    replay: Mapping[str, ParameterValue],
    results: TargetFolder,
    *,
    with_metres: bool = False,
) -> RecordingError | None:
    """Follow a target through all frames of a recording, in metres too; see `track_in_lockstep`."""

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

    return track_in_lockstep(frames, node_topics.TARGET_TOPICS, parameters, replay, take)


def _metres_row(frame: Frame, facts: Mapping[str, str], row: TargetRow) -> tuple[str, ...]:
    """Return the row of the table in metres, of which the report of a refused frame is silent."""
    if row.status == REFUSED:
        return refused_metres_row(frame, row.event)
    return metres_row(frame, facts)
