"""The exceptions of cable_tracker.

Every message is one line, says what is wrong with what, and what the user can do about it.
"""

from __future__ import annotations

from pathlib import Path

EXIT_USER_ERROR = 2
"""Exit code of a process that ends because the user must do something."""

_LONGEST_REASON = 200


class CableTrackerError(Exception):
    """Base of all errors that cable_tracker raises on purpose."""


class ParameterError(CableTrackerError):
    """A parameter value, or a set of values together, is not acceptable."""


class FrameError(CableTrackerError):
    """One frame cannot be used. The filter has not moved."""


class RecordingError(CableTrackerError):
    """A recording is missing, empty, damaged, or holds no images."""


class UnreachableError(RecordingError):
    """A recording is not there or cannot be read, perhaps only for now: a disk is not mounted."""


class OutputError(CableTrackerError):
    """A result cannot be written where the user asked for it."""


class ResourceError(CableTrackerError):
    """What the package needs (a file that ships with it, another package) cannot be used."""


class MetricError(CableTrackerError):
    """A step between pixels and metres cannot be computed."""


class RosError(CableTrackerError):
    """ROS is missing, or the processes do not find each other."""


class GuiError(CableTrackerError):
    """The browser's windows cannot be served."""


def one_line(error: BaseException) -> str:
    """Return what an exception says, on one line of bearable length."""
    text = " ".join(str(error).split())
    return (text or type(error).__name__)[:_LONGEST_REASON]


def write_failure(path: Path, error: Exception) -> OutputError:
    """Return the error that says that a file or folder cannot be written, and why; notes go on."""
    reason = getattr(error, "strerror", None) or one_line(error)
    failure = OutputError(
        f"{path}: cannot be written ({reason}); check the folder and its free space"
    )
    for note in getattr(error, "__notes__", ()):
        failure.add_note(note)
    return failure


def read_failure(path: Path, error: OSError) -> UnreachableError:
    """Return the error that says that a file or folder cannot be read, and why."""
    is_missing = isinstance(error, FileNotFoundError | NotADirectoryError)
    advice = "check the path" if is_missing else "check its permissions"
    if isinstance(error, IsADirectoryError):
        advice = "name a file in it"
    return UnreachableError(f"{path}: cannot be read ({error.strerror}); {advice}")
