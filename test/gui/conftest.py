"""A real headless Chromium, and the commands as processes of their own."""

import json
import os
import re
import select
import shutil
import signal
import struct
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

from cable_tracker.sequences.labels.target_writer import write_target_pictures
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings, write_survey_bag
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate
from cable_tracker.simulation.targets.sequence import labelled_frames, simulate_target

DIVE_LENGTH = 60
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
START_TIMEOUT = 300.0
"""Seconds until a command must have printed its address, on a busy machine, compiling included."""
PAGE_TIMEOUT = 300_000
"""Milliseconds that Playwright waits for anything on a page."""


def unpack(message):
    """Take a packet apart again, as the browser does.

    Returns
    -------
    dict, dict
        The description, and the sections by name: bytes of ``jpeg``, arrays of ``float32``.
    """
    (length,) = struct.unpack_from("<I", message)
    description = json.loads(message[4 : 4 + length])
    start = 4 + length
    sections = {}
    for entry in description.pop("sections"):
        begin = start + entry["offset"]
        data = message[begin : begin + entry["size"]]
        sections[entry["name"]] = (
            np.frombuffer(data, "<f4").astype(np.float64).reshape(entry["shape"])
            if entry["kind"] == "float32"
            else data
        )
    return description, sections


@pytest.fixture(scope="module")
def chromium():
    """Return the browser that all tests of a module share.

    Not of the session: Playwright keeps a loop running in its thread, and others could run none.
    """
    playwright = pytest.importorskip("playwright.sync_api", reason="PLAYWRIGHT IS NOT INSTALLED")
    if CHROMIUM is None:
        pytest.skip("NO CHROMIUM: the pages are not tested; apt install chromium")
    with playwright.sync_playwright() as running:
        browser = running.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield browser
        browser.close()


@contextmanager
def visiting(chromium, url, size=(1280, 800), **options):
    """Open a page; no request may go elsewhere, and no script may fail."""
    context = chromium.new_context(
        viewport={"width": size[0], "height": size[1]}, accept_downloads=True, **options
    )
    context.set_default_timeout(PAGE_TIMEOUT)
    page = context.new_page()
    requested, failures = [], []
    page.on("request", lambda request: requested.append(request.url))
    page.on("websocket", lambda socket: requested.append(socket.url))
    page.on("pageerror", lambda error: failures.append(str(error)))
    page.goto(url)
    # Before the server knows the page, it hears of no click.
    page.wait_for_function("window.did_handshake !== false")
    try:
        yield page
    finally:
        context.close()
    outside = {name for name in map(host_of, requested) if name not in (None, host_of(url))}
    assert not outside, f"the page asked other hosts: {outside}"
    assert not failures, failures


def wait_until(page, has_happened):
    """Wait for what no script of the page can see; what it does meanwhile goes on."""
    deadline = time.monotonic() + PAGE_TIMEOUT / 1000
    while not has_happened():
        assert time.monotonic() < deadline, "it has not happened"
        page.wait_for_timeout(50)


def host_of(url):
    parts = urlsplit(url)
    return parts.netloc if parts.scheme in ("http", "https", "ws", "wss") else None


@pytest.fixture
def visit(chromium):
    """Return a function that opens a page as a context."""
    return lambda url, **options: visiting(chromium, url, **options)


def environment():
    """Return the environment of a command. NiceGUI is not to know that it is tested."""
    own = {"PYTHONUNBUFFERED": "1", "PYTHONPATH": str(Path(__file__).parents[2])}
    inherited = {name: text for name, text in os.environ.items() if "PYTEST" not in name}
    return inherited | own


class Running:
    """A command that serves a page.

    Attributes
    ----------
    url : str
        What it printed.
    """

    def __init__(self, arguments, folder):
        self.output = b""
        self.process = subprocess.Popen(
            [sys.executable, "-m", "cable_tracker.cli", *map(str, arguments)],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=environment(),
        )
        self.url = self.wait_for(rb"(http://\S+)").group(1).decode()

    def wait_for(self, pattern):
        """Return the match of what it prints, now or before long."""
        deadline = time.monotonic() + START_TIMEOUT
        while (found := re.search(pattern, self.output)) is None:
            left = deadline - time.monotonic()
            ready, _, _ = select.select([self.process.stdout], [], [], max(left, 0.0))
            chunk = os.read(self.process.stdout.fileno(), 65536) if ready else b""
            if not chunk:
                self.process.kill()
                self.process.communicate()
                raise AssertionError(f"{pattern!r} is not in:\n{self.output.decode()}")
            self.output += chunk
        return found

    def stop(self):
        """End it as Ctrl-C does, and return its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            rest, _ = self.process.communicate(timeout=300)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        self.output += rest
        return self.process.returncode


@contextmanager
def running_commands(folder):
    """Give a function that starts `cable-tracker ...`, and end in the end what it has started."""
    running = []

    def start(*arguments):
        running.append(Running([*arguments, "--port", "0"], folder))
        return running[-1]

    yield start
    for command in running:
        command.stop()


@pytest.fixture
def run_command(tmp_path):
    """Return a function that starts `cable-tracker ...` and gives it when it serves."""
    with running_commands(tmp_path) as start:
        yield start


@pytest.fixture(scope="module")
def run_shared_command(tmp_path_factory):
    """Return the same for a command that all tests of a module share."""
    with running_commands(tmp_path_factory.mktemp("shared")) as start:
        yield start


@pytest.fixture(scope="session")
def dive(tmp_path_factory):
    """Return a sequence file of sixty frames of a clear dive, 160x120, with truth."""
    folder = tmp_path_factory.mktemp("recordings") / "dive"
    settings = SimulationSettings(
        frame_count=DIVE_LENGTH, image_size=(160, 120), clutter=0.1, seed=3
    )
    write_sequence(folder, simulate(settings))
    return next(folder.glob("*.txt"))


@pytest.fixture(scope="session")
def surveyed_dive(tmp_path_factory):
    """Return a bag of a dive of 7 s with all instruments, 160x120, with truth."""
    folder = tmp_path_factory.mktemp("recordings") / "surveyed"
    settings = SurveyDiveSettings(length=3.5, image_size=(160, 120), rate=6.0, seed=2)
    write_survey_bag(folder, settings)
    return folder


TARGET_LENGTH = 20


@pytest.fixture(scope="session")
def target_frames():
    """Return twenty frames of a buoy below its mirror, with boxes."""
    return list(simulate_target("near_surface", 1, TARGET_LENGTH))


@pytest.fixture(scope="session")
def target_dive(tmp_path_factory, target_frames):
    """Return the folder of the same as pictures with `boxes.txt`."""
    folder = tmp_path_factory.mktemp("recordings") / "target"
    write_target_pictures(folder, labelled_frames(target_frames))
    return folder
