import numpy as np

from cable_tracker.target.model.state import STATE_SIZE, at_rest, distances_from

POSES = np.array([[3.0, 4.0, 0.1, 0.2], [0.0, -2.0, 0.0, 0.0]])


def test_distances_count_the_place_alone():
    assert distances_from(0.0, 0.0, POSES).tolist() == [5.0, 2.0]
    assert distances_from(3.0, 2.0, at_rest(POSES)).tolist() == [2.0, 5.0]


def test_a_pose_at_rest_has_no_rates():
    states = at_rest(POSES)
    assert states.shape == (2, STATE_SIZE)
    np.testing.assert_array_equal(states[:, :4], POSES)
    assert not states[:, 4:].any()
