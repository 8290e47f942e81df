"""The window in a real browser: what is done there, and what the saved file says then."""

import math
import signal
from contextlib import contextmanager, nullcontext
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from cable_tracker.cable.model.geometry import project_borders
from cable_tracker.gui.labelling.label_file import flags_path, read_label_file
from cable_tracker.sequences.labels.frame_names import names_of
from cable_tracker.sequences.source import open_source

from ..conftest import visiting, wait_until
from .conftest import COUNT, SIZE, true_state

OBLIQUE = (20.0, 0.4, 50.0, 0.06)
ALL = "document.querySelector('.label-editor')"
NAME_OF_FOCUS = """(({ ariaLabel, innerText, labels }) =>
    ariaLabel || innerText || labels?.[0]?.innerText || "")(document.activeElement)"""
numbers = count()


def label_line(state, frame=0):
    return f"{' '.join(map(repr, state))} # dive/{frame:03d}.png\n"


class Editor:
    """A page with the window, and what a user sees of it."""

    def __init__(self, page):
        self.page = page
        self.strokes = 0
        self.wait("editor && editor.hasPicture")

    def ask(self, expression):
        return self.page.evaluate(
            f"(() => {{ const {{ editor }} = {ALL}; return {expression} }})()"
        )

    def wait(self, expression):
        self.page.wait_for_function(
            f"(() => {{ const {{ editor }} = {ALL} ?? {{}}; return {expression} }})()"
        )

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)
            self.strokes += 1

    def at(self, frame, flag=None):
        """Wait until a frame is shown, with a label of a kind."""
        self.wait(f"editor.frame === {frame} && editor.wanted === {frame}")
        if flag is not None:
            self.wait(f"editor.flag === '{flag}'")

    def manual(self):
        """Let nothing be proposed unasked."""
        self.page.get_by_label("propose automatically").uncheck()
        self.press("Escape")

    def open(self, path):
        """Open a label file by the dialog."""
        self.press("Control+o")
        field = self.page.get_by_label("file on the machine")
        field.fill(str(path))
        field.press("Enter")
        anyway = self.page.get_by_role("button", name="Open all the same")
        shown = self.page.locator(f".file:text-is('{Path(path).name}')")
        anyway.or_(shown).first.wait_for()
        if anyway.is_visible():
            anyway.click()
        shown.wait_for()
        self.closed()

    def closed(self):
        """Wait until no dialog is left."""
        self.page.wait_for_function("!document.querySelector('.q-dialog')")

    def save(self):
        self.press("Control+s")
        self.page.locator("[data-test=saved]:text-is('saved')").wait_for()

    def on_screen(self, point):
        """Where a point of the image frame is on the screen."""
        box = self.page.locator(".frame-canvas").bounding_box()
        scale = min(box["width"] / SIZE[0], box["height"] / SIZE[1])
        return (
            box["x"] + box["width"] / 2 + scale * point[0],
            box["y"] + box["height"] / 2 - scale * point[1],
        )

    def drag(self, start, end, modifier=None):
        mouse = self.page.mouse
        mouse.move(*self.on_screen(start))
        mouse.down()
        if modifier:
            self.page.keyboard.down(modifier)
        mouse.move(*self.on_screen(np.add(start, end) / 2))
        mouse.move(*self.on_screen(end))
        mouse.up()
        if modifier:
            self.page.keyboard.up(modifier)

    def handles(self):
        """The handles by kind and side, as points of the image frame."""
        rows = self.page.evaluate(
            f"""async () => {{
                const {{ labelGeometry, visibleRectangle }} = await import("cable-tracker-browser");
                const {{ editor }} = {ALL};
                return labelGeometry.handlesOf(editor.shown, visibleRectangle(editor.view)).points;
            }}"""
        )
        return [(row["kind"], row.get("side"), tuple(row["at"])) for row in rows]


@pytest.fixture(scope="module")
def page(chromium, window):
    """A page that most tests share; each of them opens a label file of its own."""
    with visiting(chromium, window.url) as page:
        yield page


@pytest.fixture
def edit(window, page, visit):
    """Return a context: an editor on a label file of its own, with given lines."""

    @contextmanager
    def editing(*lines, **options):
        path = window.home / f"labels_{next(numbers)}.txt"
        path.write_text("# labels\n" + "".join(lines))
        with visit(window.url, **options) if options else nullcontext(page) as own:
            editor = Editor(own)
            editor.path = path
            editor.manual()
            editor.open(path)
            own.locator(".frame-canvas").focus()
            editor.press("Home", "0")
            editor.at(0)
            yield editor

    return editing


@pytest.fixture
def saved(window):
    """Return a function that reads a saved file."""
    names = names_of(open_source(window.home / "dive"))
    return lambda path: dict(read_label_file(path, names).labels)


def places(label):
    return label.state.to_array()[:4]


def offset_of(point, angle):
    return point[0] * math.cos(angle) + point[1] * math.sin(angle)


def contains(state, side, point):
    """How far a border (-1, 1) or the centreline (None) runs from a point."""
    if side is None:
        return abs(offset_of(point, state[1]) - state[0])
    borders = project_borders(np.array([state]))
    column = {-1: 0, 1: 1}[side]
    return abs(offset_of(point, borders.angles[0, column]) - borders.offsets[0, column])


def test_each_handle_does_what_it_says(edit, saved):
    with edit(label_line(OBLIQUE)) as editor:
        editor.at(0, "hand")
        handles = editor.handles()
        middle = next(at for kind, _, at in handles if kind == "move")
        for kind, side, start in handles:
            end = np.add(start, (14.0, 9.0))
            editor.drag(start, end)
            editor.save()
            state = places(saved(editor.path)[0])
            near = pytest.approx(0.0, abs=0.3)
            if kind == "move":
                moved = offset_of((14.0, 9.0), OBLIQUE[1])
                assert state == pytest.approx((OBLIQUE[0] + moved, *OBLIQUE[1:]), abs=0.3)
            elif kind == "rotate":
                assert contains(state, None, end) == near
                assert contains(state, None, middle) == near
                assert state[3] == pytest.approx(OBLIQUE[3])
            elif kind == "widen":
                assert contains(state, side, end) == near
                before, after = (project_borders(np.array([s])) for s in (OBLIQUE, state))
                other = {-1: 1, 1: 0}[side]
                assert after.offsets[0, other] == pytest.approx(before.offsets[0, other])
                assert after.angles == pytest.approx(before.angles)
            else:
                assert contains(state, side, end) == near
                widen = next(at for k, s, at in handles if (k, s) == ("widen", side))
                assert contains(state, side, widen) == near
                assert state[:2] == pytest.approx(OBLIQUE[:2])
            editor.press("Control+z")
            editor.wait(
                f"{list(OBLIQUE)}.every((value, i) => Math.abs(editor.shown[i] - value) < 1e-9)"
            )


def test_the_body_moves_and_shift_widens_both_sides(edit, saved):
    with edit(label_line((0.0, 0.0, 60.0, 0.0))) as editor:
        editor.at(0, "hand")
        editor.drag((12, 40), (30, 55))
        editor.drag((48, 0), (58, 0), "Shift")
        editor.save()
        assert places(saved(editor.path)[0]) == pytest.approx((18.0, 0.0, 80.0, 0.0), abs=0.5)


def test_a_cable_is_drawn_by_one_drag(edit, saved):
    with edit() as editor:
        editor.at(0, "none")
        editor.drag((-40, -80), (20, 80))
        editor.at(0, "hand")
        editor.save()
        state = places(saved(editor.path)[0])
        assert contains(state, None, (-40, -80)) == pytest.approx(0.0, abs=0.3)
        assert contains(state, None, (20, 80)) == pytest.approx(0.0, abs=0.3)


def begin_drag(editor):
    editor.page.mouse.move(*editor.on_screen((0, 0)))
    editor.page.mouse.down()
    editor.page.mouse.move(*editor.on_screen((5, 0)))


def end_drag(editor):
    editor.page.mouse.move(*editor.on_screen((18, 0)))
    editor.page.mouse.up()


def test_a_drag_goes_on_when_the_same_picture_comes_again(edit):
    with edit(label_line((0.0, 0.0, 60.0, 0.0))) as editor:
        editor.at(0, "hand")
        begin_drag(editor)
        editor.ask("editor.received({ ...editor.view.description, frame: 0 })")
        end_drag(editor)
        assert editor.ask("editor.labels.get(0).state[0]") == pytest.approx(18.0, abs=0.5)


@pytest.mark.parametrize(("key", "frame"), [("Escape", 0), ("PageDown", 1)])
def test_a_cancelled_drag_changes_no_label(edit, key, frame):
    with edit(label_line((0.0, 0.0, 60.0, 0.0))) as editor:
        editor.at(0, "hand")
        begin_drag(editor)
        editor.press(key)
        editor.at(frame)
        end_drag(editor)
        assert editor.ask("editor.labels.get(0).state[0]") == 0.0
        assert editor.ask("editor.labels.size") == 1


def test_zoom_and_pan_do_not_move_the_label(edit):
    with edit(label_line(OBLIQUE)) as editor:
        editor.at(0, "hand")
        editor.press("+", "+", "+", "Alt+ArrowLeft")
        assert editor.ask("editor.view.zoom") == pytest.approx(1.25**3)
        before = editor.ask("editor.view.middle")
        editor.drag((-60, 60), (-40, 50))
        assert editor.ask("editor.view.middle") != before
        assert editor.ask("editor.shown") == list(OBLIQUE)
        editor.press("0")
        assert editor.ask("editor.view.zoom") == 1


def test_what_is_drawn_is_hidden_while_a_key_is_down(edit):
    drawn = """(wanted) => {
        const { context, canvas } = document.querySelector(".label-editor").editor.view;
        const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
        return data.some((green, i) => i % 4 === 1 && green - data[i - 1] > 100) === wanted;
    }"""
    with edit(label_line(OBLIQUE)) as editor:
        editor.at(0, "hand")
        editor.page.wait_for_function(drawn, arg=True)
        editor.page.keyboard.down("v")
        editor.page.wait_for_function(drawn, arg=False)
        editor.page.keyboard.up("v")
        editor.page.wait_for_function(drawn, arg=True)


def test_fingers_drag_and_pinch(edit):
    touch = """([name, id, x, y]) => document.querySelector('.frame-canvas').dispatchEvent(
        new PointerEvent(name, { pointerId: id, pointerType: 'touch', clientX: x, clientY: y,
                                 button: 0, bubbles: true, cancelable: true }))"""
    with edit(label_line((0.0, 0.0, 60.0, 0.0)), size=(1024, 768)) as editor:
        editor.at(0, "hand")
        # A pointer that a script makes cannot be captured.
        editor.page.evaluate("Element.prototype.setPointerCapture = () => {}")

        def finger(name, number, point):
            editor.page.evaluate(touch, [name, number, *editor.on_screen(point)])

        finger("pointerdown", 1, (0, 0))
        finger("pointermove", 1, (15, 0))
        finger("pointerup", 1, (15, 0))
        assert editor.ask("editor.shown[0]") == pytest.approx(15.0, abs=0.1)
        finger("pointerdown", 1, (-100, 0))
        finger("pointerdown", 2, (100, 0))
        finger("pointermove", 1, (-150, 0))
        finger("pointermove", 2, (150, 0))
        finger("pointerup", 1, (-150, 0))
        finger("pointerup", 2, (150, 0))
        assert editor.ask("editor.view.zoom") == pytest.approx(1.5)
        assert editor.ask("editor.shown[0]") == pytest.approx(15.0, abs=0.1)


def test_keys_and_numbers_change_the_label(edit, saved):
    with edit(label_line((10.0, 0.0, 60.0, 0.0))) as editor:
        editor.at(0, "hand")
        editor.press("ArrowRight", "Shift+ArrowRight", "ArrowLeft", "ArrowUp", "Shift+ArrowUp")
        editor.press("ArrowDown", "d", "q", "Shift+Q")
        assert editor.ask("editor.shown") == pytest.approx(
            [editor.ask("editor.shown[0]"), math.radians(5.5), 70.0, math.radians(0.5)], abs=0.1
        )
        assert editor.ask("editor.shown[0]") == pytest.approx(20.0, abs=0.3)
        for name, value in (("d", "-12.5"), ("α", "10"), ("w", "44"), ("β", "-2")):
            field = editor.page.locator(f"[data-test='{name}']")
            field.fill(value)
            field.press("Enter")
        editor.save()
        assert places(saved(editor.path)[0]) == pytest.approx(
            (-12.5, math.radians(10), 44.0, math.radians(-2))
        )


def test_twenty_frames_of_proposals_take_twenty_strokes(edit, saved):
    with edit() as editor:
        editor.page.get_by_label("propose automatically").check()
        editor.page.locator(".frame-canvas").focus()
        editor.strokes = 0
        for frame in range(20):
            editor.at(frame, "proposal")
            editor.press("Enter")
        strokes = editor.strokes
        editor.at(20)
        editor.save()
        labels = saved(editor.path)
        assert sorted(labels) == list(range(20))
        assert strokes == 20
        assert {label.flag for label in labels.values()} == {"proposed"}
        away = [abs(places(labels[n])[0] - true_state(n).distance) for n in range(20)]
        assert np.median(away) < 2.0


def test_a_proposal_that_is_corrected_is_drawn_by_hand(edit, saved):
    with edit() as editor:
        editor.press("p")
        editor.at(0, "proposal")
        editor.press("ArrowRight", "Enter")
        editor.at(1)
        editor.save()
        assert saved(editor.path)[0].flag == "hand"


def test_a_proposal_is_no_label_until_it_is_accepted(edit, saved):
    with edit() as editor:
        editor.press("p")
        editor.at(0, "proposal")
        editor.press("PageDown")
        editor.at(1)
        assert editor.ask("editor.labels.size") == 0


def test_nothing_is_accepted_where_nothing_is_drawn(edit):
    with edit() as editor:
        editor.press("Enter")
        editor.page.locator("[data-test=message]:has-text('nothing is drawn')").wait_for()
        assert editor.ask("editor.wanted") == 0


def test_copy_interpolate_no_cable_and_undo(edit, saved):
    with edit(label_line((0.0, 0.0, 40.0, 0.0))) as editor:
        editor.press("c")
        editor.at(1, "hand")
        editor.press("n")
        editor.at(1, "no_cable")
        editor.press("Shift+PageDown")
        editor.at(11, "none")
        editor.press("Shift+PageUp", "PageDown")
        editor.at(2, "none")
        editor.press("j", "j", "c")
        editor.at(1, "hand")
        editor.press("PageDown", "PageDown", "PageDown", "PageDown")
        editor.at(5, "none")
        # Strokes on an empty frame begin with the last label before.
        editor.press("ArrowRight")
        editor.at(5, "hand")
        editor.press("Shift+ArrowRight", "Shift+ArrowRight", "i")
        editor.wait("editor.labels.size === 6")
        editor.press("Home")
        editor.at(0)
        editor.press("n", "Enter")
        editor.at(1)
        editor.save()
        labels = saved(editor.path)
        assert [labels[n].flag for n in range(6)] == [
            "no_cable", "hand", "interpolated", "interpolated", "interpolated", "hand",
        ]  # fmt: skip
        assert [places(labels[n])[0] for n in range(1, 6)] == pytest.approx([0, 5, 10, 15, 20])
        editor.press("Control+z", "Control+z")
        editor.at(5)
        editor.wait("editor.labels.size === 3")
        editor.press("Control+Shift+Z")
        editor.wait("editor.labels.size === 6")


def test_two_browsers_share_the_labels_but_not_the_place(edit, window, visit):
    with edit(label_line(OBLIQUE)) as first, visit(window.url) as page:
        second = Editor(page)
        second.manual()
        second.press("PageDown")
        second.at(1)
        first.press("ArrowRight")
        second.wait("editor.labels.get(0).state[0] === 21")
        second.press("n")
        first.wait("editor.labels.get(1)?.flag === 'no_cable'")
        assert first.ask("editor.frame") == 0


def test_the_frame_is_remembered_over_a_reload(edit):
    with edit() as editor:
        editor.press("End")
        editor.at(COUNT - 1)
        editor.page.reload()
        Editor(editor.page).at(COUNT - 1)


@pytest.mark.parametrize(
    ("remembered", "frame"), [("500", COUNT - 1), ("1.5", 0), ("-3", 0), ("Infinity", 0), ("x", 0)]
)
def test_a_remembered_frame_that_is_none_leaves_the_window_alive(edit, remembered, frame):
    with edit() as before:
        before.ask(f"sessionStorage.setItem(editor.places, '{remembered}')")
        before.page.reload()
        editor = Editor(before.page)
        editor.manual()
        editor.at(frame)
        editor.press("n")
        editor.at(frame, "no_cable")
        editor.save()


def test_strokes_before_a_picture_hit_their_frame_and_hold_up_no_move(edit):
    with edit() as editor:
        # All within one script, before any picture can come.
        asked = editor.ask(
            "[editor.go(5), editor.command({ does: 'none' }), editor.command({ does: 'next' }),"
            " [editor.wanted, editor.queue.length, editor.frame]].at(-1)"
        )
        assert asked == [6, 0, 0]
        editor.at(6, "none")
        assert editor.ask("[...editor.labels.keys()]") == [5]
        editor.ask("[editor.go(9), editor.command({ does: 'none' }), editor.go(2)]")
        editor.at(2, "none")
        assert editor.ask("[...editor.labels.keys()]") == [5, 9]


def test_strokes_before_a_picture_are_saved(edit, saved):
    with edit() as editor:
        editor.ask(
            "[editor.go(5), editor.command({ does: 'none' }),"
            " editor.command({ does: 'save', large: false })]"
        )
        editor.at(5, "no_cable")
        editor.wait("!editor.status.changed")
        assert list(saved(editor.path)) == [5]


def test_strokes_for_a_frame_that_does_not_come_hit_no_other(edit):
    with edit() as editor:
        # What is said goes when frame 7 comes after all, which may be at once.
        said = editor.ask(
            "[editor.go(7), editor.command({ does: 'none' }), editor.received("
            "{ ...editor.view.description, request: editor.request, frame: 3 }),"
            " editor.message.text].at(-1)"
        )
        assert "frame 7 is not shown" in said
        editor.at(7, "none")
        assert editor.ask("editor.labels.size + editor.queue.length") == 0


def test_strokes_for_a_frame_that_is_gone_hit_no_other(edit):
    with edit() as editor:
        editor.ask(
            "[editor.go(20), editor.command({ does: 'none' }),"
            " editor.update({ labels: [], serial: editor.serial, count: 10 })]"
        )
        editor.at(9, "none")
        assert editor.ask("editor.labels.size + editor.queue.length") == 0


def test_the_slider_goes_to_a_frame(edit):
    with edit() as editor:
        slider = editor.page.get_by_role("slider")
        box = slider.bounding_box()
        slider.click(position={"x": box["width"] / 2, "y": box["height"] / 2})
        editor.at(round((COUNT - 1) / 2))
        slider.press("ArrowRight")
        editor.at(round((COUNT - 1) / 2) + 1)


def test_changed_files_are_not_overwritten_unasked(edit, saved):
    with edit(label_line(OBLIQUE)) as editor:
        editor.press("ArrowRight")
        editor.path.write_text(label_line((1.0, 0.0, 30.0, 0.0), 7))
        editor.press("Control+s")
        editor.page.get_by_text("has changed on the disk").wait_for()
        editor.page.get_by_role("button", name="Cancel").click()
        editor.closed()
        assert set(saved(editor.path)) == {7}
        editor.press("Control+s")
        editor.page.get_by_role("button", name="Overwrite").click()
        editor.page.locator("[data-test=saved]:text-is('saved')").wait_for()
        assert set(saved(editor.path)) == {0}


def test_saving_as_asks_before_it_overwrites(edit, saved, window):
    with edit(label_line(OBLIQUE)) as editor:
        other = window.home / f"other_{next(numbers)}.txt"
        other.write_text(label_line((1.0, 0.0, 30.0, 0.0), 7))
        editor.press("Control+Shift+S")
        field = editor.page.get_by_label("file on the machine")
        field.fill(str(other))
        field.press("Enter")
        editor.page.get_by_text("exists already").wait_for()
        assert set(saved(other)) == {7}
        editor.page.get_by_role("button", name="Overwrite").click()
        editor.page.locator(f".file:text-is('{other.name}')").wait_for()
        assert set(saved(other)) == {0}


def test_a_file_that_cannot_be_read_is_told_by_line(edit, window):
    with edit(label_line(OBLIQUE)) as editor:
        bad = window.home / "bad.txt"
        bad.write_text("1 2 3 # dive/000.png\n")
        editor.press("Control+o")
        field = editor.page.get_by_label("file on the machine")
        field.fill(str(bad))
        field.press("Enter")
        editor.page.locator("[data-test=message]:has-text('line 1')").wait_for()
        assert editor.ask("editor.labels.size") == 1
        assert bad.read_text() == "1 2 3 # dive/000.png\n"


def test_the_help_names_the_keys(edit):
    with edit() as editor:
        editor.press("h")
        dialog = editor.page.locator("dialog.help")
        dialog.get_by_text("accept what is drawn").wait_for()
        editor.press("Escape")
        dialog.wait_for(state="hidden")


def test_every_control_can_be_reached_and_is_named(edit):
    with edit(label_line(OBLIQUE)) as editor:
        editor.page.locator(".frame-canvas").focus()
        seen = set()
        for _ in range(30):
            editor.press("Tab")
            seen.add(editor.page.evaluate(NAME_OF_FOCUS).split("\n")[0].strip())
        for name in ("Open…", "Save", "Accept, next", "No cable", "propose automatically", "frame"):
            assert name in seen
        assert any(name.startswith("alpha") for name in seen)


def test_unsaved_labels_outlive_the_server(run_command, visit, folder, tmp_path):
    first = run_command("label", folder)
    path = tmp_path / "dive.txt"
    with visit(first.url) as page:
        editor = Editor(page)
        editor.manual()
        editor.press("n", "Enter", "n")
        editor.at(1, "no_cable")
        kept = tmp_path / "dive.txt.autosave"
        wait_until(page, lambda: kept.exists() and kept.read_text().count("no_cable") == 2)
        first.process.send_signal(signal.SIGKILL)
        first.process.wait()
    second = run_command("label", folder)
    with visit(second.url) as page:
        page.get_by_role("button", name="Resume").click()
        editor = Editor(page)
        editor.closed()
        editor.wait("editor.labels.size === 2")
        editor.save()
    assert flags_path(path).read_text().count("no_cable") == 2
    assert not kept.exists()
    assert second.stop() == 0


def test_strokes_for_a_frame_from_which_the_server_leads_away_hit_no_other(edit):
    with edit() as editor:
        # At once, before any picture can come.
        editor.ask(
            "[editor.go(15), editor.command({ does: 'none' }),"
            " editor.say({ text: 'there is no frame 15', kind: 'error' }), editor.goTo(14)]"
        )
        editor.at(14, "none")
        assert editor.ask("editor.labels.size + editor.queue.length") == 0


def test_a_broken_picture_ends_neither_the_recording_nor_a_proposal(
    run_command, visit, folder, tmp_path
):
    (folder / "015.png").write_bytes(b"no picture")
    (tmp_path / "dive.txt").write_text(label_line(OBLIQUE, 14))
    with visit(run_command("label", folder).url) as page:
        editor = Editor(page)
        editor.manual()
        editor.ask("editor.go(15)")
        editor.at(15)
        page.locator(".trouble:has-text('frame 15')").wait_for()
        editor.press("p")
        editor.wait("editor.asked === null && editor.message.kind === 'warning'")
        editor.press("PageDown", "p")
        editor.at(16, "proposal")


def test_a_frame_of_another_time_is_told_until_it_is_labelled_anew(run_command, visit, video):
    path = video.with_name("dive.avi.txt")
    path.write_text("10.0 0.0 60.0 0.0 # dive.avi:0\n")
    flags_path(path).write_text("frame,stamp,flag,file\n0,7,hand,dive.avi:0\n")
    warning = "[data-test=message]:has-text('had another time')"
    with visit(run_command("label", video).url) as page:
        editor = Editor(page)
        page.locator(warning).wait_for()
        editor.press("ArrowRight")
        editor.save()
        assert not flags_path(path).read_text().splitlines()[1].startswith("0,7,")
        editor.press("PageDown")
        editor.at(1)
        editor.press("PageUp")
        editor.at(0)
        assert page.locator(warning).count() == 0


def test_what_is_being_typed_stays_while_news_come(edit):
    with edit(label_line((10.0, 0.0, 60.0, 0.0))) as editor:
        editor.at(0, "hand")
        field = editor.page.locator("[data-test='w']")
        field.fill("4")
        editor.ask("editor.update({labels: [], serial: editor.serial, count: editor.count + 1})")
        editor.page.wait_for_function("document.querySelector('[data-test=w]').value === '4'")
        assert editor.ask("editor.count") > 8
        assert field.input_value() == "4"
        field.press("Enter")
        editor.page.wait_for_function("document.querySelector('[data-test=w]').value === '4'")
        assert editor.ask("editor.shown[2]") == pytest.approx(4.0)


def type_number(editor, name, text):
    editor.page.locator(f"[data-test='{name}']").click()
    editor.press("Control+a")
    editor.page.keyboard.type(text)


def test_a_typed_number_stays_with_its_frame(edit):
    with edit(label_line((10.0, 0.0, 60.0, 0.0)), label_line((13.0, 0.1, 60.0, 0.0), 3)) as editor:
        editor.press("i")
        editor.at(0, "hand")
        editor.wait("editor.labels.size === 4")
        type_number(editor, "d", "-4")
        editor.press("PageDown")
        editor.at(1, "interpolated")
        editor.press("PageDown")
        editor.at(2, "interpolated")
        editor.page.locator(".frame-canvas").focus()
        assert editor.ask("editor.labels.get(0).state[0]") == -4.0
        flags = [editor.ask(f"editor.labels.get({frame}).flag") for frame in range(4)]
        assert flags == ["hand", "interpolated", "interpolated", "hand"]


def test_a_typed_number_is_saved(edit, saved):
    with edit(label_line((10.0, 0.0, 60.0, 0.0))) as editor:
        editor.at(0, "hand")
        type_number(editor, "d", "50")
        editor.press("Control+s")
        editor.page.locator("[data-test=message]:has-text('saved')").wait_for()
        assert places(saved(editor.path)[0])[0] == 50.0


def test_labels_without_number_leave_strokes_possible(edit):
    with edit() as editor:
        filled = (
            "Array.from({ length: 300000 }, (_, i) => editor.labels.set(i - 300000,"
            " { flag: 'hand', state: [i, 0, 20, 0] })).length"
        )
        assert editor.ask(f"[{filled}, editor.stateBefore()]") == [300000, [299999, 0, 20, 0]]
        editor.ask("editor.goToKey(-1)")


def test_a_width_or_a_skew_that_cannot_be_is_refused(edit):
    with edit(label_line((10.0, 0.0, 60.0, 0.0))) as editor:
        editor.at(0, "hand")
        for name, value, before in (("w", "-30", "60"), ("β", "170", "0")):
            field = editor.page.locator(f"[data-test='{name}']")
            field.fill(value)
            field.press("Enter")
            editor.page.get_by_text(f"{name} cannot be {value}").wait_for()
            assert field.input_value() == before
