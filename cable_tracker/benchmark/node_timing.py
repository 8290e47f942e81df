"""Timing of a node in a process of its own."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.benchmark.statistics import Percentiles


@dataclass(frozen=True, slots=True)
class NodeTiming:
    """Latency from publishing an image to the arrival of the answer, in one other process.

    Attributes
    ----------
    name : str
        The preset.
    size : (int, int)
        Width and height of the frames, mono8 [px].
    particles : int
        Number of particles.
    rate : float
        Frames per second.
    state, centreline : Percentiles or None
        Latency of the tracker's answers [ms]; None if none came.
    echo : Percentiles
        The same of a node that answers at once: DDS' own way there and back, and rclpy's [ms].
    in_process : Percentiles
        Time on the clock that the same tracker takes for the same frames in our own process, at the
        same pace, without any node [ms].
    unanswered : int
        Frames without a `state`.
    cpu_share, echo_cpu_share : float
        Share of one processor that the tracker and the echo need: time per answered frame, times
        the rate. Above 1, the rate is too high.
    """

    name: str
    size: tuple[int, int]
    particles: int
    rate: float
    state: Percentiles | None
    centreline: Percentiles | None
    echo: Percentiles
    in_process: Percentiles
    unanswered: int
    cpu_share: float
    echo_cpu_share: float

    def added_latency(self) -> Percentiles | None:
        """Return the latency that the node adds to the tracker's own time [ms]."""
        if self.state is None:
            return None
        return Percentiles(
            self.state.median - self.in_process.median,
            self.state.p95 - self.in_process.p95,
            self.state.p99 - self.in_process.p99,
            self.state.count,
        )
