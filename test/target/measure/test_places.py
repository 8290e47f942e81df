import numpy as np

from cable_tracker.target.measure.places import find_places


def test_peaks_are_where_the_target_is_and_of_its_size(draw):
    mask = draw(centre=(240, 60), axes=(20, 20))[1]
    ratios = np.where(mask, 2.0, -1.0).astype(np.float32)
    places = find_places(ratios, (20.0, 20.0), np.array([-0.7, 0.0, 0.7]), 2)
    assert np.hypot(places[0].x - 80.5, places[0].y - 59.5) < 4.0
    assert places[0].log_scale <= 0.0
    assert [p.strength for p in places] == sorted((p.strength for p in places), reverse=True)


def test_where_nothing_stands_out_there_is_no_place():
    flat = np.full((240, 320), -1.0, np.float32)
    assert all(
        place.strength < 0.0 for place in find_places(-flat, (9.0, 9.0), np.zeros(1), 3)
    ) or (len(find_places(flat, (9.0, 9.0), np.zeros(1), 3)) == 0)
