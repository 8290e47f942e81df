"""A tracker process under a soak test: fed, watched, and started anew where it has died."""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.context import Context

from cable_tracker.errors import RosError
from cable_tracker.ros.process.child_process import START_TIMEOUT, WARM_UP_TIMEOUT, NodeProcess
from cable_tracker.ros.process.environment import local_environment
from cable_tracker.ros.rigs.soak.camera import SoakCamera
from cable_tracker.ros.rigs.soak.faults import CHANGES, COMPRESSED_CHANGES, Fault
from cable_tracker.ros.rigs.soak.frames import SoakFrames
from cable_tracker.ros.rigs.soak.record import MemorySample, SoakRecord, read_memory
from cable_tracker.ros.rigs.soak.soaked_node import SOAKED
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.factory import Message

PATIENCE = 10.0
"""Longest wait for an event [s]; what has not come by then will not come."""

SETTLING_FRAMES = 4
"""Number of frames that are sent in a row until one is answered; not all of them are lost on the
way."""

LONGEST_ANSWER = 1.0
"""A frame whose answer takes longer counts as a hang [s]."""

COMPRESSED_SHARE = 0.3
"""Share of tracker starts with `image_transport` = compressed."""

VIEWED_FRAMES = 10
"""While pictures are drawn."""

MEMORY_PERIOD = 2.0
"""Time between two looks at the tracker's memory [s]."""


@dataclass(frozen=True, slots=True)
class SoakSettings:
    """Settings of a soak test.

    Attributes
    ----------
    minutes : float
        Length of the test [min].
    seed : int
        Seed of the faults and their times.
    fault_share : float
        Faults per frame in lockstep, 0 to 1.
    frames : int
        Number of answered frames at which the test ends earlier; 0 for no such end.
    preset : str
        Preset of the tracker.
    particles : int
        Number of particles of the tracker.
    node : str
        Tracker that is soaked: a key of `SOAKED`.
    """

    minutes: float
    seed: int
    fault_share: float
    frames: int
    preset: str
    particles: int
    node: str


class SoakedProcess(NodeProcess):
    """A node that can be killed, stopped and continued."""

    def send(self, number: signal.Signals) -> None:
        """Send it a signal."""
        self._process.send_signal(number)

    def kill(self) -> None:
        """End it as a power cut would."""
        self._process.kill()
        self._process.wait()


class SoakRig:
    """Feeds a tracker process, and notes what it answers.

    Parameters
    ----------
    frames : sequence of Frame
        8-bit grey or colour, all of one size.
    settings : SoakSettings
        Settings of the soak test.
    context : Context
        rclpy context of this process.

    Attributes
    ----------
    settings : SoakSettings
        Settings of the soak test.
    soaked : SoakedNode
        The kind of tracker.
    rng : numpy.random.Generator
        Draws the faults.
    record : SoakRecord
        Record of events, latencies and memory so far.
    frames : SoakFrames
        Generator of the frames that are published.
    camera : SoakCamera
        Sends it, and hears the answers.
    folder : Path
        For files, until the rig is closed.
    """

    def __init__(self, frames: Sequence[Frame], settings: SoakSettings, context: Context) -> None:
        self.settings = settings
        self.soaked = SOAKED[settings.node]
        self.rng = np.random.default_rng(settings.seed)
        self.frames = SoakFrames(frames)
        self.record = SoakRecord()
        self._namespace = f"/soak_{os.getpid()}"
        self.camera = SoakCamera(context, self._namespace, self.record, self.soaked)
        self._temporary = tempfile.TemporaryDirectory(prefix="cable_tracker_soak_")
        self.folder = Path(self._temporary.name)
        self._tracker: SoakedProcess | None = None
        self._processes = 0
        self._answers_before = 0
        self._began = time.monotonic()
        self._next_memory = 0.0

    def close(self) -> None:
        """Stop the tracker."""
        if self._tracker is not None:
            self._tracker.__exit__(None, None, None)
        self.camera.close()
        self._temporary.cleanup()

    @property
    def tracker(self) -> SoakedProcess:
        """The tracker's process, once it has been started."""
        assert self._tracker is not None
        return self._tracker

    @property
    def changes(self) -> Mapping[Fault, Callable[[Message, np.random.Generator], None]]:
        """How frames of the present kind are spoilt."""
        return COMPRESSED_CHANGES if self.frames.compressed else CHANGES

    def minutes(self) -> float:
        """Return the time since the beginning of the test."""
        return (time.monotonic() - self._began) / 60.0

    def share(self) -> float:
        """Return the elapsed share of the test's duration, 0 to 1 or more."""
        share = self.minutes() / self.settings.minutes
        if self.settings.frames:
            share = max(share, self.record.answered / self.settings.frames)
        return share

    def wait_until(self, condition: Callable[[], bool]) -> bool:
        """Wait for what should come; tell whether it has."""
        return self.camera.spin_until(condition, PATIENCE)

    def call(self, kind: Any, service: str, request: Message) -> Message | None:  # noqa: ANN401
        """Call a service of the tracker; None: it does not answer."""
        return self.camera.call(kind, f"{self.soaked.kind.node}/{service}", request, PATIENCE)

    def send_and_wait(self, message: Message) -> bool:
        """Send a frame and wait for its answer; tell whether it came as promised."""
        answers = self.camera.answers
        began = time.monotonic()
        self.camera.send(message)
        answered = self.wait_until(lambda: self.camera.answers > answers)
        seconds = time.monotonic() - began
        if answered:
            self.record.latencies.append((self.minutes(), seconds * 1e3))
            if seconds > LONGEST_ANSWER:
                self.record.broken(f"an answer took {seconds:.2f} s at {self.minutes():.1f} min")
        return answered

    def good_frame(self) -> bool:
        """Send the next frame; tell whether it was answered as promised."""
        return self.send_and_wait(self.frames.next_message())

    def bad_message(self, fault: Fault) -> Message:
        """Return the next frame, spoilt."""
        message = self.frames.next_message()
        self.changes[fault](message, self.rng)
        return message

    def view(self) -> None:
        """Look at the tracker's pictures for some frames."""
        self.camera.watch_pictures()
        for _ in range(VIEWED_FRAMES):
            self.good_frame()
        self.camera.leave_pictures()

    def settle(self) -> bool:
        """Let the tracker catch up, so that the next answer is that of the next frame.

        Tells whether it did.
        """
        for _ in range(SETTLING_FRAMES):
            if self.camera.spin_until(self._is_last_answered, PATIENCE / SETTLING_FRAMES):
                return True
            # The last of many may be lost on the way, as frames of a camera are; not several.
            self.camera.send(self.frames.next_message())
        self.restart_tracker("the last of many frames was not answered")
        return False

    def _is_last_answered(self) -> bool:
        return self.camera.last_stamp == self.frames.stamp

    def restart_tracker(self, promise: str) -> None:
        """Note a broken promise and go on, with a new tracker if this one is gone."""
        cause = "" if self._running else f"; the tracker has died: {self.last_line()}"
        self.record.broken(f"{promise}{cause}")
        if self._tracker is not None:
            self._tracker.kill()
        self.start_tracker()

    @property
    def _running(self) -> bool:
        return self._tracker is not None and self._tracker.running

    def last_line(self) -> str:
        """Return the last line that the tracker wrote."""
        return "" if self._tracker is None else self._tracker.last_line()

    def start_tracker(self) -> None:
        """Start a tracker in the place of the one before, and wait until it answers.

        Raises
        ------
        RosError
            It does not start.
        """
        if self._tracker is not None:
            self._tracker.__exit__(None, None, None)
        self.frames.compressed = bool(self.rng.random() < COMPRESSED_SHARE)
        parameters = {
            "image_reliability": "reliable",
            "image_transport": "compressed" if self.frames.compressed else "raw",
            "input_timeout": "0.5",
            "preset": self.settings.preset,
            "particle_count": str(self.settings.particles),
            **self.soaked.start,
        }
        process = self._process(
            self.soaked.kind.node, parameters, "-r", "/diagnostics:=diagnostics"
        )
        process.__enter__()
        self._tracker = process
        self._processes += 1
        self._answers_before = self.camera.answers
        self._await_first_answer()
        # What draws pictures is loaded when first asked for, and the network keeps room for the
        # largest picture so far: twice as high as wide, as a damaged JPEG may be. No growth either.
        self.view()
        self.send_and_wait(self.frames.tall_message())

    def replay(self, *, loop: bool) -> SoakedProcess:
        """Return the process of a replay of a few frames, which is not started yet."""
        bag = self.frames.short_bag(self.folder)
        parameters = {"source": str(bag), "lockstep": "true", "loop": str(loop).lower()}
        return self._process("replay", parameters)

    def _process(
        self, name: str, parameters: Mapping[str, object], *arguments: str
    ) -> SoakedProcess:
        given = [word for key, value in parameters.items() for word in ("-p", f"{key}:={value}")]
        remapped = ("-r", f"__ns:={self._namespace}", *arguments)
        return SoakedProcess(name, [*remapped, *given], local_environment())

    def _await_first_answer(self) -> None:
        """Send frames until one is answered: processes take a while to find each other."""
        deadline = time.monotonic() + START_TIMEOUT + WARM_UP_TIMEOUT
        answers = self.camera.answers
        while self.camera.answers == answers:
            if time.monotonic() > deadline or not self._running:
                raise RosError(f"the tracker does not start: {self.last_line()}")
            self.camera.send(self.frames.next_message())
            self.camera.spin_until(lambda: self.camera.answers > answers, 0.2)
        self.settle()

    def sample_memory(self) -> None:
        """Note now and then how much memory the tracker takes."""
        now = time.monotonic()
        if now < self._next_memory or not self._running:
            return
        self._next_memory = now + MEMORY_PERIOD
        private, shared = read_memory(self.tracker.pid)
        frames = self.camera.answers - self._answers_before
        sample = MemorySample(self.minutes(), frames, self._processes, private, shared)
        self.record.add_memory(sample)
