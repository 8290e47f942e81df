import pytest

from cable_tracker.metric.sea_bed_texture import TextureMotion
from cable_tracker.metric.texture_gate import CALM_PICTURES, REMEMBERED_PICTURES, TextureGate

RIGHT, WRONG = TextureMotion(0.4, 8.0), TextureMotion(9.0, 8.0)


def shown(*motions):
    gate = TextureGate()
    for motion in motions:
        gate.take(motion)
    return gate


def test_at_first_nothing_is_known():
    assert TextureGate().verdict is None


def test_odometry_is_believed_from_the_first_picture_that_agrees():
    assert shown(RIGHT).verdict is True


def test_one_picture_that_disagrees_is_enough():
    assert shown(*[RIGHT] * 50, WRONG).verdict is False


def test_then_it_takes_several_that_agree():
    assert shown(WRONG, *[RIGHT] * (CALM_PICTURES - 1)).verdict is False
    assert shown(WRONG, *[RIGHT] * CALM_PICTURES).verdict is True


@pytest.mark.parametrize("last", [RIGHT, WRONG])
def test_without_texture_the_last_verdict_holds_for_a_while(last):
    assert shown(last, *[None] * (REMEMBERED_PICTURES - 1)).verdict is last.agrees
    assert shown(last, *[None] * REMEMBERED_PICTURES).verdict is None
