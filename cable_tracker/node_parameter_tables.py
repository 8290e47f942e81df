"""Parameters of the nodes that are not the filter's."""

from __future__ import annotations

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.target.parameters.presets import TARGET_PRESETS
from cable_tracker.tracking.parameter_table import ParameterSpec


def word(name: str, default: str, meaning: str, choices: tuple[str, ...] = ()) -> ParameterSpec:
    """Make a row of the table for a word, or a text if there are no choices."""
    return ParameterSpec(name, str, default, "", meaning, None, None, choices)


def number(
    name: str, default: float, unit: str, limits: tuple[float, float], meaning: str
) -> ParameterSpec:
    """Make a row of the table for a number."""
    return ParameterSpec(name, float, default, unit, meaning, limits[0], limits[1], ())


def count(name: str, default: int, limits: tuple[int, int], meaning: str) -> ParameterSpec:
    """Make a row of the table for a whole number."""
    return ParameterSpec(name, int, default, "", meaning, limits[0], limits[1], ())


def flag(name: str, default: bool, meaning: str) -> ParameterSpec:
    """Make a row of the table for a switch."""
    return ParameterSpec(name, bool, default, "", meaning, None, None, ())


CAMERA_START_PARAMETERS = (
    word(
        "image_transport",
        "raw",
        "Topic to read: `image` or `image/compressed`.",
        ("raw", "compressed"),
    ),
    word(
        "image_reliability",
        "best_effort",
        "QoS of the image subscription; `reliable` loses no frame and needs a reliable camera.",
        ("best_effort", "reliable"),
    ),
)
"""Of every node that tracks something in a camera's images; read at start only."""

TRACKER_OWN_START_PARAMETERS = (
    word("preset", "default", "Values that the other parameters start from.", tuple(PRESETS)),
    word(
        "instrument_reliability",
        "best_effort",
        "QoS of the subscriptions to `camera_info`, `altitude`, `imu` and `odometry`.",
        ("best_effort", "reliable"),
    ),
)
TRACKER_START_PARAMETERS = (*TRACKER_OWN_START_PARAMETERS, *CAMERA_START_PARAMETERS)
"""Read at start only."""

METRIC_PARAMETERS = (
    number("camera_x", 0.0, "m", (-100.0, 100.0), "Camera in base_link: forward."),
    number("camera_y", 0.0, "m", (-100.0, 100.0), "Camera in base_link: to the left."),
    number("camera_z", 0.0, "m", (-100.0, 100.0), "Camera in base_link: upwards."),
    number("camera_roll", 0.0, "deg", (-180.0, 180.0), "Camera turned about its line of sight."),
    number(
        "camera_pitch",
        90.0,
        "deg",
        (-180.0, 180.0),
        "Camera tilted; 90: straight down, the top of the image to the front; 0: straight ahead.",
    ),
    number("camera_yaw", 0.0, "deg", (-180.0, 180.0), "Camera turned to the left."),
    flag("image_is_rectified", False, "The images are rectified: use P of camera_info, not K, D."),
    word("base_frame", "base_link", "frame_id of `cross_track`."),
    number("look_ahead", 1.0, "m", (0.0, 100.0), "Distance ahead for `cross_track_ahead`."),
    number("cable_height", 0.0, "m", (0.0, 10.0), "Height of the cable's axis above the sea bed."),
    number(
        "fixed_altitude",
        0.0,
        "m",
        (0.0, 200.0),
        "Altitude where no `altitude` comes, or the last is older than `instrument_timeout`;"
        " 0: none.",
    ),
    number("altimeter_x", 0.0, "m", (-100.0, 100.0), "Altimeter in base_link: forwards."),
    number("altimeter_y", 0.0, "m", (-100.0, 100.0), "Altimeter in base_link: to the left."),
    number("altimeter_z", 0.0, "m", (-100.0, 100.0), "Altimeter in base_link: upwards."),
    flag(
        "altitude_is_vertical",
        False,
        "`altitude` is the vertical distance, not that along the vehicle's own axis.",
    ),
    number("altitude_sigma", 0.01, "share", (0.0, 1.0), "Doubt about the altitude."),
    number("level_sigma", 2.0, "deg", (0.0, 45.0), "Doubt about roll and pitch without `imu`."),
    number("imu_sigma", 0.3, "deg", (0.0, 45.0), "Least doubt about roll and pitch of `imu`."),
    flag("motion_aid", True, "Let `odometry` predict how the cable moves in the image."),
    number(
        "velocity_sigma",
        0.02,
        "m/s",
        (0.0, 10.0),
        "Least doubt about the velocities of `odometry`.",
    ),
    number(
        "turn_sigma",
        0.3,
        "deg/s",
        (0.0, 90.0),
        "Least doubt about the rates of turn of `odometry`.",
    ),
    number(
        "instrument_timeout",
        1.0,
        "s",
        (0.01, 3600.0),
        "Measurements that are older than this at the time of a frame do not count.",
    ),
    number(
        "instrument_wait",
        0.0,
        "s",
        (0.0, 60.0),
        "Hold a frame back for at most so long, until `camera_info` and, of its time or later,"
        " `altitude`, `imu` and `odometry` have come; at most 10 frames wait; 0: do not wait.",
    ),
)
"""For `cross_track`; see docs/metric.md."""

CAMERA_RUNTIME_PARAMETERS = (
    number(
        "input_timeout",
        1.0,
        "s",
        (0.05, 3600.0),
        "Without a usable frame for this long: STALE INPUT.",
    ),
    number(
        "frozen_timeout",
        2.0,
        "s",
        (0.0, 3600.0),
        "The same picture for this long, by its stamps: FROZEN INPUT; 0: never.",
    ),
    number(
        "diagnostics_period", 1.0, "s", (0.05, 3600.0), "Time between two messages on /diagnostics."
    ),
)
"""Of every node that tracks something in a camera's images; may be changed at any time."""

TRACKER_RUNTIME_PARAMETERS = (
    word(
        "initial_state",
        "random",
        "Where start and reset begin: `random`, `d,alpha,w,beta` in px and rad, or a detector:"
        " `hough`, `segmentation`, `lsd`, `texture`.",
    ),
    *CAMERA_RUNTIME_PARAMETERS,
    *METRIC_PARAMETERS,
)
"""May be changed at any time."""

TARGET_OWN_START_PARAMETERS = (
    word(
        "preset", "default", "Values that the other parameters start from.", tuple(TARGET_PRESETS)
    ),
    count(
        "target_count",
        1,
        (1, 16),
        "Targets to follow; of several, each has its topics in a namespace `target_0`, ...",
    ),
    word(
        "instrument_reliability",
        "best_effort",
        "QoS of the subscriptions to `camera_info`, `imu` and `odometry`.",
        ("best_effort", "reliable"),
    ),
)
TARGET_START_PARAMETERS = (*TARGET_OWN_START_PARAMETERS, *CAMERA_START_PARAMETERS)
"""Read at start only."""

MOUNTING_PARAMETERS = (
    "camera_x", "camera_y", "camera_z", "camera_roll", "camera_pitch", "camera_yaw",
)  # fmt: skip
"""Parameters that say where the camera is in base_link, and how it is turned."""

TARGET_METRIC_PARAMETERS = (
    *(
        spec
        for spec in METRIC_PARAMETERS
        if spec.name in MOUNTING_PARAMETERS and spec.name != "camera_pitch"
    ),
    number(
        "camera_pitch",
        0.0,
        "deg",
        (-180.0, 180.0),
        "Camera tilted; 0: straight ahead; 90: straight down.",
    ),
    *(spec for spec in METRIC_PARAMETERS if spec.name == "image_is_rectified"),
    word("base_frame", "base_link", "frame_id of `relative_pose`."),
    number(
        "target_size",
        0.0,
        "m",
        (0.0, 1000.0),
        "Root of the area that the target shows; 0: not known, range by parallax only.",
    ),
    flag("motion_aid", True, "Let `odometry` or `imu` take turns of the camera out."),
    number(
        "instrument_wait",
        0.0,
        "s",
        (0.0, 60.0),
        "Hold a frame back for at most so long, until `camera_info` and, of its time or later,"
        " those of `odometry` and `imu` that speak at all have come, or for all of it while neither"
        " has spoken; at most 10 frames wait; 0: do not wait.",
    ),
)
"""For `bearing`, `relative_pose` and turns of the camera; see docs/targets.md."""

TARGET_RUNTIME_PARAMETERS = (
    word(
        "initial_target",
        "wait",
        "Where start and reset begin: `wait` for a mark on the topic, `detect`, or boxes"
        " `x0,y0,x1,y1` in px from the top left, divided by `;`.",
    ),
    *CAMERA_RUNTIME_PARAMETERS,
    *TARGET_METRIC_PARAMETERS,
)
"""May be changed at any time."""

REPLAY_START_PARAMETERS = (
    word("source", "", "Recording: a bag, a video, a folder of images, or a sequence file."),
    word("topic", "", "Image topic to take from a bag; needed only where it has several."),
    word("truth", "", "Sequence file with labels for a recording that has none."),
    number("frame_rate", 25.0, "1/s", (0.01, 1e4), "Rate of image folders, which have no times."),
    flag("publish_clock", False, "Publish the frames' times on /clock."),
    flag("lockstep", False, "Send a frame when the tracker's `state` for the last has come."),
    number(
        "answer_timeout", 30.0, "s", (0.1, 3600.0), "Lockstep: give up after waiting this long."
    ),
    flag(
        "wait_for_tracker",
        True,
        "Begin when a node subscribes and no tracker is warming up; always so in lockstep.",
    ),
    flag("instruments", True, "Send what else a bag holds: calibration, altitude, imu, ..."),
    word("vehicle", "", "The user's `vehicle.yaml`; else that in the bag's folder."),
    *(
        word(
            f"{instrument}_topic",
            "",
            f"Topic of the bag to send as `{instrument}`; needed only where it has several of its"
            f" type. `none`: send no `{instrument}`.",
        )
        for instrument in ("camera_info", "altitude", "imu", "odometry", "fix")
    ),
    flag("paused", False, "Begin paused."),
    flag("allow_outside", False, "Let a sequence file name files outside its folder."),
    flag("skip_bad_frames", False, "Send frames that cannot be decoded, instead of stopping."),
)
"""Read at start only."""

REPLAY_RUNTIME_PARAMETERS = (
    number("rate", 1.0, "", (0.01, 100.0), "Speed, as a multiple of the recording's own timing."),
    number(
        "start", 0.0, "s", (0.0, 1e6), "Begin this long after the first frame; see `~/restart`."
    ),
    number(
        "duration", 0.0, "s", (0.0, 1e6), "Stop after this much recorded time; 0 for all of it."
    ),
    flag("loop", False, "Begin again at the end."),
)
"""May be changed at any time; `start` takes effect at the next restart."""

VEHICLE_PARAMETERS = (
    count("image_width", 320, (32, 4096), "Width of the camera's images [px]."),
    count("image_height", 240, (32, 4096), "Height of the camera's images [px]."),
    number("rate", 12.5, "1/s", (1.0, 100.0), "Frames per second."),
    flag("publish_clock", False, "Publish the simulated time on /clock."),
    flag("lockstep", False, "Send a frame when a `cmd_vel` has come for the last."),
    number("answer_timeout", 60.0, "s", (0.1, 3600.0), "Lockstep: give up after waiting so long."),
    count("image_readers", 1, (0, 100), "Begin when so many nodes subscribe to `image`."),
    count("odometry_readers", 0, (0, 100), "Begin when so many nodes subscribe to `odometry`."),
    count("truth_readers", 0, (0, 100), "Begin when so many nodes subscribe to the ground truth."),
    number(
        "command_timeout",
        0.5,
        "s",
        (0.05, 60.0),
        "Without a `cmd_vel` for so long the vehicle stops; not in lockstep.",
    ),
)
"""Of every node that simulates a vehicle; read at start only."""

WORLD_SEED = count(
    "seed", 0, (0, 2**31 - 1), "The same one gives the same world and the same errors."
)
"""Of every node that simulates a vehicle, the first of its table."""

SIMULATOR_PARAMETERS = (
    WORLD_SEED,
    number("length", 100.0, "m", (1.0, 1e5), "Length of the cable; at its end the node ends."),
    number(
        "buried",
        5.0,
        "m",
        (0.0, 1e5),
        "Length of the stretch in the middle of the cable that lies under sand.",
    ),
    number("altitude", 2.0, "m", (0.3, 20.0), "Altitude that the vehicle keeps."),
    number("current", 0.1, "m/s", (0.0, 2.0), "Speed of the water; its direction is drawn."),
    *VEHICLE_PARAMETERS,
    number(
        "patience",
        60.0,
        "s",
        (1.0, 1e6),
        "Without a new metre of cable for so long of simulated time the node ends; drift does not"
        " count.",
    ),
    number(
        "standstill",
        0.0,
        "s",
        (0.0, 1e6),
        "When `cmd_vel` has asked to stand still for so long the node ends; 0: never for that.",
    ),
)
"""Read at start only."""

TARGET_SIMULATOR_PARAMETERS = (
    WORLD_SEED,
    number("duration", 300.0, "s", (1.0, 1e5), "After so long the node ends."),
    number("speed", 0.35, "m/s", (0.0, 2.0), "Speed of the target."),
    number("hidden_every", 50.0, "s", (5.0, 1e5), "Time from one cloud of silt to the next."),
    number("hidden_for", 6.0, "s", (0.0, 1e4), "How long a cloud of silt hides the target."),
    number("altitude", 5.0, "m", (0.3, 20.0), "Altitude at which the vehicle begins."),
    number("current", 0.05, "m/s", (0.0, 2.0), "Speed of the water; its direction is drawn."),
    *VEHICLE_PARAMETERS,
)
"""Read at start only."""

STEPWISE = flag(
    "lockstep", False, "Answer every `state` with one `cmd_vel`, however long it takes."
)
STATE_TIMEOUT = number(
    "state_timeout",
    1.0,
    "s",
    (0.05, 60.0),
    "Without a `state`, or with refused frames alone, for so long: stop the vehicle.",
)
"""Of every node that steers by a tracker's `state`, as `STEPWISE`."""

FOLLOWER_PARAMETERS = (
    number("distance", 2.5, "m", (0.3, 100.0), "Distance from the target that is kept."),
    number("gain", 0.5, "1/s", (0.0, 10.0), "Surge for each metre too far."),
    number(
        "integral_gain",
        0.06,
        "1/s²",
        (0.0, 10.0),
        "Integral gain against a lasting error of the distance.",
    ),
    number("most_surge", 0.8, "m/s", (0.0, 5.0), "Fastest surge forward; backward half of it."),
    number("turn_gain", 1.0, "1/s", (0.0, 10.0), "Rate of turn per radian of bearing."),
    number("most_turn", 0.5, "rad/s", (0.01, 3.0), "Fastest turn."),
    number(
        "climb_gain", 0.5, "1/s", (0.0, 10.0), "Heave for each metre that the target is higher."
    ),
    number("most_heave", 0.2, "m/s", (0.0, 2.0), "Fastest heave, up and down."),
    number("memory_time", 8.0, "s", (0.0, 600.0), "A lost target is followed on for so long."),
    number(
        "give_up",
        60.0,
        "s",
        (0.0, 1e5),
        "After so long without the target the vehicle stands still.",
    ),
    number(
        "search_turn",
        0.3,
        "rad/s",
        (0.0, 3.0),
        "Rate of turn while the target is looked for, at most `most_turn`.",
    ),
    number(
        "search_angle",
        0.4,
        "rad",
        (0.05, 3.0),
        "Search: angle to either side at first; then ever farther.",
    ),
    STEPWISE,
    number(
        "settle_time",
        0.05,
        "s",
        (0.0, 60.0),
        "How long to wait for the `relative_pose` that belongs to a `state`.",
    ),
    STATE_TIMEOUT,
)
"""Read at start only."""

CONTROLLER_PARAMETERS = (
    number("speed", 0.5, "m/s", (0.0, 5.0), "Speed forward, through the water."),
    number("look_ahead", 1.2, "m", (0.1, 50.0), "Steer for the point of the cable so far ahead."),
    number("integral_gain", 0.1, "1/s", (0.0, 1.0), "Integral gain against current."),
    number("turn_gain", 1.2, "1/s", (0.0, 10.0), "Rate of turn per radian off the course."),
    number("most_turn", 0.5, "rad/s", (0.01, 3.0), "Fastest turn."),
    number("search_speed", 0.35, "m/s", (0.0, 5.0), "Speed while the cable is looked for."),
    number(
        "search_length",
        25.0,
        "m",
        (0.0, 1e4),
        "Search so far along the line where the cable was, then give up.",
    ),
    STEPWISE,
    number(
        "settle_time",
        0.05,
        "s",
        (0.0, 60.0),
        "How long to wait for `cross_track` and `odometry` that belong to a `state`.",
    ),
    STATE_TIMEOUT,
)
"""Read at start only."""

TRACKER_NODE_PARAMETERS = (*TRACKER_START_PARAMETERS, *TRACKER_RUNTIME_PARAMETERS)
TARGET_NODE_PARAMETERS = (*TARGET_START_PARAMETERS, *TARGET_RUNTIME_PARAMETERS)
REPLAY_NODE_PARAMETERS = (*REPLAY_START_PARAMETERS, *REPLAY_RUNTIME_PARAMETERS)
