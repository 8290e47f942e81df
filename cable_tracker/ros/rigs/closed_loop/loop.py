"""Close the loop: simulator, tracker and controller in processes of their own, over DDS."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from rclpy.executors import SingleThreadedExecutor

from cable_tracker.arrays import Image
from cable_tracker.atomic_output import output_folder
from cable_tracker.evaluation.loop_figures import MapPanel, plot_errors, plot_way
from cable_tracker.evaluation.loop_table import (
    SUMMARY,
    TABLE,
    LoopRow,
    LoopSummary,
    summarise_loop,
)
from cable_tracker.evaluation.methods import BASELINES
from cable_tracker.ros.clients.lockstep import (
    DRIVEN,
    PATIENT,
    READY_SOON,
)
from cable_tracker.ros.clients.recorder import spin_until
from cable_tracker.ros.process.child_process import START_TIMEOUT, WARM_UP_TIMEOUT, NodeProcess
from cable_tracker.ros.process.node_group import NodeGroup
from cable_tracker.ros.rigs.closed_loop.loop_recorder import LoopRecorder, LoopVideoFrame
from cable_tracker.ros.rigs.closed_loop.run_recorder import (
    COMMAND,
    RELEASED,
    SETTLE_TIME,
    closed_loop,
    listen_to_the_end,
    need_rows,
)
from cable_tracker.sequences.tables.csv_tables import write_records
from cable_tracker.simulation.cable_scene import cable_course
from cable_tracker.simulation.dive import CABLE_RADIUS, MOUNTING
from cable_tracker.simulation.live_world import LiveSettings
from cable_tracker.simulation.rendering.laid_cable import SETTLED, Stretch
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import ParameterValue
from cable_tracker.visualisation.overlay import draw_overlay
from cable_tracker.visualisation.video import VideoWriter

WAY, ERRORS, VIDEO = "way.png", "cross_track.png", "loop.webm"

OWN_NAMES = frozenset({TABLE, SUMMARY, WAY, ERRORS, VIDEO})
"""All that is ever written into the folder of a run."""

SETTLE_TIMEOUT = 3.0
"""Free-running, frames that the tracker left out are not waited for any longer [s]."""

CAMERA_WIDTH = 480
"""Width of the camera's picture in the video [px]."""


@dataclass(frozen=True, slots=True)
class LoopRequest:
    """Request for a run of the closed loop.

    Attributes
    ----------
    world : LiveSettings
        Settings of the world.
    method : str
        One of `evaluation.methods.METHODS`.
    tracker : mapping
        Parameters of the tracker node.
    speed : float
        Speed of the vehicle [m/s].
    realtime : bool
        Run freely in real time; else in lockstep.
    standstill : float
        Time of wanted standstill after which the run ends [s]; 0: no limit.
    with_video : bool
        Whether every frame is drawn.
    patience : float
        Time without a new metre after which the run ends [s].
    """

    world: LiveSettings
    method: str
    tracker: Mapping[str, ParameterValue]
    speed: float
    realtime: bool
    standstill: float
    with_video: bool
    patience: float = 60.0

    @property
    def tracker_node(self) -> str:
        """Which node tracks, a name of `entry.NODES`."""
        return "baseline" if self.method in BASELINES else "tracker"

    @property
    def burial(self) -> Stretch | None:
        """Buried stretch along the cable's course; None without one."""
        world = self.world
        if not world.buried:
            return None
        return Stretch(world.buried_from, world.buried_from + world.buried)


def file_names(request: LoopRequest) -> tuple[str, ...]:
    """Return the names of the files that a run writes."""
    return (TABLE, SUMMARY, WAY, ERRORS, *((VIDEO,) if request.with_video else ()))


def run_loop(
    request: LoopRequest,
    path: Path,
    *,
    overwrite: bool,
    advance: Callable[[float], None],
) -> LoopSummary:
    """Let the vehicle follow the cable, and write table, plots and video into a folder.

    Parameters
    ----------
    request : LoopRequest
        Settings of the loop. In lockstep the same request writes the same files.
    path : Path
        The folder.
    overwrite : bool
        Replace an earlier one, but none in which the user has put other files.
    advance : callable
        Called with how far along the vehicle is, after each frame [m].

    Raises
    ------
    OutputError
        The folder cannot be written.
    RosError
        The processes do not find each other, or one of them has died.
    """
    with ExitStack() as stack:
        folder = stack.enter_context(
            output_folder(path, TABLE, overwrite=overwrite, is_own_name=OWN_NAMES.__contains__)
        )
        video = stack.enter_context(VideoWriter(folder / VIDEO)) if request.with_video else None
        make = partial(LoopRecorder, with_images=request.with_video)
        recorder, executor, group = stack.enter_context(closed_loop("loop", make))
        run = _Run(request, recorder, executor, group, video, advance=advance)
        group.start(request.tracker_node, _tracker_parameters(request))
        group.start("controller", _controller_parameters(request))
        run.wait_until_connected()
        simulator = group.start(
            "simulator",
            _simulator_parameters(request),
            {} if request.realtime else {COMMAND: RELEASED},
            may_end=True,
        )
        run.follow(simulator)
        return run.write(folder)


def _tracker_parameters(request: LoopRequest) -> dict[str, ParameterValue]:
    values: dict[str, ParameterValue] = {
        "camera_pitch": 90.0 - float(np.degrees(MOUNTING)),
        "cable_height": SETTLED * CABLE_RADIUS,
        "altitude_is_vertical": True,
        **READY_SOON,
        "method" if request.method in BASELINES else "preset": request.method,
        **request.tracker,
    }
    if not request.realtime:
        values |= DRIVEN
    return values


def _controller_parameters(request: LoopRequest) -> dict[str, ParameterValue]:
    values: dict[str, ParameterValue] = {"speed": request.speed}
    if not request.realtime:
        values |= {"lockstep": True, "settle_time": SETTLE_TIME}
    return values


def _simulator_parameters(request: LoopRequest) -> dict[str, ParameterValue]:
    return {
        **request.world.as_mapping(),
        "lockstep": not request.realtime,
        "publish_clock": True,
        "image_readers": 2 if request.with_video else 1,
        "odometry_readers": 2,
        "truth_readers": 1,
        **PATIENT,
        "patience": request.patience,
        "standstill": request.standstill,
    }


class _Run:
    """One run on its way."""

    def __init__(
        self,
        request: LoopRequest,
        recorder: LoopRecorder,
        executor: SingleThreadedExecutor,
        group: NodeGroup,
        video: VideoWriter | None,
        *,
        advance: Callable[[float], None],
    ) -> None:
        self._request = request
        self._recorder = recorder
        self._executor = executor
        self._group = group
        self._video = video
        self._advance = advance
        along = np.arange(-5.0, request.world.length + 5.0, 0.25)
        self._course = cable_course(request.world.seed, along)
        self._map = MapPanel(self._course, request.burial)
        self._first_stamp: int | None = None

    def wait_until_connected(self) -> None:
        """Wait until what the tracker publishes reaches all nodes, and it is ready for frames."""
        what_has_died = self._group.what_has_died
        spin_until(self._executor, self._recorder.is_connected, START_TIMEOUT, what_has_died)
        spin_until(self._executor, self._recorder.is_warm, WARM_UP_TIMEOUT, what_has_died)

    def follow(self, simulator: NodeProcess) -> None:
        """Draw frame after frame until the simulator has ended, and all of them have come."""
        listen_to_the_end(
            self._recorder,
            self._executor,
            self._group,
            simulator,
            show=self._show,
            has_settled=self._has_settled,
        )

    def _show(self, frame: LoopVideoFrame) -> None:
        self._draw(frame)
        self._advance(frame.place[0])

    def _has_settled(self, since_end: float) -> bool:
        if self._request.realtime:
            return since_end > SETTLE_TIMEOUT or self._recorder.is_settled()
        return self._recorder.is_settled() and self._recorder.is_steered()

    def _draw(self, frame: LoopVideoFrame) -> None:
        if self._video is None or frame.image is None:
            return
        if self._first_stamp is None:
            self._first_stamp = frame.stamp
        picture = draw_overlay(
            frame.image, state=frame.state, status=frame.status, minimum_width=CAMERA_WIDTH
        )
        seconds = (frame.stamp - self._first_stamp) / NANOSECONDS
        words = (
            f"{seconds:6.1f} s  {frame.place[0]:6.1f} m",
            f"cable {abs(frame.error):.2f} m to the {'left' if frame.error > 0 else 'right'}",
        )
        panel = self._map.draw(frame.place, frame.yaw, words)
        self._video.add(_side_by_side(picture, panel), frame.stamp)

    def write(self, folder: Path) -> LoopSummary:
        """Write everything but the video."""
        rows = need_rows(self._recorder.rows())
        world, burial = self._request.world, self._request.burial
        summary = summarise_loop(rows, world.seed, world.length, burial)
        write_records(folder / TABLE, LoopRow, rows)
        write_records(folder / SUMMARY, LoopSummary, [summary])
        plot_way(folder / WAY, rows, self._course, burial)
        plot_errors(folder / ERRORS, rows, burial)
        return summary


def _side_by_side(left: Image, right: Image) -> Image:
    height = left.shape[0]
    width = round(right.shape[1] * height / right.shape[0])
    return np.hstack((left, cv2.resize(right, (width, height), interpolation=cv2.INTER_AREA)))
