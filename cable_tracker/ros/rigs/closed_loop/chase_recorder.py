"""Recorder of a chase: the messages about each frame, and the rows of its table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from rclpy.context import Context

from cable_tracker.arrays import Image
from cable_tracker.evaluation.targets.chase_table import ChaseRow
from cable_tracker.ros.messages.announced_topics import announced_topics
from cable_tracker.ros.rigs.closed_loop.run_recorder import FrameMessages, RunRecorder
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.messages.images import read_compressed_image
from cable_tracker.stamps import NANOSECONDS


@dataclass(frozen=True, slots=True, eq=False)
class ChaseVideoFrame:
    """Picture of a frame for the video.

    Attributes
    ----------
    stamp : int
        Time of the frame [ns].
    picture : Image or None
        The tracker's overlay, BGR, uint8, shape (H, W, 3); None of a frame that it refused.
    """

    stamp: int
    picture: Image | None


class ChaseRecorder(RunRecorder[ChaseVideoFrame]):
    """Keeps the truth and the tracker's results of every frame.

    Parameters
    ----------
    context : Context
        rclpy context of this process.
    namespace : str
        Namespace of the nodes.
    """

    RECORDED = (
        node_topics.TRUE_TARGET,
        node_topics.STATE,
        node_topics.RELATIVE_POSE,
        node_topics.TARGET_REPORT,
        node_topics.TARGET_OVERLAY,
    )
    PICTURE = node_topics.TARGET_OVERLAY
    SENT = frozenset({node_topics.TRUE_TARGET})

    def __init__(self, context: Context, namespace: str) -> None:
        super().__init__("chase_recorder", context, namespace)

    def is_ready(self) -> bool:
        """Tell whether the tracker is warm, and knows both the follower and us."""
        health = self._health
        both = health.has_readers(2, node_topics.STATE, node_topics.RELATIVE_POSE)
        return (
            health.is_warm()
            and both
            and health.has_readers(1, node_topics.TARGET_REPORT, node_topics.TARGET_OVERLAY)
        )

    def _is_complete(self, frame: FrameMessages) -> bool:
        report = frame.get(node_topics.TARGET_REPORT)
        if node_topics.TRUE_TARGET not in frame or report is None:
            return False
        announced = announced_topics(node_topics.TARGET_TOPICS, report)
        return all(topic in frame for topic in announced if topic in self.RECORDED)

    def _video_frame(self, stamp: int, frame: FrameMessages) -> ChaseVideoFrame:
        overlay = frame.get(node_topics.TARGET_OVERLAY)
        known = overlay is not None
        return ChaseVideoFrame(stamp, decode_bgr(read_compressed_image(overlay)) if known else None)

    def rows(self) -> list[ChaseRow]:
        """Return the table of the run."""
        needed = {node_topics.TRUE_TARGET, node_topics.STATE}
        stamps = sorted(s for s, frame in self._frames.items() if frame.keys() >= needed)
        return [self._row(stamp, stamps[0]) for stamp in stamps]

    def _row(self, stamp: int, first: int) -> ChaseRow:
        frame = self._frames[stamp]
        truth, estimate = frame[node_topics.TRUE_TARGET].pose, frame.get(node_topics.RELATIVE_POSE)
        true = _vector(truth.pose.position)
        distance = math.hypot(*true)
        known, sigma, off = math.nan, math.nan, math.nan
        if estimate is not None:
            place = _vector(estimate.pose.pose.position)
            known = math.hypot(*place)
            off = math.dist(place, true)
            along = np.array(place) / known
            covariance = np.reshape(estimate.pose.covariance, (6, 6))[:3, :3]
            sigma = math.sqrt(max(float(along @ covariance @ along), 0.0))
        return ChaseRow(
            time=(stamp - first) / NANOSECONDS,
            distance=distance,
            is_visible=float(truth.covariance[0]) == 0.0,
            is_claimed=bool(frame[node_topics.STATE].position),
            range=known,
            range_sigma=sigma,
            off=off,
        )


def _vector(point: Any) -> tuple[float, float, float]:  # noqa: ANN401
    return float(point.x), float(point.y), float(point.z)
