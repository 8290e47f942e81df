"""Measure the tracking window: pictures per second in a real browser, and what the server pays.

    python docs/measure_gui.py [RECORDING] [--picture docs/images/gui.png]

Plays a recording (a simulated dive of 640x480 if none is given) with 500 particles at its own pace,
in turn with a browser that draws it and without one. The difference in processor time is
what the window costs beside the tracker. Needs Playwright and Chromium.
"""

from __future__ import annotations

import argparse
import itertools
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

CHROMIUM = "/usr/bin/chromium"
ROUNDS = 4
MEASURED = 7.0
"""Duration of a measurement [s]."""

CANVAS = "document.querySelector('.ct-stage canvas')"
COUNT_PICTURES = f"""
  const view = {CANVAS}.frameView, paint = view.paint.bind(view);
  window.drawnAt = [];
  let last = null;
  view.paint = () => {{
    paint();
    if (view.description && view.description.number !== last) {{
      last = view.description.number;
      window.drawnAt.push(performance.now());
    }}
  }};
"""


@dataclass(frozen=True, slots=True)
class Turn:
    """Results of one measurement.

    Attributes
    ----------
    server : float
        Processor time of the server, share of one core.
    browser : float
        The same of the browser with all its processes.
    fps : float or None
        Median of the pictures per second that were drawn; None without a browser.
    """

    server: float
    browser: float
    fps: float | None = None


@contextmanager
def serving(recording: Path) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """Run the command on a recording; give its process and the address."""
    command = [sys.executable, "-m", "cable_tracker.cli", "gui", str(recording)]
    process = subprocess.Popen(
        [*command, "--init", "truth", "--port", "0"],
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    assert process.stdout is not None
    try:
        found = re.search(rb"http://\S+", process.stdout.readline())
        if found is None:
            raise SystemExit("the server did not start")
        yield process, found.group().decode()
    finally:
        process.terminate()
        process.wait()


def processor_times() -> dict[int, tuple[int, float]]:
    """Return parent and processor time so far [s] of all processes, by number."""
    times = {}
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rsplit(")", maxsplit=1)[1].split()
        except OSError:  # It has just ended.
            continue
        spent = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        times[int(entry.parent.name)] = (int(fields[1]), spent)
    return times


def spent_below(root: int, but: int) -> float:
    """Return the processor time of all processes below one, but for one of them [s]."""
    times = processor_times()
    below = {root}
    for _ in times:
        more = {number for number, (parent, _) in times.items() if parent in below} - {but}
        if more <= below:
            break
        below |= more
    return sum(times[number][1] for number in below - {root} if number in times)


@contextmanager
def page_of(browser: Browser, url: str) -> Iterator[Page]:
    """Open the window and wait for a picture."""
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    page = context.new_page()
    page.goto(url)
    page.wait_for_function(
        f"({CANVAS}?.frameView?.description?.status ?? 'WARMING UP') !== 'WARMING UP'"
    )
    page.wait_for_function("document.querySelector('#p-particle_count')?.value !== ''")
    yield page
    context.close()


def play_from_the_start(page: Page) -> None:
    """Begin at the first frame."""
    page.keyboard.press("Home")
    page.wait_for_function(f"{CANVAS}.frameView.description.frame < 30")
    # The page hears of the end of playing a little later.
    page.wait_for_timeout(500)
    if page.locator("[data-test=play]").count():
        page.keyboard.press("Space")
    page.wait_for_function(f"{CANVAS}.frameView.description.frame > 2")


def measure(process: subprocess.Popen[bytes]) -> tuple[float, float]:
    """Return the shares of one core that the server and the browser take."""

    def spent() -> tuple[float, float]:
        return processor_times()[process.pid][1], spent_below(os.getpid(), process.pid)

    begin, before = time.monotonic(), spent()
    time.sleep(MEASURED)
    after, passed = spent(), time.monotonic() - begin
    return (after[0] - before[0]) / passed, (after[1] - before[1]) / passed


def turn_with_browser(process: subprocess.Popen[bytes], browser: Browser, url: str) -> Turn:
    """Measure while a browser draws."""
    with page_of(browser, url) as page:
        page.evaluate(COUNT_PICTURES)
        play_from_the_start(page)
        page.evaluate("window.drawnAt.length = 0")
        server, drawing = measure(process)
        drawn = page.evaluate("window.drawnAt")
    gaps = [after - before for before, after in itertools.pairwise(drawn)]
    print(f"  drawn {len(drawn) / MEASURED:.1f} fps on average")
    return Turn(server, drawing, 1000.0 / statistics.median(gaps))


def turn_alone(process: subprocess.Popen[bytes], browser: Browser, url: str) -> Turn:
    """Measure without a browser."""
    with page_of(browser, url) as page:
        play_from_the_start(page)
    return Turn(*measure(process))


def take_picture(browser: Browser, url: str, path: Path) -> None:
    """Save a screenshot of the window after some seconds of playing."""
    with page_of(browser, url) as page:
        play_from_the_start(page)
        page.wait_for_function(f"{CANVAS}.frameView.description.frame > 200")
        page.keyboard.press("Space")
        page.locator("[data-test=play]").wait_for()
        # What is drawn more slowly than the picture comes to an end too.
        page.wait_for_timeout(500)
        page.screenshot(path=str(path))
    # A palette makes the file three times smaller, and is not seen.
    from PIL import Image  # noqa: PLC0415 - comes with matplotlib, for this alone

    with Image.open(path) as picture:
        picture.convert("RGB").quantize(256).save(path, optimize=True)


def simulated(folder: Path) -> Path:
    """Simulate a dive of ten seconds."""
    recording = folder / "dive"
    command = [sys.executable, "-m", "cable_tracker.cli", "simulate", str(recording)]
    options = ["--frames", "250", "--seed", "3", "--size", "640x480", "--clutter", "0.4"]
    subprocess.run([*command, *options], check=True)
    return recording


def main() -> None:
    """Measure, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path, nargs="?")
    parser.add_argument("--picture", type=Path, help="save the window as this PNG too")
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as running:
        recording = given.recording or simulated(Path(folder))
        browser = running.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        with serving(recording) as (process, url):
            drawn, alone = [], []
            for _ in range(given.rounds):
                drawn.append(turn_with_browser(process, browser, url))
                alone.append(turn_alone(process, browser, url))
            if given.picture is not None:
                take_picture(browser, url, given.picture)
        browser.close()
    with_browser = statistics.median(turn.server for turn in drawn)
    without = statistics.median(turn.server for turn in alone)
    fps = statistics.median(turn.fps for turn in drawn if turn.fps is not None)
    print(f"drawn in the browser: {fps:.1f} fps (median)")
    print(f"server with a browser: {with_browser:.1%} of a core; without: {without:.1%}")
    print(f"the window beside the tracker: {with_browser - without:.1%} of a core")
    drawing = statistics.median(turn.browser for turn in drawn)
    print(f"the browser itself, without graphics hardware: {drawing:.1%} of a core")
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")


if __name__ == "__main__":
    main()
