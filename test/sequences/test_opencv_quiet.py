from __future__ import annotations

import subprocess
import sys


def test_opencv_says_nothing_of_a_picture_that_it_cannot_read(tmp_path):
    path = tmp_path / "missing.png"
    code = (
        "import sys; sys.path[:] = " + repr(sys.path) + "\n"
        "import cv2\n"
        "from cable_tracker.sequences.opencv_quiet import silence_opencv\n"
        "silence_opencv()\n"
        f"assert cv2.imread({str(path)!r}) is None\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stderr == ""
