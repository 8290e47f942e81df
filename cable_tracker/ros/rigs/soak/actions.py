"""Faults of a soak test that are more than a spoilt frame: what is done to the tracker."""

from __future__ import annotations

import signal
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from cable_tracker.ros.health.diagnostics import STALE_INPUT
from cable_tracker.ros.rigs.soak.faults import REFUSED, Fault
from cable_tracker.ros.rigs.soak.frames import BEGINNING, REPLAYED_FRAMES
from cable_tracker.ros.rigs.soak.rig import SoakRig
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import ParameterSpec, ParameterValue

LONG_AGO = 100 * NANOSECONDS
FAR_AHEAD = 3600 * NANOSECONDS
END_OF_TIME = (2**31 - 1) * NANOSECONDS

REPLAY_PATIENCE = 300.0
"""Longest wait for a replay, which starts anew and gives up by itself without answers [s].

On a loaded machine its start alone may take a minute.
"""

BURST = 50
"""Frames sent at once to overload the tracker."""

STORM = 8
"""Sets of parameters in one storm."""

MOST_PARTICLES = 1000
WIDEST_IMAGE = 640

MOST = {
    "particle_count": MOST_PARTICLES,
    "working_width": WIDEST_IMAGE,
    "ancestor_count": 512,
}
LEAST = {"sample_spacing": 5.0}
"""A storm must not make frames slower than the promise of an answer allows: a thousand particles
with scan lines at every pixel are legal, and take long."""


def inject(rig: SoakRig, fault: Fault) -> None:
    """Do to the tracker what a fault says."""
    if fault in rig.changes:
        _bad_frame(rig, fault)
    else:
        ACTIONS[fault](rig)


def _bad_frame(rig: SoakRig, fault: Fault) -> None:
    if not rig.send_and_wait(rig.bad_message(fault)):
        rig.restart_tracker(f"not answered: {fault.value}")
    elif fault in REFUSED and rig.camera.last_claims:
        what = f"a {rig.soaked.claimed} was claimed in a frame that is no picture"
        rig.record.broken(f"{what}: {fault.value}")


def _frame_at(rig: SoakRig, stamp: int, *, refused: bool = False) -> None:
    if not rig.send_and_wait(rig.frames.message(stamp)):
        rig.restart_tracker(f"not answered: a frame with the stamp {stamp}")
    elif refused and rig.camera.last_claims:
        rig.record.broken(f"a {rig.soaked.claimed} was claimed for the stamp {stamp}")


def _no_stamp(rig: SoakRig) -> None:
    _frame_at(rig, 0)


def _same_stamp(rig: SoakRig) -> None:
    _frame_at(rig, rig.frames.stamp, refused=True)


def _nonsense_stamp(rig: SoakRig) -> None:
    _frame_at(rig, END_OF_TIME)


def _clock_back(rig: SoakRig) -> None:
    rig.frames.stamp -= LONG_AGO
    _frame_at(rig, rig.frames.stamp)


def _clock_ahead(rig: SoakRig) -> None:
    rig.frames.stamp += FAR_AHEAD
    if rig.frames.stamp + FAR_AHEAD > END_OF_TIME:
        rig.frames.stamp = BEGINNING
    _frame_at(rig, rig.frames.stamp)


def _input_stops(rig: SoakRig) -> None:
    rig.camera.status = ""
    if not rig.wait_until(lambda: rig.camera.status == STALE_INPUT):
        rig.record.broken("diagnostics did not say that the input has stopped")


def _overload(rig: SoakRig) -> None:
    for _ in range(BURST):
        rig.camera.send(rig.frames.next_message())
    rig.settle()


def _parameter_storm(rig: SoakRig) -> None:
    table = rig.soaked.kind.table
    for _ in range(STORM):
        specs = [table[int(index)] for index in rig.rng.choice(len(table), 3, replace=False)]
        values = {spec.name: random_value(spec, rig.rng) for spec in specs}
        _set_parameters(rig, values)
        if not rig.good_frame():
            rig.restart_tracker(f"not answered: a frame after {values}")
    usual = rig.soaked.kind.preset(rig.settings.preset).replaced(
        {"particle_count": rig.settings.particles}
    )
    # One by one some would contradict each other on the way; in one request none does.
    known = {spec.name for spec in table}
    own = {name: value for name, value in rig.soaked.start.items() if name in known}
    _set_parameters(rig, {**usual.as_mapping(), **own}, atomically=True)


def random_value(spec: ParameterSpec, rng: np.random.Generator) -> ParameterValue | list[str]:
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


def _set_parameters(rig: SoakRig, values: dict[str, Any], *, atomically: bool = False) -> None:
    parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
    kind, service = SetParameters, "set_parameters"
    if atomically:
        kind, service = SetParametersAtomically, "set_parameters_atomically"
    request: Message = kind.Request(parameters=parameters)
    response = rig.call(kind, service, request)
    if response is None:
        rig.record.broken(f"parameters were neither taken nor refused: {values}")
    elif atomically and not response.result.successful:
        rig.record.broken(f"good parameters were refused: {response.result.reason}")


def _bad_prior(rig: SoakRig) -> None:
    header = rig.frames.header(rig.frames.stamp)
    rig.camera.start.publish(rig.soaked.bad_start(header, rig.rng))


def _reset(rig: SoakRig) -> None:
    for kind, name, request in (
        (Trigger, "reset", Trigger.Request()),
        (SetBool, "enable", SetBool.Request(data=False)),
        (SetBool, "enable", SetBool.Request(data=True)),
    ):
        if rig.call(kind, name, request) is None:
            rig.record.broken(f"the service {name} did not answer")


def _other_qos(rig: SoakRig) -> None:
    rig.camera.send_with_other_qos(rig.frames.next_message() for _ in range(5))


def _freeze(rig: SoakRig) -> None:
    rig.tracker.send(signal.SIGSTOP)
    for _ in range(3):
        rig.camera.send(rig.frames.next_message())
    rig.camera.pass_time(0.3)
    rig.tracker.send(signal.SIGCONT)
    rig.settle()


def _kill_tracker(rig: SoakRig) -> None:
    if not rig.tracker.running:
        rig.record.broken(f"the tracker had died: {rig.last_line()}")
    rig.tracker.kill()
    rig.start_tracker()


def _kill_replay(rig: SoakRig) -> None:
    """Kill a lockstep replay in its midst; another one must run to its end."""
    with rig.replay(loop=True) as killed:
        answers = rig.camera.answers
        if not rig.camera.spin_until(
            lambda: rig.camera.answers > answers + REPLAYED_FRAMES, REPLAY_PATIENCE
        ):
            rig.record.broken(f"a replay was not answered: {killed.last_line()}")
        killed.kill()
    with rig.replay(loop=False) as other:
        rig.camera.spin_until(lambda: not other.running, REPLAY_PATIENCE)
        code = other.wait(0.0)
        if code != 0:
            rig.record.broken(f"a replay after a killed one ended with {code}: {other.last_line()}")
    rig.camera.pass_time(0.1)


ACTIONS: Mapping[Fault, Callable[[SoakRig], None]] = {
    Fault.NO_STAMP: _no_stamp,
    Fault.SAME_STAMP: _same_stamp,
    Fault.NONSENSE_STAMP: _nonsense_stamp,
    Fault.CLOCK_BACK: _clock_back,
    Fault.CLOCK_AHEAD: _clock_ahead,
    Fault.INPUT_STOPS: _input_stops,
    Fault.OVERLOAD: _overload,
    Fault.PARAMETERS: _parameter_storm,
    Fault.PRIOR: _bad_prior,
    Fault.RESET: _reset,
    Fault.VIEWER: SoakRig.view,
    Fault.QOS: _other_qos,
    Fault.FROZEN: _freeze,
    Fault.TRACKER_KILLED: _kill_tracker,
    Fault.REPLAY_KILLED: _kill_replay,
}
