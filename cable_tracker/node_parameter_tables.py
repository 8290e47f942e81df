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
    """Of every node that tracks something in a camera's images; read at start only."""

    image_transport: str = word(
        "raw", ("raw", "compressed"), "Topic to read: `image` or `image/compressed`."
    )
    image_reliability: str = word(
        "best_effort",
        RELIABILITIES,
        "QoS of the image subscription; `reliable` loses no frame and needs a reliable camera.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraRuntimeParameters(ParameterSet):
    """Of every node that tracks something in a camera's images; may be changed at any time."""

    input_timeout: float = number(
        1.0, "s", 0.05, 3600.0, "Without a usable frame for this long: STALE INPUT."
    )
    frozen_timeout: float = number(
        2.0,
        "s",
        0.0,
        3600.0,
        "The same picture for this long, by its stamps: FROZEN INPUT; 0: never.",
    )
    diagnostics_period: float = number(
        1.0, "s", 0.05, 3600.0, "Time between two messages on /diagnostics."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraParameters(ParameterSet):
    """How the camera is mounted and read, alike for cables and targets but for its pitch."""

    camera_x: float = number(0.0, "m", -100.0, 100.0, "Camera in base_link: forward.")
    camera_y: float = number(0.0, "m", -100.0, 100.0, "Camera in base_link: to the left.")
    camera_z: float = number(0.0, "m", -100.0, 100.0, "Camera in base_link: upwards.")
    camera_roll: float = number(0.0, "deg", -180.0, 180.0, "Camera turned about its line of sight.")
    camera_yaw: float = number(0.0, "deg", -180.0, 180.0, "Camera turned to the left.")
    image_is_rectified: bool = flag(
        False, "The images are rectified: use P of camera_info, not K, D."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CableVehicleParameters(CameraParameters):
    """For `cross_track`, may be changed at any time; see docs/metric.md."""

    camera_pitch: float = number(
        90.0,
        "deg",
        -180.0,
        180.0,
        "Camera tilted; 90: straight down, the top of the image to the front; 0: straight ahead.",
    )
    base_frame: str = word("base_link", (), "frame_id of `cross_track`.")
    look_ahead: float = number(1.0, "m", 0.0, 100.0, "Distance ahead for `cross_track_ahead`.")
    cable_height: float = number(
        0.0, "m", 0.0, 10.0, "Height of the cable's axis above the sea bed."
    )
    fixed_altitude: float = number(
        0.0,
        "m",
        0.0,
        200.0,
        "Altitude where no `altitude` comes, or the last is older than `instrument_timeout`;"
        " 0: none.",
    )
    altimeter_x: float = number(0.0, "m", -100.0, 100.0, "Altimeter in base_link: forwards.")
    altimeter_y: float = number(0.0, "m", -100.0, 100.0, "Altimeter in base_link: to the left.")
    altimeter_z: float = number(0.0, "m", -100.0, 100.0, "Altimeter in base_link: upwards.")
    altitude_is_vertical: bool = flag(
        False, "`altitude` is the vertical distance, not that along the vehicle's own axis."
    )
    altitude_sigma: float = number(0.01, "share", 0.0, 1.0, "Doubt about the altitude.")
    level_sigma: float = number(2.0, "deg", 0.0, 45.0, "Doubt about roll and pitch without `imu`.")
    imu_sigma: float = number(0.3, "deg", 0.0, 45.0, "Least doubt about roll and pitch of `imu`.")
    motion_aid: bool = flag(True, "Let `odometry` predict how the cable moves in the image.")
    velocity_sigma: float = number(
        0.02, "m/s", 0.0, 10.0, "Least doubt about the velocities of `odometry`."
    )
    turn_sigma: float = number(
        0.3, "deg/s", 0.0, 90.0, "Least doubt about the rates of turn of `odometry`."
    )
    instrument_timeout: float = number(
        1.0,
        "s",
        0.01,
        3600.0,
        "Measurements that are older than this at the time of a frame do not count.",
    )
    instrument_wait: float = number(
        0.0,
        "s",
        0.0,
        60.0,
        "Hold a frame back for at most so long, until `camera_info` and, of its time or later,"
        " `altitude`, `imu` and `odometry` have come; at most 10 frames wait; 0: do not wait.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetVehicleParameters(CameraParameters):
    """For `bearing`, `relative_pose` and turns of the camera, may be changed at any time.

    See docs/targets.md.
    """

    camera_pitch: float = number(
        0.0, "deg", -180.0, 180.0, "Camera tilted; 0: straight ahead; 90: straight down."
    )
    base_frame: str = word("base_link", (), "frame_id of `relative_pose`.")
    target_size: float = number(
        0.0,
        "m",
        0.0,
        1000.0,
        "Root of the area that the target shows; 0: not known, range by parallax only.",
    )
    motion_aid: bool = flag(True, "Let `odometry` or `imu` take turns of the camera out.")
    instrument_wait: float = number(
        0.0,
        "s",
        0.0,
        60.0,
        "Hold a frame back for at most so long, until `camera_info` and, of its time or later,"
        " those of `odometry` and `imu` that speak at all have come, or for all of it while neither"
        " has spoken; at most 10 frames wait; 0: do not wait.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerStartParameters(ParameterSet):
    """Of the node `tracker` alone; read at start only."""

    preset: str = word("default", tuple(PRESETS), "Values that the other parameters start from.")
    instrument_reliability: str = word(
        "best_effort",
        RELIABILITIES,
        "QoS of the subscriptions to `camera_info`, `altitude`, `imu` and `odometry`.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerRuntimeParameters(ParameterSet):
    """Of the node `tracker` alone; may be changed at any time."""

    initial_state: str = word(
        "random",
        (),
        "Where start and reset begin: `random`, `d,alpha,w,beta` in px and rad, or a detector:"
        " `hough`, `segmentation`, `lsd`, `texture`.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetStartParameters(ParameterSet):
    """Of the node `target_tracker` alone; read at start only."""

    preset: str = word(
        "default", tuple(TARGET_PRESETS), "Values that the other parameters start from."
    )
    target_count: int = number(
        1,
        "",
        1,
        16,
        "Targets to follow; of several, each has its topics in a namespace `target_0`, ...",
    )
    instrument_reliability: str = word(
        "best_effort",
        RELIABILITIES,
        "QoS of the subscriptions to `camera_info`, `imu` and `odometry`.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetRuntimeParameters(ParameterSet):
    """Of the node `target_tracker` alone; may be changed at any time."""

    initial_target: str = word(
        "wait",
        (),
        "Where start and reset begin: `wait` for a mark on the topic, `detect`, or boxes"
        " `x0,y0,x1,y1` in px from the top left, divided by `;`.",
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
    """Of the node `replay`; read at start only."""

    source: str = word("", (), "Recording: a bag, a video, a folder of images, or a sequence file.")
    topic: str = word("", (), "Image topic to take from a bag; needed only where it has several.")
    truth: str = word("", (), "Sequence file with labels for a recording that has none.")
    frame_rate: float = number(
        25.0, "1/s", 0.01, 1e4, "Rate of image folders, which have no times."
    )
    publish_clock: bool = flag(False, "Publish the frames' times on /clock.")
    lockstep: bool = flag(False, "Send a frame when the tracker's `state` for the last has come.")
    answer_timeout: float = number(
        30.0, "s", 0.1, 3600.0, "Lockstep: give up after waiting this long."
    )
    wait_for_tracker: bool = flag(
        True, "Begin when a node subscribes and no tracker is warming up; always so in lockstep."
    )
    instruments: bool = flag(True, "Send what else a bag holds: calibration, altitude, imu, ...")
    vehicle: str = word("", (), "The user's `vehicle.yaml`; else that in the bag's folder.")
    camera_info_topic: str = _topic_of("camera_info")
    altitude_topic: str = _topic_of("altitude")
    imu_topic: str = _topic_of("imu")
    odometry_topic: str = _topic_of("odometry")
    fix_topic: str = _topic_of("fix")
    paused: bool = flag(False, "Begin paused.")
    allow_outside: bool = flag(False, "Let a sequence file name files outside its folder.")
    skip_bad_frames: bool = flag(False, "Send frames that cannot be decoded, instead of stopping.")


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayRuntimeParameters(ParameterSet):
    """Of the node `replay`; may be changed at any time.

    `start` takes effect at the next restart.
    """

    rate: float = number(
        1.0, "", 0.01, 100.0, "Speed, as a multiple of the recording's own timing."
    )
    start: float = number(
        0.0, "s", 0.0, 1e6, "Begin this long after the first frame; see `~/restart`."
    )
    duration: float = number(
        0.0, "s", 0.0, 1e6, "Stop after this much recorded time; 0 for all of it."
    )
    loop: bool = flag(False, "Begin again at the end.")


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleNodeParameters(ParameterSet):
    """Of every node that simulates a vehicle, beside its world's settings; read at start only."""

    publish_clock: bool = flag(False, "Publish the simulated time on /clock.")
    lockstep: bool = flag(False, "Send a frame when a `cmd_vel` has come for the last.")
    answer_timeout: float = number(
        60.0, "s", 0.1, 3600.0, "Lockstep: give up after waiting so long."
    )
    image_readers: int = number(1, "", 0, 100, "Begin when so many nodes subscribe to `image`.")
    odometry_readers: int = number(
        0, "", 0, 100, "Begin when so many nodes subscribe to `odometry`."
    )
    truth_readers: int = number(
        0, "", 0, 100, "Begin when so many nodes subscribe to the ground truth."
    )
    command_timeout: float = number(
        0.5,
        "s",
        0.05,
        60.0,
        "Without a `cmd_vel` for so long the vehicle stops; not in lockstep.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatorNodeParameters(VehicleNodeParameters):
    """Of the node `simulator`, beside its world's settings; read at start only."""

    patience: float = number(
        60.0,
        "s",
        1.0,
        1e6,
        "Without a new metre of cable for so long of simulated time the node ends; drift does not"
        " count.",
    )
    standstill: float = number(
        0.0,
        "s",
        0.0,
        1e6,
        "When `cmd_vel` has asked to stand still for so long the node ends; 0: never for that.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class GuidanceNodeParameters(ParameterSet):
    """Of `controller` and `follower`, beside their settings; read at start only."""

    lockstep: bool = flag(False, "Answer every `state` with one `cmd_vel`, however long it takes.")
    settle_time: float = number(
        0.05,
        "s",
        0.0,
        60.0,
        "How long to wait for what belongs to a `state`: the place in metres, and `odometry` if the"
        " node listens to it.",
    )
    state_timeout: float = number(
        1.0,
        "s",
        0.05,
        60.0,
        "Without a `state`, or with refused frames alone, for so long: stop the vehicle.",
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
"""Of the node `tracker` beside its filter's."""

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
"""Of the node `target_tracker` beside its filter's."""

MOUNTING_PARAMETERS = (
    "camera_x", "camera_y", "camera_z", "camera_roll", "camera_pitch", "camera_yaw",
)  # fmt: skip
"""Parameters that say where the camera is in base_link, and how it is turned."""
