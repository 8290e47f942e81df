"""Observations of a soak test, and the promises that were broken."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from cable_tracker.arrays import FloatArray

LARGEST_GROWTH = 5.0
"""Largest growth of a tracker's memory from its warm-up to its end [MB]."""

WARM_UP = 2000
"""Frames after which a tracker's memory is expected to have settled."""

FEWEST_SAMPLES = 20
"""A tracker that was killed before it gave as many samples says nothing about growth."""

MOST_BREACHES = 100
"""Number of broken promises that are told one by one."""


@dataclass(frozen=True, slots=True)
class MemorySample:
    """Memory of a tracker process.

    Attributes
    ----------
    minutes : float
        Time since the beginning of the soak test [min].
    frames : int
        Number of answers of this process.
    process : int
        Number of the process, from 1; each restart is a new one.
    private, shared : float
        Resident memory of its own, and of the middleware's shared ring buffers [MB].
    faults : str
        Faults since the sample before, separated by semicolons: what a step came with.
    """

    minutes: float
    frames: int
    process: int
    private: float
    shared: float
    faults: str = ""


def read_memory(pid: int) -> tuple[float, float]:
    """Return the private and the shared resident memory of a process [MB]; Linux only.

    Raises
    ------
    OSError
        There is no such process.
    """
    sizes = {"RssAnon": 0.0, "RssFile": 0.0, "RssShmem": 0.0}
    for line in Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines():
        name, _, value = line.partition(":")
        if name in sizes:
            sizes[name] = int(value.split()[0]) / 1024
    return sizes["RssAnon"] + sizes["RssFile"], sizes["RssShmem"]


@dataclass(slots=True)
class SoakRecord:
    """Counts and times of a soak test.

    Attributes
    ----------
    sent, answered : int
        Frames.
    faults, recoveries : Counter
        By class of faults: how often it was injected, and how often a good frame was answered as
        promised afterwards.
    messages : Counter
        Messages of the tracker whose numbers were looked at, by topic.
    breaches : list of str
        Broken promises.
    memory : list of MemorySample
        Over time.
    latencies : list of (float, float)
        Minutes since the beginning and time to the answer [ms], of frames in lockstep.
    """

    sent: int = 0
    answered: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    recoveries: Counter[str] = field(default_factory=Counter)
    messages: Counter[str] = field(default_factory=Counter)
    breaches: list[str] = field(default_factory=list)
    memory: list[MemorySample] = field(default_factory=list)
    latencies: list[tuple[float, float]] = field(default_factory=list)
    _recent: list[str] = field(default_factory=list)

    def inject(self, fault: str) -> None:
        """Count a fault."""
        self.faults[fault] += 1
        self._recent.append(fault)

    def add_memory(self, sample: MemorySample) -> None:
        """Keep a sample, with the faults since the one before."""
        self.memory.append(replace(sample, faults="; ".join(self._recent)))
        self._recent.clear()

    def broken(self, promise: str) -> None:
        """Note a broken promise."""
        if len(self.breaches) < MOST_BREACHES:
            self.breaches.append(promise)

    def growth(self) -> float:
        """Return the largest growth of the private memory of one process after its warm-up [MB].

        Medians of the first and the last tenth of its samples are compared.
        """
        largest = 0.0
        for process in {sample.process for sample in self.memory}:
            sizes = [
                sample.private
                for sample in self.memory
                if sample.process == process and sample.frames >= WARM_UP
            ]
            if len(sizes) >= FEWEST_SAMPLES:
                tenth = max(len(sizes) // 10, 1)
                growth = float(np.median(sizes[-tenth:]) - np.median(sizes[:tenth]))
                largest = max(largest, growth)
        return largest

    def check_growth(self) -> None:
        """Record a breach if memory has grown by more than is promised."""
        growth = self.growth()
        if growth > LARGEST_GROWTH:
            self.broken(f"the memory of a tracker grew by {growth:.1f} MB after its warm-up")

    def latency_windows(self) -> list[dict[str, float]]:
        """Return frames in lockstep, and median, 99th percentile and maximum of latency [ms].

        By the minute.
        """
        table: FloatArray = np.array(self.latencies).reshape(-1, 2)
        numbers = table[:, 0].astype(int)
        return [
            _window(float(number), table[numbers == number, 1]) for number in np.unique(numbers)
        ]

    def as_json(self, settings: dict[str, object]) -> str:
        """Return everything as JSON."""
        content = {
            "settings": settings,
            "frames_sent": self.sent,
            "frames_answered": self.answered,
            "faults": dict(sorted(self.faults.items())),
            "recoveries": dict(sorted(self.recoveries.items())),
            "messages_checked": dict(sorted(self.messages.items())),
            "broken_promises": self.breaches,
            "memory_growth_mb": round(self.growth(), 3),
            "latency": [_rounded(window) for window in self.latency_windows()],
            "memory": [_rounded(asdict(sample)) for sample in self.memory],
        }
        return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _rounded(values: Mapping[str, float | str]) -> dict[str, float | str]:
    return {
        key: round(value, 3) if isinstance(value, float) else value for key, value in values.items()
    }


def _window(minutes: float, latencies: FloatArray) -> dict[str, float]:
    return {
        "minutes": minutes,
        "frames": len(latencies),
        "median": float(np.median(latencies)),
        "percentile_99": float(np.percentile(latencies, 99)),
        "longest": float(latencies.max()),
    }
