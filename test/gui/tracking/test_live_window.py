"""The window on a live node: three processes that talk over DDS, and a real browser."""

import os

import cv2
import numpy as np
import pytest
from tracking_page import PICTURE

pytest.importorskip("rclpy", reason="ROS 2 IS MISSING: no live node is watched")

from cable_tracker.ros.process.child_process import NodeProcess
from cable_tracker.ros.process.environment import local_environment

NAMESPACE = "/boat"
FIRST_DOMAIN = 70
PAGE_TIMEOUT = 300_000
"""Milliseconds that a page gets to say something, on a busy machine."""


@pytest.fixture(scope="module")
def domain():
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + int(worker)))
        for name, value in local_environment().items():
            patch.setenv(name, value)
        yield


@pytest.fixture(scope="module")
def node(domain):
    """Return a function that starts a node of the boat."""

    def start(name, namespace=NAMESPACE, **parameters):
        given = [["-p", f"{key}:={value}"] for key, value in parameters.items()]
        arguments = [part for pair in given for part in pair]
        return NodeProcess(name, ["-r", f"__ns:={namespace}", *arguments], dict(os.environ))

    return start


@pytest.fixture(scope="module")
def url(node, dive, run_shared_command):
    """Address of a window on a tracker that a recording is played to, over and over."""
    with node("replay", source=dive, loop="true", rate="0.5"):
        yield run_shared_command("gui", "--ros", NAMESPACE).url


def shows_particles(page, tracker, count):
    """Wait until a page draws so many particles; a failure tells what page and node say instead."""
    playwright = pytest.importorskip("playwright.sync_api")
    try:
        page.wait_for_function(f"{PICTURE}?.parts.cloud?.rows === {count}")
    except playwright.TimeoutError:
        trouble = page.locator("[data-test=trouble]").inner_text()
        pytest.fail(f"the page says {trouble!r}, the node {tracker.last_line()!r}")


@pytest.fixture
def window(visit, url, node):
    """A page on which the tracker's pictures move."""
    with node("tracker", particle_count=60) as tracker, visit(url) as page:
        shows_particles(page, tracker, 60)
        yield page


def test_a_live_node_is_watched_and_tuned(window):
    assert window.locator("[data-test=play]").count() == 0
    field = window.locator("#p-particle_count")
    field.fill("90")
    field.press("Enter")
    window.wait_for_function(f"{PICTURE}.parts.cloud?.rows === 90")
    field = window.locator("#p-width_maximum")
    field.fill("2")
    field.press("Enter")
    refusal = "width_minimum = 3 must not exceed width_maximum = 2"
    window.locator("[data-test=row-width_maximum]").filter(has_text=refusal).wait_for()
    window.locator("#p-input_timeout").wait_for()


def test_only_what_the_node_is_told_is_asked_for(window):
    assert window.locator("[data-test=start-width]").count() == 0
    window.keyboard.press("i")
    dialog = window.get_by_role("dialog")
    dialog.wait_for()
    assert dialog.get_by_role("spinbutton").count() == 2
    window.keyboard.press("Escape")
    # Until it is gone it takes the clicks that follow.
    dialog.wait_for(state="hidden")


def switch(page, name, condition):
    """Click until it has happened: a node that has just started hears of services after topics."""
    playwright = pytest.importorskip("playwright.sync_api")
    for _ in range(PAGE_TIMEOUT // 20_000):
        page.get_by_role("button", name=name).click()
        try:
            page.wait_for_function(condition, timeout=20_000)
        except playwright.TimeoutError:
            continue
        return
    pytest.fail(f"{name}: the node has not heard of it")


def test_the_node_is_switched_off_and_on(window):
    switch(window, "switch off", f"{PICTURE}.status === 'DISABLED'")
    switch(window, "switch on", f"{PICTURE}.status !== 'DISABLED'")


def says(page, part, text):
    """Wait until a part of the page says so; a failure tells what it says instead."""
    playwright = pytest.importorskip("playwright.sync_api")
    place = page.locator(f"[data-test={part}]")
    playwright.expect(place).to_contain_text(text, timeout=PAGE_TIMEOUT)


def test_a_node_that_is_gone_is_said_and_found_again(visit, url, node):
    with visit(url) as page:
        says(page, "trouble", "no node /boat/tracker")
        with node("tracker", particle_count=33) as tracker:
            shows_particles(page, tracker, 33)
            says(page, "status", "%")
        says(page, "trouble", "no node /boat/tracker")
        says(page, "status", "NOT LIVE, last picture")


@pytest.fixture
def still_target(tmp_path, target_frames):
    """Return a folder in which the target stays where it is, so that a mark is never late."""
    rng = np.random.default_rng(1)
    picture = target_frames[0].image
    for index in range(20):
        noise = rng.integers(0, 4, picture.shape, np.uint8)
        cv2.imwrite(str(tmp_path / f"{index:02}.png"), cv2.add(picture, noise))
    return tmp_path


def test_a_live_target_is_watched_and_marked(visit, node, still_target, target_frames, run_command):
    dock = "/dock"
    url = run_command("gui", "--ros", dock, "--target").url
    with (
        node("replay", dock, source=still_target, loop="true", rate="0.2"),
        node("target_tracker", dock, particle_count=60),
        visit(url) as page,
    ):
        page.wait_for_function(f"{PICTURE}?.status === 'INITIALISING'")
        page.get_by_role("button", name="start at …").click()
        sides = ("left px", "top px", "right px", "bottom px")
        for label, value in zip(sides, target_frames[0].box, strict=True):
            page.get_by_label(label).fill(str(value))
        page.locator("[data-test=dialog-ok]:visible").click()
        drawn = f"new Set({PICTURE}.layers.map((layer) => layer.name))"
        claimed = " && ".join(f"{drawn}.has('{name}')" for name in ("box", "contour", "band"))
        page.wait_for_function(f"{PICTURE}.status === 'TRACKING' && {claimed}")
        page.wait_for_function(f"{PICTURE}.parts.cloud.rows === 60 && {PICTURE}.state.length === 6")
        assert page.evaluate(f"{PICTURE}.state[2]") == pytest.approx(1.0, abs=0.4)
