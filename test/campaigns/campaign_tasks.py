"""Tasks that worker processes can load: pickled by their names, as those of the package are."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cable_tracker.atomic_output import any_name
from cable_tracker.errors import RecordingError, UnreachableError


@dataclass(frozen=True)
class Square:
    """Writes the square of a number."""

    number: int
    parameter: str = "usual"

    @property
    def name(self) -> str:
        return f"number_{self.number}"

    def fingerprint(self) -> str:
        return f"{self.number} {self.parameter}"

    is_own_name = staticmethod(any_name)

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        (folder / "square.txt").write_text(str(self.number**2))
        advance(1)


@dataclass(frozen=True)
class Waiting(Square):
    """Waits for a file, and leaves nothing."""

    until: str = ""

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        while not Path(self.until).exists():
            time.sleep(0.05)
        raise RecordingError(f"{self.name}: waited in vain")


@dataclass(frozen=True)
class Failing(Square):
    """Cannot be done."""

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        raise RecordingError(f"{self.name}: holds no frames")


@dataclass(frozen=True)
class Unreachable(Square):
    """Lies on a disk that is not mounted."""

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        raise UnreachableError(f"{self.name}: no such file")


@dataclass(frozen=True)
class Erring(Square):
    """Has a bug."""

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        raise ZeroDivisionError("division\nby zero")


@dataclass(frozen=True)
class KillsItsWorkerOnce(Square):
    """Ends its own process the first time that it is done."""

    traces: str = ""

    def run(self, folder: Path, advance: Callable[[int], None]) -> None:
        trace = Path(self.traces) / self.name
        if not trace.exists():
            trace.write_text("")
            os.kill(os.getpid(), signal.SIGKILL)
        super().run(folder, advance)


@dataclass(frozen=True)
class SquareResult:
    """Gives a small result back."""

    number: int

    def run(self, advance: Callable[[int], None]) -> int:
        if self.number < 0:
            raise RecordingError("a negative number")
        advance(1)
        return self.number**2


def done_elsewhere(task: Square, *_arguments: object) -> str:
    """Stand for a worker on a machine that does not share the folder of the results."""
    return task.fingerprint()


def become_another_version() -> None:
    """Make a worker process one of another version of the package."""
    from cable_tracker.campaigns import cluster  # noqa: PLC0415

    cluster.__version__ = "0.0.9"
