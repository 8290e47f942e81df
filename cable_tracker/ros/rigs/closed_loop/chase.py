"""Let a simulated vehicle follow a target: three nodes in processes of their own, over DDS."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from cable_tracker.atomic_output import output_folder
from cable_tracker.evaluation.targets.chase_table import (
    PLOT,
    SUMMARY,
    TABLE,
    ChaseSummary,
    summarise_chase,
    write_chase,
)
from cable_tracker.ros.clients.lockstep import DRIVEN, PATIENT, READY_SOON
from cable_tracker.ros.clients.recorder import spin_until
from cable_tracker.ros.process.child_process import START_TIMEOUT, WARM_UP_TIMEOUT
from cable_tracker.ros.rigs.closed_loop.chase_recorder import ChaseRecorder, ChaseVideoFrame
from cable_tracker.ros.rigs.closed_loop.run_recorder import (
    COMMAND,
    RELEASED,
    SETTLE_TIME,
    closed_loop,
    listen_to_the_end,
    need_rows,
)
from cable_tracker.simulation.targets.chase import ChaseSettings, ChaseWorld, target_size
from cable_tracker.tracking.parameter_table import ParameterValue
from cable_tracker.visualisation.video import VideoWriter

VIDEO = "chase.webm"


@dataclass(frozen=True, slots=True)
class ChaseRequest:
    """Request for a chase in lockstep.

    Attributes
    ----------
    world : ChaseSettings
        Settings of the world.
    preset : str
        Preset of the target tracker.
    distance : float
        Distance to be kept [m].
    """

    world: ChaseSettings
    preset: str
    distance: float


def file_names() -> tuple[str, ...]:
    """Return the names of the files that a run writes."""
    return TABLE, SUMMARY, PLOT, VIDEO


def run_chase(
    request: ChaseRequest,
    path: Path,
    *,
    overwrite: bool,
    advance: Callable[[], None],
) -> ChaseSummary:
    """Let the vehicle follow the target, and write table, figures, plot and video into a folder.

    The tracker is shown the target in the first frame. In lockstep the same request gives the same
    table.

    Parameters
    ----------
    request : ChaseRequest
        Settings of the chase.
    path : Path
        The folder.
    overwrite : bool
        Replace an earlier one, but none in which the user has put other files.
    advance : callable
        Called after each frame.

    Raises
    ------
    OutputError
        The folder cannot be written.
    RosError
        The processes do not find each other, or one of them has died.
    """
    with ExitStack() as stack:
        folder = stack.enter_context(
            output_folder(path, TABLE, overwrite=overwrite, is_own_name=file_names().__contains__)
        )
        video = stack.enter_context(VideoWriter(folder / VIDEO))
        recorder, executor, group = stack.enter_context(closed_loop("chase", ChaseRecorder))
        parameters = _parameters(request)
        for name in ("target_tracker", "follower"):
            group.start(name, parameters[name])
        spin_until(
            executor, recorder.is_ready, START_TIMEOUT + WARM_UP_TIMEOUT, group.what_has_died
        )
        name = "target_simulator"
        simulator = group.start(name, parameters[name], {COMMAND: RELEASED}, may_end=True)

        def show(frame: ChaseVideoFrame) -> None:
            if frame.picture is not None:
                video.add(frame.picture, frame.stamp)
            advance()

        listen_to_the_end(
            recorder,
            executor,
            group,
            simulator,
            show=show,
            has_settled=lambda _: recorder.is_settled(),
        )
        rows = need_rows(recorder.rows())
        summary = summarise_chase(rows, request.distance)
        write_chase(folder, rows, summary)
    return summary


def _parameters(request: ChaseRequest) -> dict[str, dict[str, ParameterValue]]:
    world = ChaseWorld(request.world)
    box = world.view(world.state()).box
    assert box is not None, "the target begins before the camera"
    return {
        "target_tracker": {
            "preset": request.preset,
            "initial_target": ",".join(repr(side) for side in box),
            "target_size": target_size(),
            **DRIVEN,
            **READY_SOON,
        },
        "follower": {
            "distance": request.distance,
            "lockstep": True,
            "settle_time": SETTLE_TIME,
        },
        "target_simulator": {
            **request.world.as_mapping(),
            "lockstep": True,
            "publish_clock": True,
            "truth_readers": 1,
            **PATIENT,
        },
    }
