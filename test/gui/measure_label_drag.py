"""Measure how soon the picture is drawn again after the pointer has moved, in headless Chromium.

Run it as ``python test/gui/measure_label_drag.py [SOURCE]`` with the package on PYTHONPATH; without
a recording it renders one of 640x480.
"""

import statistics
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
from conftest import CHROMIUM, Running
from playwright.sync_api import sync_playwright

MOVES = 200
WAIT_FOR_LABEL = """() => {
    const { editor } = document.querySelector(".label-editor") ?? {};
    return editor?.hasPicture && editor.shown;
}"""
OBSERVE = """() => {
    const { editor } = document.querySelector(".label-editor");
    const paint = editor.view.paint.bind(editor.view);
    window.times = [];
    let moved = null;
    editor.view.canvas.addEventListener("pointermove", (event) => (moved = event.timeStamp), true);
    editor.view.paint = () => {
        paint();
        if (moved !== null) window.times.push(performance.now() - moved);
        moved = null;
    };
}"""


def render(folder):
    rng = np.random.default_rng(1)
    for number in range(5):
        picture = rng.normal(70.0, 8.0, (480, 640))
        picture[:, 280:360] += 90.0
        cv2.imwrite(str(folder / f"{number}.png"), np.clip(picture, 0, 255).astype(np.uint8))
    return folder


def measure(url):
    """Return the milliseconds from each movement of the pointer to the end of the next drawing."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(url)
        page.wait_for_function(WAIT_FOR_LABEL)
        page.evaluate(OBSERVE)
        box = page.locator(".frame-canvas").bounding_box()
        middle = page.evaluate(
            """() => document.querySelector(".label-editor").editor.shown[0]
                     * document.querySelector(".label-editor").editor.view.scale"""
        )
        x, y = box["x"] + box["width"] / 2 + middle, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        for number in range(MOVES):
            page.mouse.move(x + 80 * np.sin(number / 10), y)
        page.mouse.up()
        times = page.evaluate("window.times")
        browser.close()
    return times


def main():
    with tempfile.TemporaryDirectory() as home:
        folder = Path(home) / "dive"
        folder.mkdir()
        source = sys.argv[1] if len(sys.argv) > 1 else render(folder)
        running = Running(
            ["label", source, "--labels", Path(home) / "labels.txt", "--port", "0"], home
        )
        try:
            times = measure(running.url)
        finally:
            running.stop()
    deciles = statistics.quantiles(times, n=10)
    print(
        f"{len(times)} drawings: median {statistics.median(times):.1f} ms,"
        f" nine of ten within {deciles[-1]:.1f} ms"
    )


if __name__ == "__main__":
    main()
