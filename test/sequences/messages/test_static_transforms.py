import math

import numpy as np

from cable_tracker.sequences.messages.static_transforms import StaticTransform, place_in


def about_z(angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def test_transforms_are_followed_over_several_frames_up_and_down():
    chain = (
        StaticTransform("base", "arm", about_z(0.2), np.array([1.0, 0.0, 0.0])),
        StaticTransform("arm", "camera", about_z(0.3), np.array([0.0, 2.0, 0.0])),
        StaticTransform("base", "sonar", about_z(-0.1), np.array([0.0, 0.0, -1.0])),
    )
    rotation, place = place_in(chain, "camera", "base")
    np.testing.assert_allclose(rotation, about_z(0.5), atol=1e-12)
    np.testing.assert_allclose(place, about_z(0.2) @ [0.0, 2.0, 0.0] + [1.0, 0.0, 0.0])
    turned, _ = place_in(chain, "camera", "sonar")
    np.testing.assert_allclose(turned, about_z(0.6), atol=1e-12)


def test_frames_that_are_not_connected_have_no_place():
    chain = (StaticTransform("map", "other", np.eye(3), np.zeros(3)),)
    assert place_in(chain, "camera", "base") is None


def test_frames_that_hang_on_each_other_end():
    chain = (
        StaticTransform("a", "b", np.eye(3), np.zeros(3)),
        StaticTransform("b", "a", np.eye(3), np.zeros(3)),
    )
    assert place_in(chain, "a", "c") is None
