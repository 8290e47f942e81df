"""The tracking window on a target, in a real browser."""

import pytest
from tracking_page import PICTURE, TrackingPage

from cable_tracker.evaluation.targets.comparison import overlap


class Window(TrackingPage):
    """A page on which a target is followed."""

    def box(self):
        """Return left, top, right, bottom of what is drawn; None where no box is."""
        found = [layer for layer in self.picture()["layers"] if layer["name"] == "box"]
        if not found:
            return None
        xs, ys = found[0]["points"][::2], found[0]["points"][1::2]
        return min(xs), min(ys), max(xs), max(ys)

    def draw(self, box):
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
        self.drag(*ends)


@pytest.fixture(scope="module")
def address(run_shared_command, target_dive):
    return run_shared_command("gui", target_dive, "--target", "--seed", "4").url


@pytest.fixture
def window(visit, address):
    with visit(address) as page:
        yield Window(page)


def test_a_box_that_is_drawn_is_followed_and_told_in_numbers(window, target_frames):
    window.draw(target_frames[0].box)
    window.wait_for(f"{PICTURE}.status === 'TRACKING'")
    assert overlap(window.box(), target_frames[0].box) > 0.5
    assert [layer["name"] for layer in window.picture()["layers"]] == [
        "band", "contour", "box", "truth",
    ]  # fmt: skip
    names = [window.at(f"state-{row}").inner_text().split()[0] for row in range(6)]
    assert names == ["x", "y", "scale", "angle", "v_x", "v_y"]
    window.wait_for("document.querySelector('[data-test=size]').innerText !== '–'")
    window.page.keyboard.press("ArrowRight")
    window.wait_for(f"{PICTURE}.frame === 1")
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
    window.wait_for(f"{PICTURE}.status === 'TRACKING'")
