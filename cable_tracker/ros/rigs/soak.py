"""A soak test: a tracker process is fed frames for a long time while faults are injected."""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import SetBool, Trigger

from cable_tracker.errors import ParameterError, RosError
from cable_tracker.ros.health.diagnostics import STALE_INPUT
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.ros.process.child_process import START_TIMEOUT, WARM_UP_TIMEOUT, NodeProcess
from cable_tracker.ros.process.environment import local_environment, use_local_environment
from cable_tracker.ros.rigs.soak_camera import SoakCamera
from cable_tracker.ros.rigs.soak_faults import (
    CHANGES,
    COMPRESSED_CHANGES,
    REFUSED,
    Fault,
    draw_fault,
)
from cable_tracker.ros.rigs.soak_record import MemorySample, SoakRecord, read_memory
from cable_tracker.ros.rigs.soaked_node import SOAKED
from cable_tracker.sequences.convert import ImageFormat, in_format, write_bag
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.sequences.messages import (
    Message,
    make_compressed_image,
    make_header,
    make_image,
)
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import ParameterSpec, ParameterValue

FIRST_STAMP = 1_700_000_000 * NANOSECONDS
STEP = 40_000_000
"""Time between two frames [ns]."""

LONG_AGO = 100 * NANOSECONDS
FAR_AHEAD = 3600 * NANOSECONDS
END_OF_TIME = (2**31 - 1) * NANOSECONDS

REPLAY_PATIENCE = 300.0
"""For a replay, which starts anew and gives up by itself where it is not answered [s].

On a loaded machine its start alone may take a minute.
"""

PATIENCE = 10.0
"""What has not come after this long will not come [s]."""

SETTLING_FRAMES = 4
"""So many frames in a row are not lost on the way."""

LONGEST_ANSWER = 1.0
"""A frame whose answer takes longer counts as a hang [s]."""

BURST = 50
"""Frames sent at once to overload the tracker."""

FULL_RATE_SHARE = 0.3
FULL_RATE_FRAMES = 100
FULL_RATE_PAUSE = 0.002
REPLAYED_FRAMES = 12
COMPRESSED_SHARE = 0.3
STORM = 8
"""Sets of parameters in one storm."""

MOST_PARTICLES = 1000
WIDEST_IMAGE = 640
MEMORY_PERIOD = 2.0
"""Time between two looks at the tracker's memory [s]."""

MOST = {
    "particle_count": MOST_PARTICLES,
    "working_width": WIDEST_IMAGE,
    "ancestor_count": 512,
}
LEAST = {"sample_spacing": 5.0}
"""A storm must not make frames slower than the promise of an answer allows: a thousand particles
with scan lines at every pixel are legal, and take long."""


@dataclass(frozen=True, slots=True)
class SoakSettings:
    """What is asked of a soak test.

    Attributes
    ----------
    minutes : float
        How long it lasts.
    seed : int
        Draws the faults and when they come.
    fault_share : float
        Faults per frame in lockstep, 0 to 1.
    frames : int
        Ends earlier when so many have been answered; 0 for no such end.
    preset : str
        Of the tracker.
    particles : int
        Of the tracker.
    node : str
        Which tracker: a key of `SOAKED`.
    """

    minutes: float
    seed: int
    fault_share: float = 0.02
    frames: int = 0
    preset: str = "default"
    particles: int = 500
    node: str = "tracker"


class _TrackerProcess(NodeProcess):
    """A node that can be killed, stopped and continued."""

    def send(self, number: signal.Signals) -> None:
        self._process.send_signal(number)

    def kill(self) -> None:
        """End it as a power cut would."""
        self._process.kill()
        self._process.wait()


def run_soak(
    frames: Sequence[Frame],
    settings: SoakSettings,
    advance: Callable[[float], None] = lambda _share: None,
) -> SoakRecord:
    """Feed frames to a tracker process over and over, and inject faults.

    Parameters
    ----------
    frames : sequence of Frame
        8-bit grey or colour, all of one size.
    settings : SoakSettings
        How long, and the seed. The same seed draws the same faults; when they hit depends on the
        machine.
    advance : callable
        Told now and then which share of the time has passed.

    Raises
    ------
    RosError
        The tracker does not start at all.
    """
    use_local_environment()
    with ExitStack() as stack:
        context = Context()
        rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
        stack.callback(rclpy.try_shutdown, context=context)
        soak = _Soak(frames, settings, context)
        stack.callback(soak.close)
        soak.run(advance)
    soak.record.check_growth()
    return soak.record


class _Soak:
    """One soak test on its way."""

    def __init__(self, frames: Sequence[Frame], settings: SoakSettings, context: Context) -> None:
        self._settings = settings
        self._soaked = SOAKED[settings.node]
        self._rng = np.random.default_rng(settings.seed)
        self._factory = RclpyMessages()
        self._frames = frames
        self._jpegs = [in_format(frame, ImageFormat.JPEG) for frame in frames]
        self._namespace = f"/soak_{os.getpid()}"
        self.record = SoakRecord()
        self._camera = SoakCamera(context, self._namespace, self.record, self._soaked)
        self._folder = tempfile.TemporaryDirectory(prefix="cable_tracker_soak_")
        self._tracker: _TrackerProcess | None = None
        self._compressed = False
        self._processes = 0
        self._answers_before = 0
        self._number = 0
        self._stamp = FIRST_STAMP
        self._began = time.monotonic()
        self._next_memory = 0.0

    def close(self) -> None:
        """Stop the tracker."""
        if self._tracker is not None:
            self._tracker.__exit__(None, None, None)
        self._camera.close()
        self._folder.cleanup()

    def run(self, advance: Callable[[float], None]) -> None:
        """Go on until the time is over or the frames are enough."""
        self._start_tracker()
        while (share := self._share()) < 1.0:
            advance(share)
            if self._rng.random() < FULL_RATE_SHARE:
                self._full_rate()
            self._lockstep()

    def _minutes(self) -> float:
        return (time.monotonic() - self._began) / 60.0

    def _share(self) -> float:
        share = self._minutes() / self._settings.minutes
        if self._settings.frames:
            share = max(share, self.record.answered / self._settings.frames)
        return share

    def _lockstep(self) -> None:
        for _ in range(FULL_RATE_FRAMES):
            if self._rng.random() < self._settings.fault_share:
                fault = draw_fault(self._rng, self._changes.keys() | _ACTIONS.keys())
                self.record.faults[fault.value] += 1
                self._inject(fault)
                if self._good_frame():
                    self.record.recoveries[fault.value] += 1
                else:
                    self._revive(f"no good frame was answered after: {fault.value}")
            elif not self._good_frame():
                self._revive("a frame was not answered")
            self._look_at_memory()

    def _full_rate(self) -> None:
        """Send without waiting for answers, as a camera does, bad frames among the good ones."""
        faults = []
        for _ in range(FULL_RATE_FRAMES):
            if self._rng.random() < self._settings.fault_share:
                faults.append(draw_fault(self._rng, self._changes))
                self._camera.send(self._bad_message(faults[-1]))
            self._camera.send(self._next_message())
            self._camera.pass_time(FULL_RATE_PAUSE)
        recovered = self._settle()
        for fault in faults:
            self.record.faults[fault.value] += 1
            self.record.recoveries[fault.value] += recovered

    def _settle(self) -> bool:
        """Let the tracker catch up, so that the next answer is that of the next frame.

        Tells whether it did.
        """
        for _ in range(SETTLING_FRAMES):
            if self._camera.spin_until(self._is_last_answered, PATIENCE / SETTLING_FRAMES):
                return True
            # The last of many may be lost on the way, as frames of a camera are; not several.
            self._camera.send(self._next_message())
        self._revive("the last of many frames was not answered")
        return False

    def _is_last_answered(self) -> bool:
        return self._camera.last_stamp == self._stamp

    def _next_message(self) -> Message:
        self._number += 1
        self._stamp += STEP
        return self._message(self._stamp)

    def _message(self, stamp: int) -> Message:
        header = make_header(self._factory, stamp, "camera")
        frames = self._jpegs if self._compressed else self._frames
        image = frames[self._number % len(frames)].image
        if isinstance(image, RawImage):
            return make_image(self._factory, image, header)
        return make_compressed_image(self._factory, image, header)

    def _exchange(self, message: Message) -> bool:
        """Send a frame and wait for its answer; tell whether it came as promised."""
        answers = self._camera.answers
        began = time.monotonic()
        self._camera.send(message)
        answered = self._camera.spin_until(lambda: self._camera.answers > answers, PATIENCE)
        seconds = time.monotonic() - began
        if answered:
            self.record.latencies.append((self._minutes(), seconds * 1e3))
            if seconds > LONGEST_ANSWER:
                self.record.broken(f"an answer took {seconds:.2f} s at {self._minutes():.1f} min")
        return answered

    def _good_frame(self) -> bool:
        return self._exchange(self._next_message())

    def _revive(self, promise: str) -> None:
        """Note a broken promise and go on, with a new tracker if this one is gone."""
        words = "" if self._running else f"; the tracker has died: {self._last_words()}"
        self.record.broken(f"{promise}{words}")
        if self._tracker is not None:
            self._tracker.kill()
        self._start_tracker()

    @property
    def _running(self) -> bool:
        return self._tracker is not None and self._tracker.running

    def _last_words(self) -> str:
        return "" if self._tracker is None else self._tracker.last_line()

    def _start_tracker(self) -> None:
        if self._tracker is not None:
            self._tracker.__exit__(None, None, None)
        self._compressed = bool(self._rng.random() < COMPRESSED_SHARE)
        arguments = {
            "image_reliability": "reliable",
            "image_transport": "compressed" if self._compressed else "raw",
            "input_timeout": "0.5",
            "preset": self._settings.preset,
            "particle_count": str(self._settings.particles),
            **self._soaked.start,
        }
        given = [word for name, value in arguments.items() for word in ("-p", f"{name}:={value}")]
        remapped = ("-r", f"__ns:={self._namespace}", "-r", "/diagnostics:=diagnostics")
        process = _TrackerProcess(self._soaked.name, [*remapped, *given], local_environment())
        process.__enter__()
        self._tracker = process
        self._processes += 1
        self._answers_before = self._camera.answers
        self._await_first_answer()
        # What draws pictures is loaded when first asked for, some 10 MB; that is no growth.
        self._viewer()

    def _await_first_answer(self) -> None:
        """Send frames until one is answered: processes take a while to find each other."""
        deadline = time.monotonic() + START_TIMEOUT + WARM_UP_TIMEOUT
        answers = self._camera.answers
        while self._camera.answers == answers:
            if time.monotonic() > deadline or not self._running:
                raise RosError(f"the tracker does not start: {self._last_words()}")
            self._camera.send(self._next_message())
            self._camera.spin_until(lambda: self._camera.answers > answers, 0.2)
        self._settle()

    def _look_at_memory(self) -> None:
        now = time.monotonic()
        if now < self._next_memory or not self._running or self._tracker is None:
            return
        self._next_memory = now + MEMORY_PERIOD
        private, shared = read_memory(self._tracker.pid)
        frames = self._camera.answers - self._answers_before
        sample = MemorySample(self._minutes(), frames, self._processes, private, shared)
        self.record.memory.append(sample)

    def _inject(self, fault: Fault) -> None:
        if fault in self._changes:
            self._bad_frame(fault)
        else:
            _ACTIONS[fault](self)

    @property
    def _changes(self) -> Mapping[Fault, Callable[[Message, np.random.Generator], None]]:
        return COMPRESSED_CHANGES if self._compressed else CHANGES

    def _bad_message(self, fault: Fault) -> Message:
        message = self._next_message()
        self._changes[fault](message, self._rng)
        return message

    def _bad_frame(self, fault: Fault) -> None:
        if not self._exchange(self._bad_message(fault)):
            self._revive(f"not answered: {fault.value}")
        elif fault in REFUSED and self._camera.last_claims:
            what = f"a {self._soaked.what} was claimed in a frame that is no picture"
            self.record.broken(f"{what}: {fault.value}")

    def _frame_at(self, stamp: int, *, refused: bool = False) -> None:
        if not self._exchange(self._message(stamp)):
            self._revive(f"not answered: a frame with the stamp {stamp}")
        elif refused and self._camera.last_claims:
            self.record.broken(f"a {self._soaked.what} was claimed for the stamp {stamp}")

    def _no_stamp(self) -> None:
        self._frame_at(0)

    def _same_stamp(self) -> None:
        self._frame_at(self._stamp, refused=True)

    def _nonsense_stamp(self) -> None:
        self._frame_at(END_OF_TIME)

    def _clock_back(self) -> None:
        self._stamp -= LONG_AGO
        self._frame_at(self._stamp)

    def _clock_ahead(self) -> None:
        self._stamp += FAR_AHEAD
        if self._stamp + FAR_AHEAD > END_OF_TIME:
            self._stamp = FIRST_STAMP
        self._frame_at(self._stamp)

    def _input_stops(self) -> None:
        self._camera.status = ""
        if not self._camera.spin_until(lambda: self._camera.status == STALE_INPUT, PATIENCE):
            self.record.broken("diagnostics did not say that the input has stopped")

    def _overload(self) -> None:
        for _ in range(BURST):
            self._camera.send(self._next_message())
        self._settle()

    def _parameter_storm(self) -> None:
        table = self._soaked.table
        for _ in range(STORM):
            names = self._rng.choice(len(table), 3, replace=False)
            values = {
                spec.name: _random_value(spec, self._rng)
                for spec in (table[int(index)] for index in names)
            }
            self._set_parameters(values)
            if not self._exchange(self._next_message()):
                self._revive(f"not answered: a frame after {values}")
        usual = self._soaked.preset(self._settings.preset).replaced(
            {"particle_count": self._settings.particles}
        )
        # One by one some would contradict each other on the way; in one request none does.
        known = {spec.name for spec in table}
        own = {name: value for name, value in self._soaked.start.items() if name in known}
        self._set_parameters({**usual.as_mapping(), **own}, atomically=True)

    def _set_parameters(self, values: dict[str, Any], *, atomically: bool = False) -> None:
        parameters = [Parameter(name, value=value) for name, value in values.items()]
        request: Message = SetParameters.Request(
            parameters=[parameter.to_parameter_msg() for parameter in parameters]
        )
        service, kind = f"{self._soaked.name}/set_parameters", SetParameters
        if atomically:
            from rcl_interfaces.srv import SetParametersAtomically  # noqa: PLC0415

            kind = SetParametersAtomically
            service += "_atomically"
            request = kind.Request(parameters=request.parameters)
        response = self._camera.call(kind, service, request, PATIENCE)
        if response is None:
            self.record.broken(f"parameters were neither taken nor refused: {values}")
        elif atomically and not response.result.successful:
            self.record.broken(f"good parameters were refused: {response.result.reason}")

    def _bad_prior(self) -> None:
        header = make_header(self._factory, self._stamp, "camera")
        self._camera.mark.publish(self._soaked.bad_mark(header, self._rng))

    def _reset(self) -> None:
        for kind, name, request in (
            (Trigger, "reset", Trigger.Request()),
            (SetBool, "enable", SetBool.Request(data=False)),
            (SetBool, "enable", SetBool.Request(data=True)),
        ):
            if self._camera.call(kind, f"{self._soaked.name}/{name}", request, PATIENCE) is None:
                self.record.broken(f"the service {name} did not answer")

    def _viewer(self) -> None:
        self._camera.watch_pictures()
        for _ in range(10):
            self._good_frame()
        self._camera.leave_pictures()

    def _other_qos(self) -> None:
        self._camera.send_with_other_qos(self._next_message() for _ in range(5))

    def _freeze(self) -> None:
        assert self._tracker is not None
        self._tracker.send(signal.SIGSTOP)
        for _ in range(3):
            self._camera.send(self._next_message())
        self._camera.pass_time(0.3)
        self._tracker.send(signal.SIGCONT)
        self._settle()

    def _kill_tracker(self) -> None:
        assert self._tracker is not None
        if not self._tracker.running:
            self.record.broken(f"the tracker had died: {self._last_words()}")
        self._tracker.kill()
        self._start_tracker()

    def _kill_replay(self) -> None:
        """Kill a lockstep replay in its midst; another one must run to its end."""
        bag = self._short_bag()
        with self._replay(bag, loop=True) as killed:
            answers = self._camera.answers
            if not self._camera.spin_until(
                lambda: self._camera.answers > answers + REPLAYED_FRAMES, REPLAY_PATIENCE
            ):
                self.record.broken(f"a replay was not answered: {killed.last_line()}")
            killed.kill()
        with self._replay(bag, loop=False) as other:
            self._camera.spin_until(lambda: not other.running, REPLAY_PATIENCE)
            code = other.wait(0.0)
            if code != 0:
                self.record.broken(
                    f"a replay after a killed one ended with {code}: {other.last_line()}"
                )
        self._camera.pass_time(0.1)

    def _short_bag(self) -> Path:
        path = Path(self._folder.name) / ("jpeg" if self._compressed else "raw")
        if not path.exists():
            frames = self._jpegs if self._compressed else self._frames
            write_bag(
                path,
                (
                    replace(frame, stamp=FIRST_STAMP + index * STEP)
                    for index, frame in enumerate(frames[:REPLAYED_FRAMES])
                ),
            )
        return path

    def _replay(self, bag: Path, *, loop: bool) -> _TrackerProcess:
        values = {"source": str(bag), "lockstep": "true", "loop": str(loop).lower()}
        given = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
        remapped = ("-r", f"__ns:={self._namespace}")
        return _TrackerProcess("replay", [*remapped, *given], local_environment())


def _random_value(spec: ParameterSpec, rng: np.random.Generator) -> ParameterValue | list[str]:
    """Draw a value for a parameter: half of them acceptable, the others of every kind of wrong."""
    if rng.random() < 0.5:
        wrong: list[ParameterValue | list[str]] = [
            float("nan"), float("inf"), -1e308, 2**62, "no such word", True, ["a", "list"], "",
        ]  # fmt: skip
        return wrong[int(rng.integers(len(wrong)))]
    if spec.kind is bool:
        return bool(rng.random() < 0.5)
    if spec.kind is str:
        return str(rng.choice(spec.choices)) if spec.choices else ""
    low, high = float(spec.minimum or 0.0), float(spec.maximum or 1.0)
    low, high = LEAST.get(spec.name, low), MOST.get(spec.name, high)
    drawn = low + (high - low) * rng.random() ** 3
    return round(drawn) if spec.kind is int else float(drawn)


_ACTIONS: dict[Fault, Callable[[_Soak], None]] = {
    Fault.NO_STAMP: _Soak._no_stamp,
    Fault.SAME_STAMP: _Soak._same_stamp,
    Fault.NONSENSE_STAMP: _Soak._nonsense_stamp,
    Fault.CLOCK_BACK: _Soak._clock_back,
    Fault.CLOCK_AHEAD: _Soak._clock_ahead,
    Fault.INPUT_STOPS: _Soak._input_stops,
    Fault.OVERLOAD: _Soak._overload,
    Fault.PARAMETERS: _Soak._parameter_storm,
    Fault.PRIOR: _Soak._bad_prior,
    Fault.RESET: _Soak._reset,
    Fault.VIEWER: _Soak._viewer,
    Fault.QOS: _Soak._other_qos,
    Fault.FROZEN: _Soak._freeze,
    Fault.TRACKER_KILLED: _Soak._kill_tracker,
    Fault.REPLAY_KILLED: _Soak._kill_replay,
}


def check_settings(settings: SoakSettings) -> None:
    """Check what the user asks for.

    Raises
    ------
    ParameterError
        A number is out of range, or there is no such preset.
    """
    if not 0.0 < settings.minutes <= 1e6:
        raise ParameterError(f"minutes is {settings.minutes:g}: give more than 0")
    if not 0.0 <= settings.fault_share <= 1.0:
        raise ParameterError(f"faults is {settings.fault_share:g}: give 0 to 1")
    SOAKED[settings.node].preset(settings.preset)
