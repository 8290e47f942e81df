"""`cable-tracker gui`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands.console.ros_part import need_ros
from cable_tracker.commands.options.common import (
    AltitudeOption,
    CameraInfoOption,
    ImuOption,
    OdometryOption,
    OutsideOption,
    ParamsOption,
    RateOption,
    SeedOption,
    SkipOption,
    TopicOption,
    TruthOption,
    VehicleOption,
    chosen_instruments,
    print_notes,
    refuse_without_effect,
)
from cable_tracker.commands.options.parameters import chosen_parameters, chosen_start
from cable_tracker.commands.options.serving import (
    DEFAULT_PORT,
    HostOption,
    PortOption,
    announce,
    need_gui,
)
from cable_tracker.errors import GuiError
from cable_tracker.followed_kinds import CABLE, TARGET, FollowedKind
from cable_tracker.sequences.bags.instruments import NO_TOPIC
from cable_tracker.target.model.start import WAIT
from cable_tracker.target.parameters.presets import TARGET_PRESETS
from cable_tracker.tracking.parameter_table import ParameterSet


def gui(  # noqa: PLR0917
    source: Annotated[
        Path | None,
        typer.Argument(
            help="Recording: a ROS 2 or ROS 1 bag, a video, a folder of images, or a sequence file."
            " It can also be opened from the page."
        ),
    ] = None,
    ros: Annotated[
        str | None,
        typer.Option(
            "--ros", metavar="NAMESPACE", help="Watch the live node in this namespace instead."
        ),
    ] = None,
    target: Annotated[
        bool,
        typer.Option("--target", help="Follow a target with an outline instead of a cable."),
    ] = False,
    init: Annotated[
        str | None,
        typer.Option(
            help="Where to start: as of `track`; with --target `wait` for a box that is drawn,"
            " `detect`, or `x0,y0,x1,y1` in px.  [default: random, or wait]"
        ),
    ] = None,
    preset_name: Annotated[
        str | None,
        typer.Option(
            "--preset",
            help=f"Values to start from: {', '.join(PRESETS)}; with --target"
            f" {', '.join(TARGET_PRESETS)}.  [default: default]",
        ),
    ] = None,
    params: ParamsOption = None,
    seed: SeedOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    truth: TruthOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
    vehicle: VehicleOption = None,
    camera_info_topic: CameraInfoOption = None,
    altitude_topic: AltitudeOption = None,
    imu_topic: ImuOption = None,
    odometry_topic: OdometryOption = None,
    host: HostOption = "127.0.0.1",
    port: PortOption = DEFAULT_PORT,
) -> None:
    """Watch and tune the filter in a browser.

    It shows a recording, or with --ros what a running node does: `tracker`, or with --target
    `target_tracker`.
    """
    window = need_gui("tracking.window")
    shared_sessions = need_gui("tracking.shared_session")
    server = need_gui("web.server")
    sessions = need_gui("session.recording_session")
    if ros is not None:
        if source is not None:
            raise GuiError("give a recording or --ros NAMESPACE, not both")
        of_recordings = {
            "--init": init, "--preset": preset_name, "--params": params, "--seed": seed,
            "--topic": topic, "--rate": rate, "--truth": truth,
            "--skip-bad-frames": skip_bad_frames, "--allow-outside": allow_outside,
            "--vehicle": vehicle, "--camera-info-topic": camera_info_topic,
            "--altitude-topic": altitude_topic, "--imu-topic": imu_topic,
            "--odometry-topic": odometry_topic,
        }  # fmt: skip
        refuse_without_effect(of_recordings, "would not reach the node of --ros")
    if target:
        of_cables = {"--altitude-topic": altitude_topic}
        refuse_without_effect(of_cables, "can do nothing with --target")
    altitude = NO_TOPIC if target else altitude_topic
    choice = chosen_instruments(camera_info_topic, altitude, imu_topic, odometry_topic)
    kind: FollowedKind[ParameterSet] = TARGET if target else CABLE
    values, parameters = chosen_parameters(kind, preset_name, params, {}, seed)
    start = init or WAIT if target else chosen_start(init, values)
    request = sessions.RecordingRequest(
        path=source if source is not None else Path(),
        topic=topic,
        rate=rate,
        truth=truth,
        skip_bad_frames=skip_bad_frames,
        allow_outside=allow_outside,
        init=start,
        choice=choice,
        vehicle=vehicle,
    )
    listening = server.listen_on(host, port)
    shared = shared_sessions.SharedSession(request, parameters)
    if ros is not None:
        live = need_ros("clients.live_session")
        shared.watch(live.LiveTargetSession(ros) if target else live.LiveSession(ros))
    elif source is not None:
        shared.open(request)
        print_notes(source, shared.session.notes)
    window.serve_tracking_window(shared, listening, started=lambda: announce(listening))
