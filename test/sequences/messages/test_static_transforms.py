import math

import numpy as np

from cable_tracker.sequences.messages.static_transforms import StaticTransform, pose_in


def about_z(angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def test_transforms_are_followed_over_several_frames_up_and_down():
    chain = (
        StaticTransform("base", "arm", about_z(0.2), np.array([1.0, 0.0, 0.0])),
        StaticTransform("arm", "camera", about_z(0.3), np.array([0.0, 2.0, 0.0])),
        StaticTransform("base", "sonar", about_z(-0.1), np.array([0.0, 0.0, -1.0])),
    )
    rotation, origin = pose_in(chain, "camera", "base")
    np.testing.assert_allclose(rotation, about_z(0.5), atol=1e-12)
    np.testing.assert_allclose(origin, about_z(0.2) @ [0.0, 2.0, 0.0] + [1.0, 0.0, 0.0])
    turned, _ = pose_in(chain, "camera", "sonar")
    np.testing.assert_allclose(turned, about_z(0.6), atol=1e-12)


def test_frames_that_are_not_connected_have_no_pose():
    chain = (StaticTransform("map", "other", np.eye(3), np.zeros(3)),)
    assert pose_in(chain, "camera", "base") is None


def test_frames_that_hang_on_each_other_end():
    chain = (
        StaticTransform("a", "b", np.eye(3), np.zeros(3)),
        StaticTransform("b", "a", np.eye(3), np.zeros(3)),
    )
    assert pose_in(chain, "a", "c") is None
