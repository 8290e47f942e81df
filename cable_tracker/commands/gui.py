"""`cable-tracker gui`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.model.initial_state_text import RANDOM
from cable_tracker.cable.parameters.parameter_files import read_parameter_file
from cable_tracker.commands.options import (
    InitOption,
    OutsideOption,
    ParamsOption,
    PresetOption,
    RateOption,
    SeedOption,
    SkipOption,
    TopicOption,
    TruthOption,
)
from cable_tracker.commands.ros_part import need_ros
from cable_tracker.commands.serving import (
    DEFAULT_PORT,
    HostOption,
    PortOption,
    announce,
    need_gui,
)
from cable_tracker.commands.terminal import messages
from cable_tracker.commands.track import chosen_parameters, chosen_start
from cable_tracker.errors import GuiError


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
    init: InitOption = None,
    preset_name: PresetOption = None,
    params: ParamsOption = None,
    seed: SeedOption = None,
    topic: TopicOption = None,
    rate: RateOption = 25.0,
    truth: TruthOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
    host: HostOption = "127.0.0.1",
    port: PortOption = DEFAULT_PORT,
) -> None:
    """Watch and tune the filter in a browser, on a recording or on a live node."""
    window = need_gui("tracking_window")
    desks = need_gui("tracking_desk")
    server = need_gui("server")
    requests = need_gui("recording_request")
    if ros is not None and source is not None:
        raise GuiError("give a recording or --ros NAMESPACE, not both")
    values = read_parameter_file(params) if params is not None else {}
    parameters = chosen_parameters(preset_name.value if preset_name else None, values, seed)
    request = requests.RecordingRequest(
        path=source if source is not None else Path(),
        topic=topic,
        rate=rate,
        truth=truth,
        skip_bad_frames=skip_bad_frames,
        allow_outside=allow_outside,
        init=chosen_start(init, values) if source is not None else init or RANDOM,
    )
    listening = server.listen_on(host, port)
    desk = desks.TrackingDesk(None, request, parameters)
    if ros is not None:
        desk.watch(need_ros("clients.live_session").LiveSession(ros))
    elif source is not None:
        desk.open(request)
        if desk.session.note:
            messages.print(f"note: {source}: {desk.session.note}", soft_wrap=True)
    window.serve_tracking_window(
        desk,
        listening,
        started=lambda: announce(listening.url, listening.ssh_line(), listening.token is None),
    )
