"""Measure how much memory it takes to smooth and write dives of different lengths.

    python docs/memory_goals.py [--pictures 5000 20000 60000] [--whole]

Each dive is made up: a vehicle follows a straight cable, five pictures a second at 0.5 m/s, and the
cable is hidden over 4 m of every 30 m. Each is smoothed by a process of its own; a short one comes
first, for what is compiled, imported and taken by libraries. With `--whole` nothing is kept on
disk. Printed is the largest resident memory, and by how much it is above what there was before.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import PROFILE_BINS, TRACKING
from cable_tracker.survey.memory_mapped import BLOCK, Disk
from cable_tracker.survey.outputs.frames import write_frames
from cable_tracker.survey.recording import SurveySettings, analyse

SPEED, RATE, LOOK = 0.5, 5.0, 0.7
NOISE = 0.02
"""Standard deviation of claims across the cable [m]."""

SHORT = 500
STATUS = Path("/proc/self/status")


def main() -> None:
    """Measure in one process a length, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pictures", type=int, nargs="+", default=[5000, 20_000, 60_000])
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one is not None:
        _measure(given.one, given.whole)
        return
    for count in given.pictures:
        options = ["--whole"] if given.whole else []
        subprocess.run([sys.executable, __file__, "--one", str(count), *options], check=True)


def _measure(count: int, whole: bool) -> None:
    with tempfile.TemporaryDirectory() as folder:
        disk = Disk(Path(folder), count if whole else BLOCK)
        _survey(_dive(SHORT, Disk(Path(folder))), Path(folder))
        # Sets the largest resident memory back to what there is.
        Path("/proc/self/clear_refs").write_text("5")
        before = _megabytes("VmRSS")
        dive, begin = _dive(count, disk), time.perf_counter()
        _survey(dive, Path(folder))
        most, seconds = _megabytes("VmHWM"), time.perf_counter() - begin
    print(
        f"{count} pictures: {most:.0f} MB, {most - before:.0f} MB above {before:.0f} MB;"
        f" {seconds:.1f} s"
    )


def _survey(dive: ForwardDive, folder: Path) -> None:
    _, course = analyse(dive, SurveySettings())
    write_frames(folder / "frames.parquet", dive.name, dive, course)


def _megabytes(name: str) -> float:
    found = re.search(rf"{name}:\s+(\d+) kB", STATUS.read_text(encoding="utf-8"))
    if found is None:
        raise SystemExit(f"{STATUS} does not say {name}: run this on Linux")
    return int(found[1]) / 1024


def _dive(count: int, disk: Disk) -> ForwardDive:
    """Return a dive along a straight cable."""
    rng, dive = np.random.default_rng(0), ForwardDive("dive", disk)
    ahead = np.linspace(LOOK + 0.8, LOOK - 0.8, PROFILE_BINS)
    for number in range(count):
        along, stamp = number * SPEED / RATE, round(number / RATE * 1e9)
        aside = 0.2 * float(np.sin(along / 3.0))
        dive.poses.add(stamp, [along, -aside, 0.0, SPEED])
        row = dive.table.append()
        row["frame"], row["stamp"], row["look"], row["half_view"] = number, stamp, LOOK, 1.0
        row["altitude"] = 2.0
        if 10.0 < (along + LOOK) % 30.0 < 14.0:
            continue
        row["status"], row["diameter"] = TRACKING, 0.16
        row["aside"] = aside + NOISE * rng.standard_normal()
        row["heading"] = 0.01 * rng.standard_normal()
        row["aside_variance"], row["aside_heading"] = NOISE**2, 0.0
        row["heading_variance"] = 1e-4
        row["profile_ahead"] = ahead
        way = (along + ahead) % 30.0
        row["profile_score"] = np.where((way > 10.0) & (way < 14.0), 0.2, 3.0)
    return dive


if __name__ == "__main__":
    main()
