"""`cable-tracker target`."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack, nullcontext, suppress
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.commands.console.results import (
    folder_beside,
    need_usable_frames,
    print_events,
    print_median_time,
    print_statuses,
)
from cable_tracker.commands.console.ros_part import need_ros
from cable_tracker.commands.console.terminal import counted, print_files, progress_bar
from cable_tracker.commands.options.common import (
    BagOption,
    CameraInfoOption,
    ForceOption,
    ImuOption,
    OdometryOption,
    OutsideOption,
    ParamsOption,
    PicturesOption,
    RateOption,
    SeedOption,
    SkipOption,
    SourceArgument,
    TargetPresetOption,
    TimingOption,
    TopicOption,
    VehicleOption,
    VideoOption,
    chosen_instruments,
    find_vehicle,
    open_recording,
    print_notes,
    print_taken_rate,
)
from cable_tracker.commands.options.parameters import chosen_parameters
from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.followed_kinds import TARGET
from cable_tracker.metric.recorded_instruments import RecordedInstruments
from cable_tracker.metric.targets.recorded_target import node_values, recorded_target
from cable_tracker.metric.targets.target_instrument_fusion import TargetInstrumentFusion
from cable_tracker.offline.results import WantedResults, follow_all
from cable_tracker.offline.target_folder import TargetFolder
from cable_tracker.offline.track_target import follow_frame, parse_start
from cable_tracker.sequences.bags.instruments import NO_TOPIC
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.source_base import ChosenRecording, Source
from cable_tracker.target.model.start import DETECT, TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker

NO_METRES = (
    "no metres: there is no calibration; give one with --vehicle, without it the size of the target"
    " and the mounting of the camera can do nothing"
)


def target(  # noqa: PLR0917
    source: SourceArgument,
    init: Annotated[
        str,
        typer.Option(
            help=f"Where the target is in the first frame: `x0,y0,x1,y1` in px from the top left"
            f" corner; or `{DETECT}`: a detector proposes one."
        ),
    ] = DETECT,
    preset_name: TargetPresetOption = None,
    params: ParamsOption = None,
    seed: SeedOption = None,
    output: Annotated[
        Path | None, typer.Option(help="Folder for the results.  [default: SOURCE_target]")
    ] = None,
    force: ForceOption = False,
    topic: TopicOption = None,
    rate: RateOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
    target_size: Annotated[
        float,
        typer.Option(
            min=0.0,
            max=1000.0,
            help="Square root of the area that the target shows [m], for the range; 0: unknown.",
        ),
    ] = 0.0,
    vehicle: VehicleOption = None,
    camera_info_topic: CameraInfoOption = None,
    imu_topic: ImuOption = None,
    odometry_topic: OdometryOption = None,
    ros: Annotated[
        bool, typer.Option("--ros", help="Run the nodes and talk over DDS; needs ROS 2 Jazzy.")
    ] = False,
    video: VideoOption = True,
    bag: BagOption = True,
    pictures: PicturesOption = True,
    timing: TimingOption = True,
) -> None:
    """Follow a target with an outline: a buoy, a vehicle, a diver.

    Writes a table, a sheet of pictures, a video and a bag into one folder. Where a bag holds a
    calibration, and odometry or an imu, turns of the camera are taken out, and metres.csv says in
    which direction and how far the target is. The same recording, parameters and seed give the
    same estimates, with --ros and without.
    """
    _, parameters = chosen_parameters(TARGET, preset_name, params, {}, seed)
    if init == DETECT:
        parameters = parameters.with_detector()
    start = _chosen_start(init)
    folder = output if output is not None else folder_beside(source, "target")
    chosen = ChosenRecording(source, topic, rate, None, skip_bad_frames, allow_outside)
    choice = chosen_instruments(camera_info_topic, NO_TOPIC, imu_topic, odometry_topic)
    wanted = WantedResults(video=video, bag=bag, pictures=pictures)
    with ExitStack() as stack:
        recording = stack.enter_context(open_recording(chosen))
        if start is not None:
            _check_fits(start, recording)
        results = stack.enter_context(
            TargetFolder(folder, overwrite=force, timing=timing, wanted=wanted)
        )
        progress = stack.enter_context(progress_bar("following", recording.frame_count))
        frames = counted(recording.frames(), progress)
        described = find_vehicle(recording, choice, vehicle)
        if not described.has_instruments and (target_size or described.vehicle.said):
            print_notes(source, [NO_METRES])
        if ros:
            lockstep = need_ros("clients.lockstep")
            replayed = lockstep.replay_parameters(
                chosen, choice, vehicle, has_instruments=described.has_instruments
            )
            measuring = node_values(described, target_size)
            own = {
                **lockstep.tracker_parameters(compressed=recording.compressed),
                **parameters.as_mapping(),
                **measuring,
                "initial_target": init,
            }
            damage = need_ros("clients.track_target").track_target_over_ros(
                frames, own, replayed, results, with_metres=bool(measuring)
            )
        else:
            instruments = (
                recorded_target(described, target_size) if described.has_instruments else None
            )
            damage = _follow_here(frames, parameters, start, results, instruments)
        need_usable_frames(recording.path, results.rows, damage)
    print_notes(source, described.remarks())
    _print(results)
    print_taken_rate(recording)
    if damage is not None:
        raise damage


def _follow_here(
    frames: Iterable[Frame],
    parameters: TargetParameters,
    start: TargetStart | None,
    results: TargetFolder,
    instruments: RecordedInstruments[TargetInstrumentFusion] | None,
) -> RecordingError | None:
    """Follow a target in this process; return why the recording broke off, if it did."""
    tracker = TargetTracker(parameters)
    if start is not None:
        tracker.initialise(start)
    with instruments or nullcontext():
        return follow_all(frames, lambda frame: follow_frame(frame, tracker, results, instruments))


def _chosen_start(init: str) -> TargetStart | None:
    try:
        return parse_start(init)
    except ParameterError as error:
        raise ParameterError(f"init: {error}") from error


def _check_fits(start: TargetStart, recording: Source) -> None:
    """Refuse a box that cannot be in the first picture, before results take the place of others."""
    # What cannot be read is said when the recording is followed.
    size = None
    with suppress(RecordingError):
        size = next(filter(None, map(_size_of, recording.frames())), None)
    if size is not None:
        try:
            start.check(size)
        except FrameError as error:
            raise ParameterError(f"init: {error}") from error


def _size_of(frame: Frame) -> tuple[int, int] | None:
    """Return width and height of a frame [px]; None of one without a picture."""
    try:
        height, width = decode_grey(frame.image).shape
    except FrameError:
        return None
    return width, height


def _print(results: TargetFolder) -> None:
    print_statuses([row.status for row in results.rows])
    print_events(results.rows)
    print_median_time([row.ms for row in results.rows])
    print_files(results.path, results.names)
