import math

import numpy as np
import pytest

from cable_tracker.target.model.camera_motion import CameraMotion

SIZE, FOCAL = (320, 240), 277.0


def turned(degrees):
    """What a turn of the camera to the left [deg] does to a picture."""
    angle = math.radians(degrees)
    rotation = np.array(
        [
            [math.cos(angle), 0.0, math.sin(angle)],
            [0.0, 1.0, 0.0],
            [-math.sin(angle), 0.0, math.cos(angle)],
        ]
    )
    matrix = np.diag([FOCAL, FOCAL, 1.0])
    mapping = matrix @ rotation @ np.linalg.inv(matrix)
    return CameraMotion(mapping / mapping[2, 2])


@pytest.mark.parametrize("degrees", [0.0, 10.0, 45.0, -45.0])
def test_turns_that_leave_the_picture_before_the_camera_are_told(degrees):
    assert turned(degrees).keeps_picture(SIZE)


@pytest.mark.parametrize("degrees", [70.0, 80.0, 89.9, 90.0, 90.1, 120.0, 180.0, -89.9])
def test_turns_to_the_side_and_to_the_back_are_told(degrees):
    assert not turned(degrees).keeps_picture(SIZE)


@pytest.mark.parametrize("degrees", [180.0, 90.0])
def test_a_roll_keeps_the_picture_however_far(degrees):
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    roll = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    assert CameraMotion(roll).keeps_picture(SIZE)


def test_a_pose_far_beyond_the_picture_turns_out_on_its_own_side():
    poses = np.zeros((3, 6))
    poses[:, 0] = [100.0, 400.0, 4000.0]
    moved = turned(45.0).moved(poses, 1.0)
    assert (moved[:, 0] > poses[:, 0]).all()
    assert np.abs(moved[:, 2]).max() < 3.0
