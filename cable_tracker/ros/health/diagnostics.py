"""Diagnostics of the tracker node about its own health."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.sequences.messages.frame_report import make_status_array
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import DISABLED, WARMING_UP, TrackingStatus

STALE_INPUT = "STALE INPUT"
FROZEN_INPUT = "FROZEN INPUT"

WINDOW = 2.0
"""Time over which the frame rate is averaged [s]."""

MOST_ARRIVALS = 2000
"""Arrivals that are kept at most: more than any camera sends in that time."""

EDGES = tuple(2.0**power for power in range(-1, 11))
"""Edges of the histogram [ms]: 0.5, 1, 2, ... 1024. Below the first and above the last is a bin."""

LATENCIES_KEPT = 500
"""Number of frames of which median and percentiles are computed."""

PERCENTILES = (50, 95, 99)


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


LEVELS = {
    TrackingStatus.TRACKING.value: Level.OK,
    TrackingStatus.INITIALISING.value: Level.WARN,
    TrackingStatus.LOST.value: Level.ERROR,
    WARMING_UP: Level.WARN,
    STALE_INPUT: Level.STALE,
    FROZEN_INPUT: Level.STALE,
    DISABLED: Level.WARN,
}


@dataclass(slots=True)
class LatencyStatistics:
    """Times from the arrival of images to what was published about them.

    Attributes
    ----------
    counts : list of int
        Frames since the start, by the bins of `EDGES`. A time on an edge counts above it.
    latest : deque of float
        The last times [ms].
    """

    counts: list[int] = field(default_factory=lambda: [0] * (len(EDGES) + 1))
    latest: deque[float] = field(default_factory=lambda: deque(maxlen=LATENCIES_KEPT))

    def add(self, milliseconds: float) -> None:
        """Count one frame."""
        self.counts[bisect_right(EDGES, milliseconds)] += 1
        self.latest.append(milliseconds)

    def percentiles(self) -> tuple[float, float, float]:
        """Return median, 95th and 99th percentile of the last times [ms]; zeros before any."""
        if not self.latest:
            return 0.0, 0.0, 0.0
        median, high, highest = np.percentile(np.array(self.latest), PERCENTILES)
        return float(median), float(high), float(highest)

    def as_values(self) -> dict[str, str]:
        """Return the key-value pairs of the diagnostics."""
        median, high, highest = self.percentiles()
        return {
            "latency median [ms]": f"{median:.2f}",
            "latency 95th percentile [ms]": f"{high:.2f}",
            "latency 99th percentile [ms]": f"{highest:.2f}",
            "latency histogram edges [ms]": " ".join(f"{edge:g}" for edge in EDGES),
            "latency histogram counts": " ".join(map(str, self.counts)),
        }


@dataclass(slots=True)
class FrameStatistics:
    """Counts and times of the frames that came in.

    Attributes
    ----------
    tracked, refused, ignored, frozen : int
        Frames used; not usable; come in while disabled or warming up; the same as for a while.
    dropped, lost : int
        Frames that the camera sent and the node never saw; those of them that the middleware lost
        on the way. The others gave way to newer ones.
    refused_in_a_row : int
        Frames refused since the last usable one.
    last_bad_frame : str
        Reason why the last refused frame was refused.
    last_event : str
        Reason of the tracker's last restart.
    arrivals : deque of float
        Monotonic times at which the last frames came in [s].
    """

    tracked: int = 0
    refused: int = 0
    ignored: int = 0
    frozen: int = 0
    dropped: int = 0
    lost: int = 0
    refused_in_a_row: int = 0
    last_bad_frame: str = ""
    last_event: str = ""
    arrivals: deque[float] = field(default_factory=lambda: deque(maxlen=MOST_ARRIVALS))
    latency: LatencyStatistics = field(default_factory=LatencyStatistics)

    def frame_rate(self, now: float) -> float:
        """Return the rate over the last seconds [1/s]; `now` on the monotonic clock."""
        while self.arrivals and self.arrivals[0] < now - WINDOW:
            self.arrivals.popleft()
        return len(self.arrivals) / WINDOW


def frame_values(statistics: FrameStatistics, now: float) -> dict[str, str]:
    """Return the key-value pairs about the camera's frames, with units in the keys.

    Parameters
    ----------
    statistics : FrameStatistics
        Counts and times.
    now : float
        The monotonic clock [s].
    """
    return {
        "frame rate [1/s]": f"{statistics.frame_rate(now):.1f}",
        **statistics.latency.as_values(),
        "frames tracked": str(statistics.tracked),
        "frames refused": str(statistics.refused),
        "frames dropped": str(statistics.dropped),
        "frames lost on the way": str(statistics.lost),
        "frames ignored while disabled or warming up": str(statistics.ignored),
        "frames frozen": str(statistics.frozen),
        "last bad frame": statistics.last_bad_frame,
        "last restart": statistics.last_event,
    }


def cable_values(estimate: CableEstimate | None) -> dict[str, str]:
    """Return the key-value pairs about a cable's last estimate; empty values before the first."""
    return {
        "N_eff": _sample_size(estimate),
        "evidence": f"{estimate.evidence:.2f}" if estimate else "",
        "presence [%]": _presence(estimate),
        "hypotheses": _hypotheses(estimate),
    }


def target_values(estimate: TargetEstimate | None) -> dict[str, str]:
    """Return the key-value pairs about a target's last estimate; empty values before the first."""
    return {
        "status": estimate.status.value if estimate else "",
        "N_eff": _sample_size(estimate),
        "presence [%]": _presence(estimate),
        "score": f"{estimate.score:.2f}" if estimate else "",
    }


def _sample_size(estimate: CableEstimate | TargetEstimate | None) -> str:
    return f"{estimate.effective_sample_size:.1f}" if estimate else ""


def _presence(estimate: CableEstimate | TargetEstimate | None) -> str:
    if estimate is None or estimate.presence is None:
        return ""
    return f"{100 * estimate.presence:.0f}"


def _hypotheses(estimate: CableEstimate | None) -> str:
    """Return their number and their probabilities, as in `2 (91 %, 8 %)`."""
    if estimate is None or not estimate.hypotheses:
        return ""
    shares = ", ".join(f"{100 * each.probability:.0f} %" for each in estimate.hypotheses)
    return f"{len(estimate.hypotheses)} ({shares})"


def make_diagnostics(
    factory: MessageFactory, header: Message, name: str, status: str, values: dict[str, str]
) -> Message:
    """Pack the node's status as a DiagnosticArray."""
    return make_status_array(
        factory, header, f"{name}: tracking", status, values, level=LEVELS[status], hardware_id=name
    )
