from __future__ import annotations

import cv2
import numpy as np
import pytest

from cable_tracker.ros.rigs.soak.frames import SoakFrames
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("encoding", ["mono8", "bgr8"])
def test_a_tall_frame_is_the_left_part_of_a_whole_one(compressed, encoding):
    levels = np.tile(np.arange(60, 120, dtype=np.uint8), (30, 1))
    picture = levels if encoding == "mono8" else np.dstack([levels] * 3)
    frames = SoakFrames([Frame(0, 1, raw_from_array(picture, encoding))])
    frames.compressed = compressed
    before = frames.stamp
    message = frames.tall_message()
    assert frames.stamp > before
    data = np.frombuffer(message.data, np.uint8)
    if compressed:
        shown = cv2.imdecode(data, cv2.IMREAD_UNCHANGED).reshape(30, 15, -1)
        whole = picture[:, :15].reshape(30, 15, -1)
        assert np.abs(shown.astype(int) - whole).max() < 12
    else:
        assert (message.width, message.height) == (15, 30)
        assert np.array_equal(data.reshape(30, 15, -1), picture[:, :15].reshape(30, 15, -1))
