"""Measure how long the report of a long route takes to open in Chromium.

    python docs/report_goals.py FOLDER [--length 50] [--events 1000] [--times 3]

A page is open when it has been loaded and drawn once. `chromium` must be installed.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.survey.outputs.maps import SurveyMap
from cable_tracker.survey.outputs.report import RecordingRow, write_report
from cable_tracker.survey.recording import JPEG_QUALITY
from cable_tracker.survey.routes.events import Event, EventKind
from cable_tracker.survey.routes.merging import MergedRoute
from cable_tracker.survey.routes.route import SPACING

NAME = "dive"
PICTURE_SIZE = (240, 180)
NOTE_TIME = (
    "<script>addEventListener('load',()=>requestAnimationFrame(()=>setTimeout(()=>"
    "document.documentElement.setAttribute('data-open',Math.round(performance.now())),0)))</script>"
)


def main() -> None:
    """Write a report, open it, and print how long that took."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--length", type=float, default=50.0, help="Of the route [km].")
    parser.add_argument("--events", type=int, default=1000)
    parser.add_argument("--times", type=int, default=3)
    given = parser.parse_args()
    browser = shutil.which("chromium") or shutil.which("chromium-browser")
    if browser is None:
        raise SystemExit("chromium is not installed: install it, or open report.html by hand")
    given.folder.mkdir(parents=True, exist_ok=True)
    _write_pictures(given.folder / "recordings" / NAME / "pictures", given.events)
    route = _route(round(given.length * 1000 / SPACING) + 1, given.events)
    survey = SurveyMap((route,), LocalFrame(54.25, 7.9), ("route 1",), folder=given.folder)
    page = given.folder / "report.html"
    rows = [RecordingRow(f"{NAME}_{k}", "done", 100_000, 90_000, 5000.0, ()) for k in range(40)]
    write_report(page, survey, rows, "Cable survey")
    print(f"{given.length:g} km, {given.events} events: {page.stat().st_size / 1e6:.1f} MB")
    timed = given.folder / "timed.html"
    timed.write_text(page.read_text(encoding="utf-8") + NOTE_TIME, encoding="utf-8")
    for _ in range(given.times):
        print(f"open after {_seconds_to_open(browser, timed):.2f} s")


def _route(count: int, events: int) -> MergedRoute:
    """Return a route of so many points that winds, with events evenly along it."""
    rng = np.random.default_rng(0)
    along = np.arange(count) * SPACING
    headings = 0.5 * np.sin(along / 300.0) + 0.2 * np.sin(along / 41.0)
    places = SPACING * np.cumsum(np.column_stack((np.cos(headings), np.sin(headings))), axis=0)
    kinds, every = list(EventKind), max(count // events, 1)
    found = tuple(
        Event(
            kinds[k % len(kinds)], float(along[k * every]), float(along[k * every]) + 5.0,
            (float(places[k * every, 0]), float(places[k * every, 1])), k * 10**9, k,
            "not to be seen over 5.0 m", NAME,
        )
        for k in range(min(events, count))
    )  # fmt: skip
    return MergedRoute(
        along, places, headings, 0.05 + 0.01 * rng.random(count),
        (rng.random(count) > 0.1).astype(float), 0.16 + 0.01 * rng.standard_normal(count),
        0.2 * rng.standard_normal(count), np.ones(count), found, (NAME,),
    )  # fmt: skip


def _write_pictures(folder: Path, count: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    width, height = PICTURE_SIZE
    noise = np.random.default_rng(0).integers(0, 255, (height, width, 3), dtype=np.uint8)
    quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    picture = cv2.imencode(".jpg", cv2.GaussianBlur(noise, (0, 0), 2.0), quality)[1].tobytes()
    for number in range(count):
        (folder / f"{number}.jpg").write_bytes(picture)


def _seconds_to_open(browser: str, page: Path) -> float:
    with tempfile.TemporaryDirectory() as profile:
        command = [
            browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}",
            "--virtual-time-budget=1", "--timeout=60000", "--dump-dom", page.resolve().as_uri(),
        ]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = re.search(r'data-open="(\d+)"', done.stdout)
    if found is None:
        raise SystemExit(f"{page}: did not open")
    return int(found[1]) / 1000


if __name__ == "__main__":
    main()
