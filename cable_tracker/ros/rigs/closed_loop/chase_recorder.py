"""Listens to a chase and puts together what belongs to the same frame."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import islice
from typing import Any

from rclpy.context import Context

from cable_tracker.evaluation.targets.chase_table import ChaseRow
from cable_tracker.ros.messages.announced_topics import target_topics
from cable_tracker.ros.rigs.closed_loop.run_recorder import RunRecorder, listen_to_the_end
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import decode_bgr
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.messages.images import read_compressed_image
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.visualisation.video import VideoWriter


class ChaseRecorder(RunRecorder):
    """Keeps what is true and what is told of every frame.

    Parameters
    ----------
    context : Context
        rclpy context of this process.
    namespace : str
        Namespace of the nodes.
    """

    def __init__(self, context: Context, namespace: str) -> None:
        super().__init__("chase_recorder", context, namespace)
        self.truths: dict[int, Any] = {}
        self.states: dict[int, Any] = {}
        self.places: dict[int, Any] = {}
        self.reports: dict[int, Any] = {}
        self.overlays: list[Any] = []
        self._open: list[int] = []
        self._recorded = 0
        for topic, kept in (
            (node_topics.TRUE_TARGET, self.truths),
            (node_topics.STATE, self.states),
            (node_topics.RELATIVE_POSE, self.places),
            (node_topics.TARGET_REPORT, self.reports),
        ):
            self._record(topic, kept.__setitem__)
        self._record(node_topics.TARGET_OVERLAY, lambda _, each: self.overlays.append(each))

    def is_ready(self) -> bool:
        """Tell whether the tracker is warm, and knows both the follower and us."""
        told = self._told
        both = told.has_readers(2, node_topics.STATE, node_topics.RELATIVE_POSE)
        return (
            told.is_warm
            and both
            and told.has_readers(1, node_topics.TARGET_REPORT, node_topics.TARGET_OVERLAY)
        )

    def is_answered(self) -> bool:
        """Tell whether all that is told about the frames that have come has come, too."""
        return all(self._is_answered(stamp) for stamp in self.truths)

    def release(self) -> None:
        """Let the simulator go on when all about the frames sent has been recorded."""
        known = self._recorded + len(self._open)
        self._open += islice(self.truths, known, None)
        still_open = [stamp for stamp in self._open if not self._is_answered(stamp)]
        self._recorded += len(self._open) - len(still_open)
        self._open = still_open
        self._commands.release(self._recorded)

    def _is_answered(self, stamp: int) -> bool:
        if stamp not in self.states or stamp not in self.reports:
            return False
        announced = target_topics(self.reports[stamp])
        return stamp in self.places or node_topics.RELATIVE_POSE not in announced

    def rows(self) -> list[ChaseRow]:
        """Return the table of the run."""
        stamps = sorted(self.truths.keys() & self.states.keys())
        return [self._row(stamp, stamps[0]) for stamp in stamps]

    def _row(self, stamp: int, first: int) -> ChaseRow:
        truth, told = self.truths[stamp].pose, self.places.get(stamp)
        true = _vector(truth.pose.position)
        distance = math.hypot(*true)
        known, sigma, off = math.nan, math.nan, math.nan
        if told is not None:
            place = _vector(told.pose.pose.position)
            known = math.hypot(*place)
            off = math.dist(place, true)
            covariance = told.pose.covariance
            along = [value / known for value in place]
            variance = sum(
                along[i] * along[j] * float(covariance[6 * i + j])
                for i in range(3)
                for j in range(3)
            )
            sigma = math.sqrt(max(variance, 0.0))
        return ChaseRow(
            time=(stamp - first) / NANOSECONDS,
            distance=distance,
            is_visible=float(truth.covariance[0]) == 0.0,
            is_claimed=bool(self.states[stamp].position),
            range=known,
            range_sigma=sigma,
            off=off,
        )


def _vector(point: Any) -> tuple[float, float, float]:  # noqa: ANN401
    return float(point.x), float(point.y), float(point.z)


def record_to_the_end(
    recorder: ChaseRecorder,
    is_running: Callable[[], bool],
    turn: Callable[[], str],
    video: VideoWriter,
    advance: Callable[[int], None],
) -> None:
    """Listen until the simulator has ended, all of its frames have come, and each is answered.

    Parameters
    ----------
    recorder : ChaseRecorder
        Listens.
    is_running : callable
        Tells whether the simulator is.
    turn : callable
        Runs a callback of the recorder; returns what has gone wrong, or nothing.
    video : VideoWriter
        Takes the overlays.
    advance : callable
        Called with the number of frames that have come since the last call.

    Raises
    ------
    RosError
        Something has gone wrong, or nothing comes.
    """
    seen = 0

    def take() -> bool:
        nonlocal seen
        recorder.release()
        overlays, recorder.overlays = recorder.overlays, []
        for message in overlays:
            picture = decode_bgr(read_compressed_image(message))
            video.add(picture, stamp_of(message.header))
        fresh, seen = len(recorder.states) - seen, len(recorder.states)
        if fresh:
            advance(fresh)
        return bool(fresh)

    listen_to_the_end(recorder, is_running, turn, take, lambda _: recorder.is_answered())
