from types import SimpleNamespace

import numpy as np

from cable_tracker.target.poses.peak_poses import NO_PEAKS, watch_rivals
from cable_tracker.target.poses.rivals import RivalWatch


def test_a_frame_without_peaks_breaks_the_row_of_frames_with_a_rival():
    belief = SimpleNamespace(rivals=RivalWatch(frames=4), estimate=np.zeros(6), size=20.0)
    watch = watch_rivals(belief, SimpleNamespace(), NO_PEAKS, 0.04)
    assert watch.frames == 0
