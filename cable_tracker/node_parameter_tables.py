"""Parameters of the nodes that are neither a filter's nor a simulated world's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.target.parameters.presets import TARGET_PRESETS
from cable_tracker.tracking.parameter_table import (
    ParameterSet,
    flag,
    number,
    parameter_table,
    word,
)

BEST_EFFORT, RELIABLE = RELIABILITIES = ("best_effort", "reliable")


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraStartParameters(ParameterSet):
    """Parameters of every node that tracks in a camera's images; read at start only."""

    image_transport: str = word(
        "raw", ("raw", "compressed"), "Topic of the images: `image` or `image/compressed`."
    )
    image_reliability: str = word(
        "best_effort",
        RELIABILITIES,
        "QoS of the image subscription; `reliable` loses no frame and needs a reliable publisher.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraRuntimeParameters(ParameterSet):
    """Parameters of every node that tracks in a camera's images; may be changed at any time."""

    input_timeout: float = number(
        1.0, "s", 0.05, 3600.0, "Time without a usable frame after which the status is STALE INPUT."
    )
    frozen_timeout: float = number(
        2.0,
        "s",
        0.0,
        3600.0,
        "Time, by the stamps, with the same picture after which the status is FROZEN INPUT; 0:"
        " never.",
    )
    diagnostics_period: float = number(
        1.0, "s", 0.05, 3600.0, "Interval of the messages on /diagnostics."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraParameters(ParameterSet):
    """How the camera is mounted and read, alike for cables and targets but for its pitch."""

    camera_x: float = number(
        0.0, "m", -100.0, 100.0, "Position of the camera in base_link, forward."
    )
    camera_y: float = number(
        0.0, "m", -100.0, 100.0, "Position of the camera in base_link, to the left."
    )
    camera_z: float = number(
        0.0, "m", -100.0, 100.0, "Position of the camera in base_link, upward."
    )
    camera_roll: float = number(
        0.0, "deg", -180.0, 180.0, "Rotation of the camera about its line of sight."
    )
    camera_yaw: float = number(0.0, "deg", -180.0, 180.0, "Rotation of the camera to the left.")
    image_is_rectified: bool = flag(
        False, "The images are rectified: P of camera_info applies, not K and D."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CableVehicleParameters(CameraParameters):
    """Parameters for `cross_track`, may be changed at any time; see docs/metric.md."""

    camera_pitch: float = number(
        90.0,
        "deg",
        -180.0,
        180.0,
        "Tilt of the camera downward; 90: straight down, the top of the image to the front; 0:"
        " straight ahead.",
    )
    base_frame: str = word("base_link", (), "frame_id of `cross_track`.")
    look_ahead: float = number(
        1.0, "m", 0.0, 100.0, "Distance ahead of base_link for which `cross_track_ahead` holds."
    )
    cable_height: float = number(
        0.0, "m", 0.0, 10.0, "Height of the cable's axis above the sea bed."
    )
    fixed_altitude: float = number(
        0.0,
        "m",
        0.0,
        200.0,
        "Altitude while no `altitude` comes, or the last one is older than"
        " `instrument_timeout`; 0: none.",
    )
    altimeter_x: float = number(
        0.0, "m", -100.0, 100.0, "Position of the altimeter in base_link, forward."
    )
    altimeter_y: float = number(
        0.0, "m", -100.0, 100.0, "Position of the altimeter in base_link, to the left."
    )
    altimeter_z: float = number(
        0.0, "m", -100.0, 100.0, "Position of the altimeter in base_link, upward."
    )
    altitude_is_vertical: bool = flag(
        False, "`altitude` is the vertical distance, not that along the vehicle's vertical axis."
    )
    altitude_sigma: float = number(
        0.01, "share", 0.0, 1.0, "Standard deviation of the altitude, relative to it."
    )
    level_sigma: float = number(
        2.0, "deg", 0.0, 45.0, "Standard deviation of roll and pitch without `imu`."
    )
    imu_sigma: float = number(
        0.3, "deg", 0.0, 45.0, "Least standard deviation of roll and pitch from `imu`."
    )
    motion_aid: bool = flag(True, "Predict with `odometry` how the cable moves in the image.")
    velocity_sigma: float = number(
        0.02, "m/s", 0.0, 10.0, "Least standard deviation of the velocities from `odometry`."
    )
    turn_sigma: float = number(
        0.3, "deg/s", 0.0, 90.0, "Least standard deviation of the turn rates from `odometry`."
    )
    instrument_timeout: float = number(
        1.0,
        "s",
        0.01,
        3600.0,
        "Largest age of a measurement at the time of a frame; older ones are not used.",
    )
    instrument_wait: float = number(
        0.0,
        "s",
        0.0,
        60.0,
        "Longest time that a frame is held back until `camera_info` and, of its time or later,"
        " `altitude`, `imu` and `odometry` have come; at most 10 frames wait; 0: none waits.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetVehicleParameters(CameraParameters):
    """Parameters for `bearing`, `relative_pose` and turns of the camera; may be changed any time.

    See docs/targets.md.
    """

    camera_pitch: float = number(
        0.0,
        "deg",
        -180.0,
        180.0,
        "Tilt of the camera downward; 0: straight ahead; 90: straight down.",
    )
    base_frame: str = word("base_link", (), "frame_id of `relative_pose`.")
    target_size: float = number(
        0.0,
        "m",
        0.0,
        1000.0,
        "Square root of the area that the target shows; 0: unknown, the range then comes from"
        " parallax alone.",
    )
    motion_aid: bool = flag(True, "Compensate rotations of the camera with `odometry` or `imu`.")
    instrument_wait: float = number(
        0.0,
        "s",
        0.0,
        60.0,
        "Longest time that a frame is held back until `camera_info` and, of its time or later,"
        " those of `odometry` and `imu` that are published have come; as long as neither has"
        " come, all of this time; at most 10 frames wait; 0: none waits.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerStartParameters(ParameterSet):
    """Parameters of the node `tracker` alone; read at start only."""

    preset: str = word(
        "default", tuple(PRESETS), "Preset that gives the other parameters their values."
    )
    instrument_reliability: str = word(
        "best_effort",
        RELIABILITIES,
        "QoS of the subscriptions to `camera_info`, `altitude`, `imu` and `odometry`.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerRuntimeParameters(ParameterSet):
    """Parameters of the node `tracker` alone; may be changed at any time."""

    initial_state: str = word(
        "random",
        (),
        "State at the start and after a reset: `random`, `d,alpha,w,beta` in px and rad, or"
        " that of a detector: `hough`, `segmentation`, `lsd`, `texture`.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetStartParameters(ParameterSet):
    """Parameters of the node `target_tracker` alone; read at start only."""

    preset: str = word(
        "default", tuple(TARGET_PRESETS), "Preset that gives the other parameters their values."
    )
    target_count: int = number(
        1,
        "",
        1,
        16,
        "Number of targets; with several, each has its topics in a namespace `target_0`, ...",
    )
    instrument_reliability: str = word(
        "best_effort",
        RELIABILITIES,
        "QoS of the subscriptions to `camera_info`, `imu` and `odometry`.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetRuntimeParameters(ParameterSet):
    """Parameters of the node `target_tracker` alone; may be changed at any time."""

    initial_target: str = word(
        "wait",
        (),
        "Target at the start and after a reset: `wait` for a mark on the topic, `detect`, or"
        " boxes `x0,y0,x1,y1` in px from the top left, separated by `;`.",
    )


def _topic_of(instrument: str) -> Any:  # noqa: ANN401
    return word(
        "",
        (),
        f"Topic of the bag to send as `{instrument}`; needed only where it has several of its"
        f" type. `none`: send no `{instrument}`.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayStartParameters(ParameterSet):
    """Parameters of the node `replay`; read at start only."""

    source: str = word("", (), "Recording: a bag, a video, a folder of images, or a sequence file.")
    topic: str = word("", (), "Image topic of a bag; needed only if it has several.")
    truth: str = word("", (), "Sequence file with labels for a recording that has none.")
    frame_rate: float = number(
        25.0, "1/s", 0.01, 1e4, "Frame rate of image folders, which have no times."
    )
    publish_clock: bool = flag(False, "Publish the frames' times on /clock.")
    lockstep: bool = flag(
        False, "Send each frame only after the tracker's `state` for the previous one has come."
    )
    answer_timeout: float = number(
        30.0,
        "s",
        0.1,
        3600.0,
        "Lockstep: longest wait for an answer, after which the node gives up.",
    )
    wait_for_tracker: bool = flag(
        True,
        "Begin only when a node subscribes and no tracker is warming up; always so in lockstep.",
    )
    instruments: bool = flag(
        True, "Send the bag's instruments too: calibration, altitude, imu, ..."
    )
    vehicle: str = word(
        "", (), "Path of the user's `vehicle.yaml`; empty: the one in the bag's folder."
    )
    camera_info_topic: str = _topic_of("camera_info")
    altitude_topic: str = _topic_of("altitude")
    imu_topic: str = _topic_of("imu")
    odometry_topic: str = _topic_of("odometry")
    fix_topic: str = _topic_of("fix")
    paused: bool = flag(False, "Begin paused.")
    allow_outside: bool = flag(False, "Allow a sequence file to name files outside its folder.")
    skip_bad_frames: bool = flag(False, "Send frames that cannot be decoded, instead of stopping.")


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayRuntimeParameters(ParameterSet):
    """Parameters of the node `replay`; may be changed at any time.

    `start` takes effect at the next restart.
    """

    rate: float = number(
        1.0, "", 0.01, 100.0, "Speed of the replay, as a multiple of the recording's."
    )
    start: float = number(
        0.0,
        "s",
        0.0,
        1e6,
        "Time after the first frame at which the replay begins; see `~/restart`.",
    )
    duration: float = number(
        0.0, "s", 0.0, 1e6, "Recorded time after which the replay stops; 0: at the end."
    )
    loop: bool = flag(False, "Begin again at the end of the recording.")


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleNodeParameters(ParameterSet):
    """Parameters of nodes that simulate a vehicle, beside its world's; read at start only."""

    publish_clock: bool = flag(False, "Publish the simulated time on /clock.")
    lockstep: bool = flag(
        False, "Send each frame only after a `cmd_vel` for the previous one has come."
    )
    answer_timeout: float = number(
        60.0,
        "s",
        0.1,
        3600.0,
        "Lockstep: longest wait for an answer, after which the node gives up.",
    )
    image_readers: int = number(
        1,
        "",
        0,
        100,
        "Number of subscriptions to `image` that the node waits for before it begins.",
    )
    odometry_readers: int = number(
        0,
        "",
        0,
        100,
        "Number of subscriptions to `odometry` that the node waits for before it begins.",
    )
    truth_readers: int = number(
        0,
        "",
        0,
        100,
        "Number of subscriptions to the ground truth that the node waits for before it begins.",
    )
    command_timeout: float = number(
        0.5,
        "s",
        0.05,
        60.0,
        "Time without a `cmd_vel` after which the vehicle stops; not in lockstep.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatorNodeParameters(VehicleNodeParameters):
    """Parameters of the node `simulator`, beside its world's; read at start only."""

    patience: float = number(
        60.0,
        "s",
        1.0,
        1e6,
        "Simulated time without a new metre of cable after which the node ends; drift does not"
        " count as progress.",
    )
    standstill: float = number(
        0.0,
        "s",
        0.0,
        1e6,
        "Time of `cmd_vel` messages that ask to stand still after which the node ends; 0: it"
        " does not.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class GuidanceNodeParameters(ParameterSet):
    """Parameters of `controller` and `follower`, beside their settings; read at start only."""

    lockstep: bool = flag(False, "Answer each `state` with one `cmd_vel`, however long it takes.")
    settle_time: float = number(
        0.05,
        "s",
        0.0,
        60.0,
        "Longest wait for the messages that belong to a `state`: the position in metres, and"
        " `odometry` if the node subscribes to it.",
    )
    state_timeout: float = number(
        1.0,
        "s",
        0.05,
        60.0,
        "Time without a `state`, or with refused frames only, after which the vehicle is stopped.",
    )


TRACKER_START_PARAMETERS = (
    *parameter_table(TrackerStartParameters),
    *parameter_table(CameraStartParameters),
)
TRACKER_RUNTIME_PARAMETERS = (
    *parameter_table(TrackerRuntimeParameters),
    *parameter_table(CameraRuntimeParameters),
    *parameter_table(CableVehicleParameters),
)
TRACKER_NODE_PARAMETERS = (*TRACKER_START_PARAMETERS, *TRACKER_RUNTIME_PARAMETERS)
"""Parameters of the node `tracker` beside its filter's."""

TARGET_START_PARAMETERS = (
    *parameter_table(TargetStartParameters),
    *parameter_table(CameraStartParameters),
)
TARGET_RUNTIME_PARAMETERS = (
    *parameter_table(TargetRuntimeParameters),
    *parameter_table(CameraRuntimeParameters),
    *parameter_table(TargetVehicleParameters),
)
TARGET_NODE_PARAMETERS = (*TARGET_START_PARAMETERS, *TARGET_RUNTIME_PARAMETERS)
"""Parameters of the node `target_tracker` beside its filter's."""

MOUNTING_PARAMETERS = (
    "camera_x", "camera_y", "camera_z", "camera_roll", "camera_pitch", "camera_yaw",
)  # fmt: skip
"""Parameters that say where the camera is in base_link, and how it is turned."""
