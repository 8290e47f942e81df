"""`cable-tracker track`."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack, nullcontext
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.initial_state_text import format_initial_state
from cable_tracker.cable.model.state import POSE_COMPONENTS
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.commands.console.results import (
    folder_beside,
    metres_note,
    need_usable_frames,
    print_events,
    print_median_time,
    print_statuses,
)
from cable_tracker.commands.console.ros_part import need_ros
from cable_tracker.commands.console.terminal import (
    console,
    counted,
    print_files,
    print_table,
    progress_bar,
)
from cable_tracker.commands.options.common import (
    AltitudeOption,
    BagOption,
    CameraInfoOption,
    ForceOption,
    ImuOption,
    InitOption,
    OdometryOption,
    OutsideOption,
    ParamsOption,
    PicturesOption,
    PresetOption,
    RateOption,
    SeedOption,
    SkipOption,
    SourceArgument,
    TimingOption,
    TopicOption,
    TruthOption,
    VehicleOption,
    VideoOption,
    chosen_instruments,
    find_vehicle,
    open_recording,
    print_notes,
    print_taken_rate,
)
from cable_tracker.commands.options.parameters import (
    ValueOption,
    chosen_parameters,
    chosen_start,
    single_values,
)
from cable_tracker.detection.line_pairs import pair_limits
from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.errors import ErrorSummary, summarise_errors
from cable_tracker.followed_kinds import CABLE
from cable_tracker.metric.recorded_instruments import RecordedCableInstruments
from cable_tracker.offline.advice import advice
from cable_tracker.offline.cable_folder import CableFolder
from cable_tracker.offline.results import WantedResults, follow_all
from cable_tracker.offline.track_cable import TRUTH, given_state_for, track_frame
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.source_base import ChosenRecording
from cable_tracker.trackers import make_tracker


def track(  # noqa: PLR0917
    source: SourceArgument,
    ros: Annotated[
        bool,
        typer.Option(
            "--ros", help="Use the ROS nodes `replay` and `tracker`, in lockstep over DDS."
        ),
    ] = False,
    init: InitOption = None,
    preset_name: PresetOption = None,
    params: ParamsOption = None,
    param: ValueOption = None,
    seed: SeedOption = None,
    output: Annotated[
        Path | None, typer.Option(help="Folder for the results.  [default: SOURCE_tracked]")
    ] = None,
    force: ForceOption = False,
    topic: TopicOption = None,
    rate: RateOption = None,
    truth: TruthOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
    video: VideoOption = True,
    bag: BagOption = True,
    pictures: PicturesOption = True,
    vehicle: VehicleOption = None,
    camera_info_topic: CameraInfoOption = None,
    altitude_topic: AltitudeOption = None,
    imu_topic: ImuOption = None,
    odometry_topic: OdometryOption = None,
    timing: TimingOption = True,
) -> None:
    """Track a recording and write the results into a folder.

    They are a table of estimates, pictures, a video and a bag. Where a bag holds calibration and
    altitude, the table says in metres where the cable is, and odometry tells the filter how the
    vehicle moves. With ground truth, a table of errors is printed. The same recording, parameters
    and seed give the same estimates, with --ros and without.
    """
    values, parameters = chosen_parameters(CABLE, preset_name, params, single_values(param), seed)
    folder = output if output is not None else folder_beside(source, "tracked")
    chosen = ChosenRecording(source, topic, rate, truth, skip_bad_frames, allow_outside)
    choice = chosen_instruments(camera_info_topic, altitude_topic, imu_topic, odometry_topic)
    wanted = WantedResults(video=video, bag=bag, pictures=pictures)
    with ExitStack() as stack:
        recording = stack.enter_context(open_recording(chosen))
        start = chosen_start(init, values)
        given = given_state_for(recording, start, pair_limits(parameters))
        results = stack.enter_context(
            CableFolder(folder, overwrite=force, timing=timing, wanted=wanted)
        )
        progress = stack.enter_context(progress_bar("tracking", recording.frame_count))
        frames = counted(recording.frames(), progress)
        described = find_vehicle(recording, choice, vehicle)
        metres = None if ros else described.instruments()
        if ros:
            lockstep = need_ros("clients.lockstep")
            replayed = lockstep.replay_parameters(
                chosen, choice, vehicle, has_instruments=described.has_instruments
            )
            own = {
                **lockstep.tracker_parameters(compressed=recording.compressed),
                **parameters.as_mapping(),
                "initial_state": _initial_state_of_node(start, given),
            }
            damage = need_ros("clients.track_cable").track_cable_over_ros(
                frames, own, replayed, results, described
            )
        else:
            damage = _track_here(frames, parameters, given, results, metres)
        need_usable_frames(recording.path, results.rows, damage)
    print_notes(source, [*described.remarks(), *(metres.remarks() if metres is not None else ())])
    _print_results(results, wants_metres=described.wants_metres)
    print_taken_rate(recording)
    for line in advice(results.rows, results.widths, parameters):
        console.print(line, soft_wrap=True)
    if damage is not None:
        raise damage


def _track_here(
    frames: Iterable[Frame],
    parameters: TrackerParameters,
    given: GivenState | None,
    results: CableFolder,
    metres: RecordedCableInstruments | None,
) -> RecordingError | None:
    """Track a cable in this process; return why the recording broke off, if it did."""
    tracker = make_tracker(parameters)
    if given is not None:
        tracker.initialise(given)
    with metres or nullcontext():
        return follow_all(frames, lambda frame: track_frame(frame, tracker, results, metres))


def _initial_state_of_node(start: str, given: GivenState | None) -> str:
    """Return the tracker node's parameter that starts it in the same way: it knows no truth."""
    return format_initial_state(given.state) if given and start == TRUTH else start


def _print_results(results: CableFolder, *, wants_metres: bool) -> None:
    print_statuses([row.status for row in results.rows])
    print_events(results.rows)
    note = metres_note(results.rows) if wants_metres else ""
    if note:
        console.print(note, soft_wrap=True)
    print_median_time([row.ms for row in results.rows])
    if results.truths:
        _print_errors(summarise_errors(results.rows, results.truths))
    print_files(results.path, results.names)


def _print_errors(summary: ErrorSummary) -> None:
    console.print(
        f"{summary.claimed} of {summary.labelled} labelled frames claimed;"
        f" {summary.share_off:.1%} of those off by more than w/2 or 8 deg"
        if summary.claimed
        else f"none of {summary.labelled} labelled frames claimed",
        soft_wrap=True,
    )
    if not summary.claimed:
        return
    errors = summary.errors
    columns = (errors.bias, errors.rmse, errors.median, errors.percentile_95)
    rows = [
        (shown.heading, *(f"{column[index] * shown.factor:.2f}" for column in columns))
        for index, shown in enumerate(POSE_COMPONENTS)
    ]
    headings = ("", "bias", "RMSE", "median", "95th percentile")
    print_table("errors against ground truth", headings, rows)
