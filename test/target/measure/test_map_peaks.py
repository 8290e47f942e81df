import numpy as np

from cable_tracker.target.measure.map_peaks import find_peaks


def test_peaks_are_where_the_target_is_and_of_its_size(draw):
    mask = draw(centre=(240, 60), axes=(20, 20))[1]
    ratios = np.where(mask, 2.0, -1.0).astype(np.float32)
    peaks = find_peaks(ratios, (20.0, 20.0), np.array([-0.7, 0.0, 0.7]), 2)
    assert np.hypot(peaks[0].x - 80.5, peaks[0].y - 59.5) < 4.0
    assert peaks[0].log_scale <= 0.0
    assert [p.strength for p in peaks] == sorted((p.strength for p in peaks), reverse=True)


def test_where_nothing_stands_out_there_is_no_peak():
    flat = np.full((240, 320), -1.0, np.float32)
    assert all(peak.strength < 0.0 for peak in find_peaks(-flat, (9.0, 9.0), np.zeros(1), 3)) or (
        len(find_peaks(flat, (9.0, 9.0), np.zeros(1), 3)) == 0
    )


def test_what_is_believed_to_be_larger_than_the_picture_is_looked_for_as_large_as_it(draw):
    ratios = np.where(draw(centre=(90, 70))[1], 2.0, 1.0).astype(np.float32)
    (as_large,) = find_peaks(ratios, (200.0, 150.0), np.zeros(1), 1)
    (larger,) = find_peaks(ratios, (200.0, 150.0), np.full(1, 2.0), 1)
    assert larger[:2] == as_large[:2]
    assert larger.strength == as_large.strength
