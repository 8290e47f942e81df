"""The tracking window on a target, in a real browser."""

import pytest

from cable_tracker.evaluation.targets.metrics import overlap

PICTURE = "document.querySelector('.ct-stage canvas')?.frameView?.description"


class Window:
    """A page, as a user sees it."""

    def __init__(self, page):
        self.page = page
        page.wait_for_function(f"{PICTURE} && {PICTURE}.status !== 'WARMING UP'")

    def at(self, name):
        return self.page.locator(f"[data-test={name}]")

    def picture(self):
        return self.page.evaluate(f"(({{parts, ...rest}}) => rest)({PICTURE})")

    def box(self):
        """Return left, top, right, bottom of what is drawn; None where no box is."""
        found = [layer for layer in self.picture()["layers"] if layer["name"] == "box"]
        if not found:
            return None
        xs, ys = found[0]["points"][::2], found[0]["points"][1::2]
        return min(xs), min(ys), max(xs), max(ys)

    def drag(self, box):
        """Draw a box on the picture."""
        ends = self.page.evaluate(
            """([x0, y0, x1, y1]) => {
              const canvas = document.querySelector('.ct-stage canvas'), view = canvas.frameView;
              const area = canvas.getBoundingClientRect(), [width, height] = view.description.size;
              const at = (x, y) => [area.left + area.width / 2 + (x - width / 2) * view.scale,
                                    area.top + area.height / 2 + (y - height / 2) * view.scale];
              return [at(x0, y0), at(x1, y1)];
            }""",
            list(box),
        )
        self.page.mouse.move(*ends[0])
        self.page.mouse.down()
        self.page.mouse.move(*ends[1], steps=4)
        self.page.mouse.up()


@pytest.fixture(scope="module")
def address(run_shared_command, target_dive):
    return run_shared_command("gui", target_dive, "--target", "--seed", "4").url


@pytest.fixture
def window(visit, address):
    with visit(address) as page:
        yield Window(page)


def test_a_box_that_is_drawn_is_followed_and_told_in_numbers(window, target_frames):
    window.drag(target_frames[0].box)
    window.page.wait_for_function(f"{PICTURE}.status === 'TRACKING'")
    assert overlap(window.box(), target_frames[0].box) > 0.5
    assert [layer["name"] for layer in window.picture()["layers"]] == [
        "band", "contour", "box", "truth",
    ]  # fmt: skip
    names = [window.at(f"state-{row}").inner_text().split()[0] for row in range(6)]
    assert names == ["x", "y", "scale", "angle", "v_x", "v_y"]
    window.page.wait_for_function("document.querySelector('[data-test=size]').innerText !== '–'")
    window.page.keyboard.press("ArrowRight")
    window.page.wait_for_function(f"{PICTURE}.frame === 1")
    assert overlap(window.box(), target_frames[1].box) > 0.5


def test_a_click_is_no_box(window):
    before = window.picture()["number"]
    window.page.locator(".ct-stage canvas").click()
    window.page.wait_for_timeout(500)
    assert window.page.locator(".q-notification").count() == 0
    assert window.page.locator(".ct-hint").count() == 0
    assert window.picture()["number"] == before


def test_parameters_are_those_of_targets(window):
    window.page.locator("#p-template_points").wait_for()
    assert window.page.locator("#p-skew_limit").count() == 0


def test_the_box_can_be_typed(window, target_frames):
    window.page.get_by_role("button", name="start at …").click()
    left, top, right, bottom = target_frames[0].box
    for label, value in (("left px", left), ("top px", top), ("right px", right)):
        window.page.get_by_label(label).fill(str(value))
    window.page.get_by_label("bottom px").fill(str(top))
    dialog = window.page.get_by_label("Start where the target is")
    dialog.locator("[data-test=dialog-ok]").click()
    dialog.locator("[data-test=dialog-refusal]").filter(has_text="px high").wait_for()
    window.page.get_by_label("bottom px").fill(str(bottom))
    dialog.locator("[data-test=dialog-ok]").click()
    window.page.wait_for_function(f"{PICTURE}.status === 'TRACKING'")
