"""A soak test: a tracker process is fed frames for a long time while faults are injected."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack

import rclpy

from cable_tracker.errors import ParameterError
from cable_tracker.ros.process.environment import use_local_environment
from cable_tracker.ros.process.ros_context import started_context
from cable_tracker.ros.rigs.soak.actions import ACTIONS, inject
from cable_tracker.ros.rigs.soak.faults import draw_fault
from cable_tracker.ros.rigs.soak.record import SoakRecord
from cable_tracker.ros.rigs.soak.rig import SoakRig, SoakSettings
from cable_tracker.ros.rigs.soak.soaked_node import SOAKED
from cable_tracker.sequences.frame import Frame

LOCKSTEP_FRAMES = 100
"""Frames one after the other, each answered before the next."""

FULL_RATE_SHARE = 0.3
"""Share of the turns in which frames at full rate come before those in lockstep."""

FULL_RATE_FRAMES = 100
FULL_RATE_PAUSE = 0.002
"""Pause between two frames at full rate [s]."""


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
    SOAKED[settings.node].kind.preset(settings.preset)


def run_soak(
    frames: Sequence[Frame],
    settings: SoakSettings,
    advance: Callable[[float], None],
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
        context = started_context()
        stack.callback(rclpy.try_shutdown, context=context)
        rig = SoakRig(frames, settings, context)
        stack.callback(rig.close)
        rig.start_tracker()
        while (share := rig.share()) < 1.0:
            advance(share)
            if rig.rng.random() < FULL_RATE_SHARE:
                _full_rate(rig)
            _lockstep(rig)
    rig.record.check_growth()
    return rig.record


def _lockstep(rig: SoakRig) -> None:
    for _ in range(LOCKSTEP_FRAMES):
        if rig.rng.random() < rig.settings.fault_share:
            fault = draw_fault(rig.rng, rig.changes.keys() | ACTIONS.keys())
            rig.record.inject(fault.value)
            inject(rig, fault)
            if rig.good_frame():
                rig.record.recoveries[fault.value] += 1
            else:
                rig.restart_tracker(f"no good frame was answered after: {fault.value}")
        elif not rig.good_frame():
            rig.restart_tracker("a frame was not answered")
        rig.sample_memory()


def _full_rate(rig: SoakRig) -> None:
    """Send without waiting for answers, as a camera does, bad frames among the good ones."""
    faults = []
    for _ in range(FULL_RATE_FRAMES):
        if rig.rng.random() < rig.settings.fault_share:
            faults.append(draw_fault(rig.rng, rig.changes))
            rig.camera.send(rig.bad_message(faults[-1]))
        rig.camera.send(rig.frames.next_message())
        rig.camera.pass_time(FULL_RATE_PAUSE)
    recovered = rig.settle()
    for fault in faults:
        rig.record.inject(fault.value)
        rig.record.recoveries[fault.value] += recovered
