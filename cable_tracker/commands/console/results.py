"""Messages and output folders of the commands that track a recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Protocol

from cable_tracker.commands.console.terminal import console, print_note
from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.storage_files import METADATA
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.tracking.status import REFUSED

MOST_EVENTS = 5
"""Number of events of frames that are printed one by one."""


class TrackedFrame(Protocol):
    """Row of a table of results, of a cable or of a target."""

    @property
    def frame(self) -> int:
        """Number of the frame in the recording."""

    @property
    def status(self) -> str:
        """Status of the frame."""

    @property
    def event(self) -> str:
        """Why the frame was refused, or what else happened with it; empty: nothing."""


def folder_beside(source: Path, ending: str) -> Path:
    """Return the folder for results when the user names none: in the present one, by the source."""
    resolved = source.resolve()
    if resolved.name == METADATA:
        # Every bag has a file of this name, which stands for its folder.
        resolved = resolved.parent
    stem = resolved.name if resolved.is_dir() else resolved.stem
    return Path(f"{stem}_{ending}")


def need_usable_frames(
    source: Path, rows: Sequence[TrackedFrame], damage: RecordingError | None
) -> None:
    """Check that a run has at least one usable frame.

    Parameters
    ----------
    rows : sequence of TrackedFrame
        All frames.
    damage : RecordingError or None
        Error at which the recording broke off.

    Raises
    ------
    RecordingError
        No frame could be used.
    """
    if any(row.status != REFUSED for row in rows):
        return
    if not rows:
        raise damage or RecordingError(f"{source}: holds no frames; record it again")
    raise damage or RecordingError(
        f"{source}: none of the {len(rows)} frames can be used; record it again. The first one:"
        f" {rows[0].event}"
    )


def print_statuses(statuses: Sequence[str]) -> None:
    """Say how many frames there are of each status."""
    counts = {status: statuses.count(status) for status in dict.fromkeys(statuses)}
    summary = ", ".join(f"{count} {status}" for status, count in counts.items())
    console.print(f"{len(statuses)} frames: {summary}", soft_wrap=True)


def event_notes(rows: Sequence[TrackedFrame]) -> list[str]:
    """Say why frames were refused, and what else happened: a new start of the tracker, a notice."""
    notable = [row for row in rows if row.status == REFUSED or row.event]
    refused = [row for row in notable if row.status == REFUSED]
    others = [row for row in notable if row.status != REFUSED]
    notes = []
    if refused:
        first = refused[0]
        notes.append(
            f"{len(refused)} of {len(rows)} frames refused; the first, frame {first.frame}:"
            f" {first.event}"
        )
    notes += [f"frame {row.frame}: {row.event}" for row in others[:MOST_EVENTS]]
    if len(others) > MOST_EVENTS:
        notes.append(f"and so {len(others) - MOST_EVENTS} frames more")
    return notes


def print_events(rows: Sequence[TrackedFrame]) -> None:
    """Print the `event_notes`."""
    for note in event_notes(rows):
        print_note(note)


def metres_note(rows: Sequence[EstimateRow]) -> str:
    """Return for how many claims the cable is known in metres, and why not for the others.

    Empty where no cable is claimed.
    """
    claims = [row for row in rows if row.state is not None]
    known = sum(row.metres is not None for row in claims)
    missing = Counter(row.no_metres.partition(":")[0] for row in claims if row.metres is None)
    reasons = missing.most_common()
    if not claims or not reasons:
        return f"metres for {known} of {known} claims" if claims else ""
    if not known and len(reasons) == 1:
        return f"no metres: {reasons[0][0]} ({len(claims)} claims)"
    without = ", ".join(f"{reason} ({count})" for reason, count in reasons)
    return f"metres for {known} of {len(claims)} claims; no metres: {without}"


def print_median_time(milliseconds: Sequence[float | None]) -> None:
    """Say how long the tracker takes, if it was measured."""
    times = [each for each in milliseconds if each is not None]
    if times:
        console.print(f"median time in the tracker: {median(times):.2f} ms per frame")
