"""Messages and output folders of the commands that track a recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from cable_tracker.commands.terminal import console
from cable_tracker.errors import RecordingError
from cable_tracker.sequences.estimates import REFUSED, EstimateRow


def folder_beside(source: Path, ending: str) -> Path:
    """Return the folder for results when the user names none: in the present one, by the source."""
    resolved = source.resolve()
    stem = resolved.name if resolved.is_dir() else resolved.stem
    return Path(f"{stem}_{ending}")


def need_usable_frames(
    source: Path, statuses: Sequence[str], damage: RecordingError | None
) -> None:
    """See that there is anything to keep of a run.

    Parameters
    ----------
    statuses : sequence of str
        Status of each frame.
    damage : RecordingError or None
        Error at which the recording broke off.

    Raises
    ------
    RecordingError
        No frame could be used.
    """
    if any(status != REFUSED for status in statuses):
        return
    reason = f"none of the {len(statuses)} frames can be used" if statuses else "holds no frames"
    raise damage or RecordingError(f"{source}: {reason}; record it again")


def print_statuses(statuses: Sequence[str]) -> None:
    """Say how many frames there are of each status."""
    counts = {status: statuses.count(status) for status in dict.fromkeys(statuses)}
    words = ", ".join(f"{count} {status}" for status, count in counts.items())
    console.print(f"{len(statuses)} frames: {words}", soft_wrap=True)


def metres_told(rows: Sequence[EstimateRow]) -> str:
    """Say for how many claims the cable is known in metres, and why not for the others.

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
    times = sorted(each for each in milliseconds if each is not None)
    if times:
        console.print(f"median time in the tracker: {times[len(times) // 2]:.2f} ms per frame")
