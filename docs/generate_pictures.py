"""Draw the pictures of the documentation; run by hand, after `make demo`.

`python docs/generate_pictures.py` writes docs/images/demo.jpg: three frames of the overlay that
`make demo` has left in demo/.
"""

from __future__ import annotations

from pathlib import Path

import av
import cv2
import numpy as np

from cable_tracker.arrays import Image

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "images"
DEMO_VIDEO = ROOT / "demo" / "dive_tracked" / "overlay.webm"
DEMO_FRAMES = (60, 130, 270)
QUALITY = 80


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


def main() -> None:
    """Write all pictures."""
    PICTURES.mkdir(exist_ok=True)
    path = PICTURES / "demo.jpg"
    cv2.imwrite(str(path), demo_row(), (cv2.IMWRITE_JPEG_QUALITY, QUALITY))
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
