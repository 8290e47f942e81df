"""Parameters of the nodes that are not the filter's."""

from __future__ import annotations

from cable_tracker.cable.parameters import ParameterSpec
from cable_tracker.cable.presets import PRESETS


def word(name: str, default: str, meaning: str, choices: tuple[str, ...] = ()) -> ParameterSpec:
    """Make a row of the table for a word, or a text if there are no choices."""
    return ParameterSpec(name, str, default, "", meaning, None, None, choices)


def number(
    name: str, default: float, unit: str, limits: tuple[float, float], meaning: str
) -> ParameterSpec:
    """Make a row of the table for a number."""
    return ParameterSpec(name, float, default, unit, meaning, limits[0], limits[1], ())


def flag(name: str, default: bool, meaning: str) -> ParameterSpec:
    """Make a row of the table for a switch."""
    return ParameterSpec(name, bool, default, "", meaning, None, None, ())


TRACKER_START_PARAMETERS = (
    word("preset", "default", "Values that the other parameters start from.", tuple(PRESETS)),
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
"""Read at start only."""

TRACKER_RUNTIME_PARAMETERS = (
    word(
        "initial_state",
        "random",
        "Where start and reset begin: `random`, or `d,alpha,w,beta` in px and rad.",
    ),
    number(
        "input_timeout", 1.0, "s", (0.05, 3600.0), "Without a frame for this long: STALE INPUT."
    ),
    number(
        "diagnostics_period", 1.0, "s", (0.05, 3600.0), "Time between two messages on /diagnostics."
    ),
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
    flag("wait_for_tracker", False, "Begin only when somebody subscribes; always so in lockstep."),
    flag("paused", False, "Begin paused."),
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

TRACKER_NODE_PARAMETERS = (*TRACKER_START_PARAMETERS, *TRACKER_RUNTIME_PARAMETERS)
REPLAY_NODE_PARAMETERS = (*REPLAY_START_PARAMETERS, *REPLAY_RUNTIME_PARAMETERS)
