from __future__ import annotations

import subprocess
import sys

import pytest


@pytest.mark.parametrize(("given", "expected"), [(None, "-8"), ("48", "48")])
def test_a_level_the_user_has_set_is_left_alone(given, expected):
    code = (
        "import os, sys; sys.path[:] = " + repr(sys.path) + "\n"
        "os.environ.pop('OPENCV_FFMPEG_LOGLEVEL', None)\n"
        + (f"os.environ['OPENCV_FFMPEG_LOGLEVEL'] = {given!r}\n" if given else "")
        + "from cable_tracker.sequences.opencv_quiet import silence_opencv\n"
        "silence_opencv()\n"
        "print(os.environ['OPENCV_FFMPEG_LOGLEVEL'])\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == expected
