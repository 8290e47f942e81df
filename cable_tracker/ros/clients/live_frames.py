"""Joins the messages of a tracker node about the same frame into snapshots."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from cable_tracker.errors import FrameError
from cable_tracker.gui.session.session import AnySnapshot, CableSnapshot, TargetSnapshot
from cable_tracker.ros.clients.message_rows import cable_row, target_row
from cable_tracker.ros.messages.announced_topics import announced_topics
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.messages.cable import read_particles, read_state
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import fact_number, report_facts, report_status
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.messages.target import read_polygon, read_target_particles
from cable_tracker.sequences.node_topics import NodeTopic, TrackerTopics
from cable_tracker.sequences.pictures.shown_levels import decode_shown, shown_levels
from cable_tracker.tracking.status import TrackingStatus

KEPT_BYTES = 256 << 20
"""Pictures whose answers are waited for may have so many bytes; beyond, the oldest are given up."""

KEPT_SECONDS = 10.0
"""So long an answer is waited for [s]: a tracker on a slow computer is some frames behind."""

PATIENCE = 0.25
"""Longest wait of a picture for messages for display only: particles, report, truth [s]."""

NO_REPORT = "NO REPORT"
"""Status of a frame of which neither report nor state has come."""


@dataclass(slots=True, eq=False)
class _FrameMessages:
    """Messages about one frame, and the time of the first of them."""

    since: float = field(default_factory=time.monotonic)
    image: RawImage | CompressedImage | None = None
    report: Message | None = None
    messages: dict[NodeTopic, Message] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Size of the picture [bytes]."""
        return 0 if self.image is None else self.image.data.nbytes

    def facts(self) -> dict[str, str]:
        """Return the facts of the report by name; empty without a report."""
        return {} if self.report is None else report_facts(self.report)

    def status(self) -> str:
        """Return the report's status; without a report, one that follows from the state."""
        status = "" if self.report is None else report_status(self.report)
        is_claimed = len(self.messages[node_topics.STATE].position) > 0
        return status or (TrackingStatus.TRACKING.value if is_claimed else NO_REPORT)


class LiveFrames:
    """Joins messages by their stamps; each frame is handed on once, in order.

    Parameters
    ----------
    hand_on : callable
        Gets the snapshots.
    """

    TOPICS: ClassVar[TrackerTopics] = node_topics.CABLE_TOPICS
    """Topics of the tracker."""

    def __init__(self, hand_on: Callable[[AnySnapshot], None]) -> None:
        self._hand_on = hand_on
        self._frames: OrderedDict[int, _FrameMessages] = OrderedDict()
        self._count = 0
        self._unstamped: RawImage | CompressedImage | None = None

    def take_image(self, header: Message, image: RawImage | CompressedImage) -> None:
        """Take a picture of the camera.

        The node gives a picture without a stamp the time at which it came: the newest one is shown
        with the messages that come next.
        """
        if stamp_of(header) == 0:
            self._unstamped = image
            return
        self._unstamped = None
        self._messages_of(header).image = image
        self.hand_on_due_frame()

    def take(self, topic: NodeTopic, message: Message) -> None:
        """Take a message of the tracker, or the ground truth of a simulator or a replay."""
        if topic is not self.TOPICS.report:
            self._messages_of(message.header).messages[topic] = message
        elif message.status:
            self._messages_of(message.header).report = message
        if topic is not node_topics.GROUND_TRUTH:  # No frame waits for that.
            self.hand_on_due_frame()

    def _messages_of(self, header: Message) -> _FrameMessages:
        stamp = stamp_of(header)
        if stamp not in self._frames:
            self._frames[stamp] = _FrameMessages(image=self._unstamped)
            self._drop_oldest()
        return self._frames[stamp]

    def _drop_oldest(self) -> None:
        """Drop the oldest frames beyond the limits of memory and time; the newest one stays."""
        now = time.monotonic()
        size = sum(frame.size for frame in self._frames.values())
        while len(self._frames) > 1:
            oldest = next(iter(self._frames.values()))
            if size <= KEPT_BYTES and now - oldest.since <= KEPT_SECONDS:
                return
            size -= oldest.size
            self._frames.popitem(last=False)

    def hand_on_due_frame(self) -> None:
        """Hand on the newest frame that is ready; those before it are dropped."""
        now = time.monotonic()
        ready = [stamp for stamp, frame in self._frames.items() if self._is_due(frame, now)]
        if not ready:
            return
        # By order of arrival: a bag that starts again has earlier stamps, and is shown.
        frame = self._frames[ready[-1]]
        for stamp in tuple(self._frames):
            del self._frames[stamp]
            if stamp == ready[-1]:
                break
        try:
            snapshot = self._snapshot(self._count + 1, ready[-1], frame)
        except FrameError:
            # The tracker has refused the same image, and says so in diagnostics.
            return
        self._count += 1
        self._hand_on(snapshot)

    def _is_due(self, frame: _FrameMessages, now: float) -> bool:
        """Tell whether a picture can be shown, and has waited long enough for the rest."""
        if frame.image is None or node_topics.STATE not in frame.messages:
            return False
        return self._is_complete(frame) or now - frame.since > PATIENCE

    def _is_complete(self, frame: _FrameMessages) -> bool:
        """Tell whether the report has come, and all that it announces.

        Ground truth comes with the image, if at all.
        """
        if frame.report is None:
            return False
        shown = {node_topics.PARTICLES, node_topics.CONTOUR}
        return (
            shown.intersection(announced_topics(self.TOPICS, frame.report)) <= frame.messages.keys()
        )

    def _snapshot(self, number: int, stamp: int, frame: _FrameMessages) -> AnySnapshot:
        assert frame.image is not None
        messages = frame.messages
        state, particles = messages[node_topics.STATE], messages.get(node_topics.PARTICLES)
        truth = messages.get(node_topics.GROUND_TRUTH)
        cloud = read_particles(particles) if particles is not None else None
        return CableSnapshot(
            number=number,
            frame=None,
            image=shown_levels(decode_grey(frame.image)),
            row=cable_row(number, stamp, frame.status(), state, frame.facts()),
            cloud=cloud if cloud is not None and len(cloud) else None,
            truth=read_state(truth) if truth is not None else None,
        )


class LiveTargetFrames(LiveFrames):
    """Frames of a target tracker put together; of several targets the first."""

    TOPICS = node_topics.TARGET_TOPICS

    def _snapshot(self, number: int, stamp: int, frame: _FrameMessages) -> AnySnapshot:
        assert frame.image is not None
        facts, messages = frame.facts(), frame.messages
        row = target_row(number, stamp, frame.status(), messages[node_topics.STATE], facts)
        particles, contour = messages.get(node_topics.PARTICLES), messages.get(node_topics.CONTOUR)
        has_outline = contour is not None and row.claim is not None
        return TargetSnapshot(
            number=number,
            frame=None,
            image=decode_shown(frame.image),
            row=row,
            outline=read_polygon(contour) if has_outline else np.empty((0, 2)),
            cloud=read_target_particles(particles) if particles is not None else None,
            score=fact_number(facts, "score"),
        )
