"""The tracking window in a real browser: nothing here knows how the page is made inside."""

import asyncio
import importlib.util
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest
from stub_session import StubSession
from tracking_page import PICTURE, TrackingPage

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cli import app
from cable_tracker.errors import CableTrackerError, GuiError, RosError
from cable_tracker.gui.session.recording_session import RecordingRequest
from cable_tracker.gui.tracking.commands import SPEEDS
from cable_tracker.sequences.source import open_source
from cable_tracker.tracking.parameter_files import (
    format_parameter_file,
    read_parameter_file,
)

LAST = 59


@pytest.fixture
def pictures(tmp_path):
    """A folder of pictures whose numbers have a gap."""
    for number in (1, 2, 3, 7, 8):
        picture = np.full((120, 160), 90 + number, np.uint8)
        cv2.imwrite(str(tmp_path / f"{number:03}.png"), picture)
    return tmp_path


class Window(TrackingPage):
    """A page on which a cable is followed."""

    def __init__(self, page):
        super().__init__(page)
        self.at("row-particle_count").wait_for()
        page.wait_for_function("document.querySelector('#p-particle_count').value !== ''")

    def field(self, name):
        return self.page.locator(f"#p-{name}")

    def shows(self, **wanted):
        """Wait until the picture's packet says so."""
        self.wait_for(" && ".join(f"{PICTURE}.{key} === {value}" for key, value in wanted.items()))

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)

    def set(self, name, value):
        field = self.field(name)
        field.fill(str(value))
        field.press("Enter")
        field.blur()

    @contextmanager
    def slow(self):
        """Play so slowly that the end is far, however late the page looks."""
        steps = ["-"] * list(SPEEDS).index("1")
        self.press(*steps)
        self.wait_for(
            f"document.querySelector('[data-test=speed]').value === '{next(iter(SPEEDS))}'"
        )
        yield
        self.press(*("+" for _ in steps))
        self.wait_for("document.querySelector('[data-test=speed]').value === '1'")

    def go_to(self, frame):
        self.at("frame-field").fill(str(frame))
        self.at("frame-field").press("Enter")
        self.shows(frame=frame)

    def says(self, name, words):
        """Wait until something on the page says so."""
        self.at(name).filter(has_text=words).wait_for()

    def drag_along(self, state):
        """Draw the centreline of a cable on the picture."""
        ends = self.page.evaluate(
            """([d, alpha]) => {
              const canvas = document.querySelector('.ct-stage canvas'), view = canvas.frameView;
              const area = canvas.getBoundingClientRect(), [width, height] = view.description.size;
              return [-0.3, 0.3].map((share) => {
                const along = share * height;
                const x = d * Math.cos(alpha) - along * Math.sin(alpha);
                const y = d * Math.sin(alpha) + along * Math.cos(alpha);
                return [area.left + area.width / 2 + x * view.scale,
                        area.top + area.height / 2 - y * view.scale];
              });
            }""",
            [state.distance, state.angle],
        )
        self.drag(*ends)


@pytest.fixture(scope="module")
def address(run_shared_command, dive):
    """Return where a recording is watched, by all tests of this module in turn."""
    return run_shared_command("gui", dive, "--init", "truth", "--seed", "4").url


@pytest.fixture
def window(visit, address):
    """Return the window on the first frame, with the parameters that it began with."""
    with visit(address) as page:
        window = Window(page)
        if window.at("pause").count():
            window.at("pause").click()
        window.at("apply").click()
        window.says("differing", "all as there")
        window.go_to(1)
        window.go_to(0)
        yield window


def truth_of(dive, number):
    with open_source(dive) as source:
        return next(frame.truth for frame in source.frames() if frame.index == number)


def test_it_shows_the_first_frame_and_what_is_believed(window):
    assert window.at("title").inner_text() == "sequence.txt"
    assert window.picture()["particle_count"] == 500
    assert window.picture()["cloud"] > 400
    assert window.at("state-0").inner_text().startswith("d")
    assert window.at("status").inner_text()


def test_it_plays_pauses_steps_and_seeks_by_keys(window):
    with window.slow():
        window.press("Space")
        window.wait_for(f"{PICTURE}.frame > 5")
        window.at("pause").wait_for()
        window.press("Space")
        window.at("play").wait_for()
    window.press("End")
    window.shows(frame=LAST)
    window.press("ArrowLeft")
    window.shows(frame=LAST - 1)
    window.press("Shift+ArrowLeft", "ArrowRight")
    window.shows(frame=LAST - 10)
    window.press("Home")
    window.shows(frame=0)


def test_the_slider_seeks_and_what_was_seen_comes_back(window):
    window.press("+", "+", "Space")
    window.shows(frame=LAST)
    window.go_to(30)
    seen = window.picture()["state"]
    assert seen is not None
    window.at("slider").fill("45")
    window.shows(frame=45)
    window.go_to(30)
    assert window.picture()["state"] == seen
    window.press("-", "-")
    window.page.wait_for_function("document.querySelector('[data-test=speed]').value === '1'")


def test_keys_that_mean_nothing_to_the_slider_work_after_a_click_on_it(window):
    window.at("slider").click()
    window.press("?")
    dialog = window.page.get_by_role("dialog")
    dialog.get_by_text("play or pause").wait_for()
    window.press("Escape")
    dialog.wait_for(state="hidden")
    window.go_to(3)
    window.at("slider").focus()
    window.press("ArrowRight")
    window.shows(frame=4)


def test_a_cancelled_pointer_no_longer_moves_the_picture(window):
    """As when a pen goes away, or a finger becomes a gesture of the system."""
    area = window.page.locator(".ct-stage canvas").bounding_box()
    x, y = area["x"] + area["width"] / 2, area["y"] + area["height"] / 2
    mouse, middle = window.page.mouse, "document.querySelector('canvas').frameView.middle"
    mouse.move(x, y)
    mouse.wheel(0, -100)
    window.page.keyboard.down("Shift")
    mouse.down()
    window.page.keyboard.up("Shift")
    window.page.evaluate(
        "document.querySelector('.ct-stage canvas').dispatchEvent(new Event('pointercancel'))"
    )
    before = window.page.evaluate(middle)
    mouse.move(x + 40, y + 40)
    assert window.page.evaluate(middle) == before
    mouse.up()
    window.press("0")


def test_the_filter_takes_a_changed_parameter(window):
    window.set("particle_count", 200)
    window.says("differing", "1 differ")
    window.press("ArrowRight")
    window.shows(particle_count=200)
    window.at("reset-particle_count").click()
    window.says("differing", "all as there")
    window.press("ArrowRight")
    window.shows(particle_count=500)


def test_a_refused_value_is_explained_beside_its_field(window):
    window.set("particle_count", 0)
    window.says("refusal-particle_count", "outside 1 .. 1000000")
    window.says("refusal-particle_count", "In force: 500")
    assert window.field("particle_count").input_value() == "500"
    window.set("particle_count", "many")
    window.says("refusal-particle_count", "is not a whole number")
    window.set("width_minimum", 150)
    window.set("width_maximum", 140)
    window.says("refusal-width_maximum", "must not exceed")


def test_escape_takes_back_what_was_typed(window):
    window.field("particle_count").fill("7")
    window.press("Escape")
    assert window.field("particle_count").input_value() == "500"
    window.press("ArrowRight")
    window.shows(frame=1, particle_count=500)


def test_a_parameter_is_found_by_name_and_by_meaning(window):
    window.press("/")
    window.page.keyboard.type("tempering")
    window.page.wait_for_function("document.querySelectorAll('.ct-row').length === 1")
    window.press("Escape")
    window.page.wait_for_function("document.querySelectorAll('.ct-row').length > 60")


def test_what_is_no_frame_does_not_stay_in_the_field(window):
    field = window.at("frame-field")
    window.go_to(3)
    for typed in ("abc", ""):
        field.fill(typed)
        field.press("Enter")
        window.page.wait_for_function(
            "document.querySelector('[data-test=frame-field]').value === '3'"
        )
    field.fill("9999")
    field.press("Enter")
    window.shows(frame=LAST)
    assert field.input_value() == window.at("slider").input_value() == str(LAST)


def test_keys_typed_before_a_dialog_is_there_command_nothing(window):
    window.shows(frame=0)
    before = window.picture()["number"]
    # "End" would go to the last frame, "r" reset the tracker. One script types all of them, for
    # a page that waits for its processor takes longer between keys than a dialog may.
    window.page.evaluate(
        """for (const key of ["o", "End", "r"])
             document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }))"""
    )
    window.page.get_by_role("dialog").wait_for()
    assert window.picture()["number"] == before
    window.press("Escape")


def test_every_parameter_has_a_field_with_its_help(window):
    named = window.page.eval_on_selector_all(
        ".ct-row", "rows => rows.map(row => [row.querySelector('input, select').id, "
        "row.querySelector('input, select').getAttribute('aria-describedby'), "
        "row.querySelector('label').htmlFor])"
    )  # fmt: skip
    names = TrackerParameters().as_mapping()
    assert sorted(named) == sorted([f"p-{name}", f"h-{name}", f"p-{name}"] for name in names)
    window.field("maximum_gap").focus()
    assert "Longest pause" in window.page.locator("#h-maximum_gap").inner_text()


def test_a_preset_is_compared_and_loaded(window):
    window.at("reference").select_option("thesis")
    window.page.wait_for_function(
        "/^[0-9]+ differ$/.test(document.querySelector('[data-test=differing]').innerText)"
    )
    window.at("apply").click()
    window.says("differing", "all as there")
    assert window.field("filter").input_value() == "bootstrap"


def test_a_drawn_cable_is_where_the_filter_starts(window, dive):
    window.go_to(40)
    truth = truth_of(dive, 40)
    window.at("start-width").fill(f"{truth.width:.0f}")
    before = window.picture()["number"]
    window.drag_along(truth)
    window.wait_for(f"{PICTURE}.number > {before} && {PICTURE}.status === 'TRACKING'")
    found = window.picture()["state"]
    assert found[0] == pytest.approx(truth.distance, abs=5.0)
    assert window.picture()["frame"] == 40


def test_keys_reset_the_tracker_and_switch_it_off_and_on(window):
    before = window.picture()["number"]
    window.press("r")
    window.wait_for(f"{PICTURE}.number > {before}")
    window.press("e")
    window.shows(status="'DISABLED'")
    assert window.picture()["cloud"] == 0
    window.press("e")
    window.wait_for(f"{PICTURE}.status !== 'DISABLED'")


def test_saved_parameters_are_the_file_that_the_node_reads(window, dive, tmp_path):
    window.set("tempering", "0,07")
    window.says("differing", "1 differ")
    window.press("s")
    with window.page.expect_download() as download:
        window.at("download").click()
    window.page.get_by_role("dialog").wait_for(state="hidden")
    saved = Path(download.value.path()).read_text(encoding="utf-8")
    wanted = TrackerParameters(tempering=0.07)
    assert saved == format_parameter_file(wanted, f"Tuned on {dive}.")
    window.press("s")
    target = tmp_path / "tuned.yaml"
    target.write_text("precious", encoding="utf-8")
    window.at("save-path").fill(str(target))
    window.at("dialog-ok").locator("visible=true").click()
    window.page.get_by_text("exists already").wait_for()
    assert target.read_text(encoding="utf-8") == "precious"
    window.at("dialog-ok").locator("visible=true").click()
    window.page.get_by_text("saved:").wait_for()
    assert read_parameter_file(target) == wanted.as_mapping()


def test_parameters_are_loaded_from_a_file(window, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("particle_count: 300\ntempering: 0.05\n", encoding="utf-8")
    window.at("file").set_input_files(file)
    window.page.wait_for_function("document.querySelector('#p-particle_count').value === '300'")
    assert window.at("reference").input_value() == "mine.yaml"
    assert window.field("tempering").input_value() == "0.05"


def test_a_bad_file_is_explained_and_changes_nothing(window, tmp_path):
    file = tmp_path / "bad.yaml"
    for text, words in (
        ("a: [", "cannot be read as YAML"),
        ("colour: 3", "unknown parameter colour"),
        ("particle_count: -4", "outside"),
    ):
        file.write_text(text, encoding="utf-8")
        window.at("file").set_input_files(file)
        window.says("file-refusal", words)
        window.says("file-refusal", "Nothing has changed")
    assert window.at("differing").inner_text() == "all as there"


def test_after_a_reload_all_is_as_before(window):
    window.go_to(7)
    window.at("show-particles").uncheck()
    window.page.reload()
    again = Window(window.page)
    again.shows(frame=7)
    assert not again.at("show-particles").is_checked()
    assert again.at("show-truth").is_checked()


def test_two_browsers_see_what_each_other_does(window, visit, address):
    with visit(address) as page:
        other = Window(page)
        window.set("particle_count", 222)
        other.page.wait_for_function("document.querySelector('#p-particle_count').value === '222'")
        with window.slow():
            other.press("Space")
            window.at("pause").wait_for()
            window.wait_for(f"{PICTURE}.frame > 3")
            shown = window.picture()["frame"]
            page.close()
            window.wait_for(f"{PICTURE}.frame > {shown + 3}")
            window.press("Space")
            window.at("play").wait_for()


def test_the_keys_are_listed(window):
    window.press("?")
    dialog = window.page.get_by_role("dialog")
    dialog.get_by_text("play or pause").wait_for()
    window.press("Escape")
    dialog.wait_for(state="hidden")


def test_nothing_is_wider_than_the_screen(window):
    for width, height in ((1280, 800), (1024, 768), (820, 1180)):
        window.page.set_viewport_size({"width": width, "height": height})
        assert window.page.evaluate("document.documentElement.scrollWidth") <= width
        area = window.page.locator(".ct-stage canvas").bounding_box()
        assert area["width"] > 0.4 * width
        assert area["height"] > 300


def test_a_recording_is_opened_from_the_page_and_the_server_may_go(visit, run_command, dive):
    command = run_command("gui")
    with visit(command.url) as page:
        page.get_by_text("No recording is open").wait_for()
        page.keyboard.press("o")
        path = page.locator("[data-test=open-path]")
        path.fill(str(dive.parent / "missing.bag"))
        path.press("Enter")
        page.get_by_text("there is no such file").wait_for()
        path.fill(str(dive))
        path.press("Enter")
        Window(page).shows(frame=0)
        command.stop()
        page.locator("[data-test=cut]").wait_for()
        assert command.process.returncode == 0


def test_what_is_to_be_known_of_a_recording_is_said_when_it_is_opened(visit, run_command, pictures):
    command = run_command("gui")
    with visit(command.url) as page:
        page.get_by_text("No recording is open").wait_for()
        page.keyboard.press("o")
        path = page.locator("[data-test=open-path]")
        path.fill(str(pictures))
        path.press("Enter")
        page.locator("[data-test=notes]", has_text="missing by their numbers").wait_for()


def result_of(coroutine):
    """Await in a thread of its own: Playwright keeps a loop running in this one."""
    with ThreadPoolExecutor(1) as executor:
        return executor.submit(asyncio.run, coroutine).result()


@pytest.mark.parametrize("answer", [RosError("the node has not answered"), {}])
def test_parameters_that_are_not_known_are_not_saved(answer):
    window = pytest.importorskip("cable_tracker.gui.tracking.window")
    shared = window.SharedSession(RecordingRequest(Path()), TrackerParameters())
    page = window.TrackingPage(shared)
    with pytest.raises(GuiError, match="no recording is open"):
        result_of(page._text_to_save())

    class Silent(StubSession):
        def parameters(self):
            if isinstance(answer, Exception):
                raise answer
            return answer

    shared.watch(Silent())
    with pytest.raises(CableTrackerError, match=r"has not answered|has told no"):
        result_of(page._text_to_save())
    shared.close()


def run_to_its_end(*arguments):
    if importlib.util.find_spec("nicegui") is None:
        pytest.skip("NiceGUI is not installed")
    return subprocess.run(
        [sys.executable, "-m", "cable_tracker.cli", "gui", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def test_a_port_that_is_taken_is_said(monkeypatch):
    pytest.importorskip("nicegui", reason="NiceGUI is not installed")
    serve = "cable_tracker.gui.tracking.window.serve_tracking_window"
    monkeypatch.setattr(serve, lambda *_, **__: pytest.fail("it serves"))
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(GuiError, match="choose another with --port"):
            app(["gui", "--port", str(taken.getsockname()[1])], standalone_mode=False)


@pytest.mark.slow
def test_instruments_that_would_not_be_read_are_refused(tmp_path):
    ended = run_to_its_end(tmp_path, "--target", "--altitude-topic", "none")
    assert ended.returncode == 2
    assert "leave it out" in ended.stderr


@pytest.mark.slow
def test_a_missing_recording_is_said(tmp_path):
    ended = run_to_its_end(tmp_path / "no.bag", "--port", 0)
    assert ended.returncode == 2
    assert "there is no such file or folder" in ended.stderr


def test_where_a_bag_holds_instruments_the_cable_is_shown_in_metres(
    visit, run_command, surveyed_dive
):
    command = run_command("gui", surveyed_dive, "--init", "truth", "--seed", "4")
    with visit(command.url) as page:
        window = Window(page)
        window.go_to(1)
        known = window.picture()["metres"]
        offset, heading = known["rows"]
        assert offset[0] == "offset" and known["why"] == ""
        window.says("metres-offset", f"{abs(offset[1]):.3f}")
        window.says("metres-heading", f"{abs(heading[1]):.2f}")
        window.page.locator("body").press("e")
        window.shows(status="'DISABLED'")
        window.says("no-metres", "no cable is claimed")
        assert window.picture()["metres"]["rows"][0][1] is None


def test_what_is_missing_for_metres_is_written_below_the_numbers(visit, run_command, surveyed_dive):
    given = ("--init", "truth", "--seed", "4", "--altitude-topic", "none")
    command = run_command("gui", surveyed_dive, *given)
    with visit(command.url) as page:
        window = Window(page)
        window.says("no-metres", "no metres: no altitude")
        assert "fixed_altitude" in window.at("no-metres").get_attribute("title")


def test_without_instruments_nothing_is_said_of_metres(window):
    assert window.at("metres-offset").count() == window.at("no-metres").count() == 0
