"""How long frames take: a histogram since the start, and figures of the last frames."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from dataclasses import dataclass, field

import numpy as np

EDGES = tuple(2.0**power for power in range(-1, 11))
"""Edges of the histogram [ms]: 0.5, 1, 2, ... 1024. Below the first and above the last is a bin."""

LATENCIES_KEPT = 500
"""Number of frames of which median and percentiles are computed."""

PERCENTILES = (50, 95, 99)


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
