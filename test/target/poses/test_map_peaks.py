from types import SimpleNamespace

import numpy as np

from cable_tracker.target.poses.map_peaks import NO_PEAKS, find_peaks, watch_rivals
from cable_tracker.target.poses.pose_belief import RivalWatch


def test_peaks_are_where_the_target_is_and_of_its_size(draw):
    mask = draw(centre=(240, 60), axes=(20, 20))[1]
    ratios = np.where(mask, 2.0, -1.0).astype(np.float32)
    peaks = find_peaks(ratios, (20.0, 20.0), np.array([-0.7, 0.0, 0.7]), 2, 0.3)
    x, y, log_scale, angle = peaks.poses[0]
    assert np.hypot(x - 80.5, y - 59.5) < 4.0
    assert log_scale <= 0.0
    assert angle == 0.3
    assert list(peaks.strengths) == sorted(peaks.strengths, reverse=True)


def test_where_nothing_stands_out_there_is_no_peak():
    flat = np.full((240, 320), -1.0, np.float32)
    assert len(find_peaks(flat, (9.0, 9.0), np.zeros(1), 3).poses) == 0


def test_what_is_believed_to_be_larger_than_the_picture_is_looked_for_as_large_as_it(draw):
    ratios = np.where(draw(centre=(90, 70))[1], 2.0, 1.0).astype(np.float32)
    as_large = find_peaks(ratios, (200.0, 150.0), np.zeros(1), 1)
    larger = find_peaks(ratios, (200.0, 150.0), np.full(1, 2.0), 1)
    assert len(larger.poses) == 1
    np.testing.assert_array_equal(larger.poses[:, :2], as_large.poses[:, :2])
    np.testing.assert_array_equal(larger.strengths, as_large.strengths)


def test_a_frame_without_peaks_breaks_the_row_of_frames_with_a_rival():
    belief = SimpleNamespace(rivals=RivalWatch(frames=4), estimate=np.zeros(6), size=20.0)
    watch = watch_rivals(belief, SimpleNamespace(), NO_PEAKS, 0.04)
    assert watch.frames == 0
