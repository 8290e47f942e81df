"""Draw the pictures of the documentation; run by hand, after `make demo loop`, for a minute.

`python docs/generate_pictures.py` writes docs/images/demo.jpg, three frames of the overlay that
`make demo` has left in demo/; and docs/images/scenarios.jpg, a row of frames of every scenario, the
true borders drawn as dashes in the second of each pair; and what docs/loop.md shows of the run that
`make loop` has left there.
"""

from __future__ import annotations

import shutil
from itertools import islice
from pathlib import Path

import av
import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.simulation.dive import SimulatedFrame
from cable_tracker.simulation.scenario_dive import simulate_scenario
from cable_tracker.simulation.scenarios import SCENARIOS
from cable_tracker.visualisation.overlay import draw_overlay

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "images"
DEMO_VIDEO = ROOT / "demo" / "dive_tracked" / "overlay.webm"
DEMO_FRAMES = (60, 130, 270)
LOOP = ROOT / "demo" / "loop"
LOOP_PLOTS = {"way.png": "loop_way.png", "cross_track.png": "loop_error.png"}
LOOP_FRAMES = (700, 1600)
COLUMNS = 6
GAP = 4
QUALITY = 72


def label(picture: Image, text: str) -> None:
    """Write a line into the lower left corner."""
    corner = (5, picture.shape[0] - 7)
    cv2.putText(picture, text, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 3, cv2.LINE_AA)
    white = (255, 255, 255)
    cv2.putText(picture, text, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.42, white, 1, cv2.LINE_AA)


def cell(name: str, simulated: SimulatedFrame, *, with_truth: bool) -> Image:
    """Return one picture of the sheet."""
    frame = simulated.frame
    truth = frame.truth if with_truth else None
    grey = decode_grey(frame.image)
    picture = draw_overlay(grey, state=None, status="", truth=truth, legend=False)
    label(picture, f"{name}  frame {frame.index}  {100 * simulated.visibility:.0f} % visible")
    return cv2.copyMakeBorder(picture, 0, GAP, 0, GAP, cv2.BORDER_CONSTANT, value=(40, 40, 40))


def scenario_row(name: str, seed: int) -> Image:
    """Return a row of frames spread over a scenario."""
    count = SCENARIOS[name].frame_count
    places = [int((column + 0.5) * count / COLUMNS) for column in range(COLUMNS)]
    frames = islice(simulate_scenario(name, seed), places[-1] + 1)
    chosen = [each for each in frames if each.frame.index in places]
    cells = [cell(name, each, with_truth=place % 2 == 1) for place, each in enumerate(chosen)]
    return np.hstack(cells)


def scenario_sheet(seed: int = 0) -> Image:
    """Return the contact sheet of all scenarios, blue-green-red."""
    sheet = np.vstack([scenario_row(name, seed) for name in SCENARIOS])
    return cv2.resize(sheet, None, fx=0.75, fy=0.75, interpolation=cv2.INTER_AREA)


def video_frames(path: Path, places: tuple[int, ...]) -> list[Image]:
    """Return some frames of a video, blue-green-red."""
    with av.open(str(path)) as video:
        return [
            frame.to_ndarray(format="bgr24")
            for place, frame in enumerate(video.decode(video=0))
            if place in places
        ]


def demo_row() -> Image:
    """Return frames of the demo side by side."""
    return np.hstack(video_frames(DEMO_VIDEO, DEMO_FRAMES))


def write(name: str, picture: Image) -> None:
    """Write a picture of the documentation."""
    path = PICTURES / name
    cv2.imwrite(str(path), picture, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


def main() -> None:
    """Write all pictures."""
    PICTURES.mkdir(exist_ok=True)
    write("demo.jpg", demo_row())
    write("scenarios.jpg", scenario_sheet())
    write("loop_video.jpg", np.hstack(video_frames(LOOP / "loop.webm", LOOP_FRAMES)))
    for plot, name in LOOP_PLOTS.items():
        shutil.copyfile(LOOP / plot, PICTURES / name)


if __name__ == "__main__":
    main()
