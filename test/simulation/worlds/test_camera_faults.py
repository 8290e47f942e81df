"""Light, compression, bars."""

import numpy as np
import pytest

from cable_tracker.simulation.worlds.camera_faults import (
    LampMotion,
    LossyCodec,
    random_light,
    random_overlay,
    random_sway,
)
from cable_tracker.simulation.worlds.catalogue import Disturbance, Optics


@pytest.fixture
def picture() -> np.ndarray:
    """A picture with coarse structure and grain."""
    rng = np.random.default_rng(0)
    coarse = np.repeat(np.repeat(rng.uniform(60, 180, (12, 16)), 20, 0), 20, 1)
    return np.clip(coarse + rng.normal(0, 6, coarse.shape), 0, 255).astype(np.uint8)


def test_without_a_quality_pictures_stay_as_they_are(picture):
    assert LossyCodec(None, as_video=True).transcode(picture) is picture


@pytest.mark.parametrize("as_video", [False, True])
def test_worse_quality_leaves_less_of_the_picture(picture, as_video):
    def error(quality: int) -> float:
        recorder = LossyCodec(quality, as_video=as_video)
        last = [recorder.transcode(picture) for _ in range(4)][-1]
        return float(np.abs(last.astype(float) - picture).mean())

    assert 0.0 < error(90) < error(15) < 20.0


def test_a_video_keeps_what_does_not_move_the_same(picture):
    recorder = LossyCodec(30, as_video=True)
    first = recorder.transcode(picture)
    assert np.abs(recorder.transcode(first).astype(int) - first).max() <= 2


def test_light_is_one_on_average_and_uneven_if_asked_for():
    even = random_light(Optics(lamps=(0, 0), vignette=(0, 0)), (64, 48), np.random.default_rng(0))
    uneven = random_light(Optics(lamps=(0.9, 0.9)), (64, 48), np.random.default_rng(0))
    np.testing.assert_allclose(even, 1.0, rtol=1e-5)
    assert uneven.mean() == pytest.approx(1.0, abs=0.05)
    assert uneven.std() > 0.1


def test_lamps_that_do_not_sway_leave_the_light_as_it_is():
    light = random_light(Optics(), (64, 48), np.random.default_rng(0))
    sway = random_sway(Optics(), 1.0, np.random.default_rng(0))
    assert sway.moved(light, 3.0) is light


def test_the_light_sways_to_the_right_and_up_and_back():
    light = np.zeros((48, 64), np.float32)
    light[20, 30] = 1.0
    sway = LampMotion(reach=(6.0, 4.0), rates=(np.pi, np.pi), phases=(0.0, 0.0))
    for seconds, place in ((0.0, (20, 30)), (0.5, (16, 36)), (1.5, (24, 24))):
        moved = sway.moved(light, seconds)
        assert np.unravel_index(moved.argmax(), moved.shape) == place


def test_what_covers_the_picture_is_known():
    rng = np.random.default_rng(3)
    overlay = random_overlay(Disturbance(bars=1.0, vehicle_part=1.0), (320, 240), rng)
    picture = np.full((240, 320), 77, np.uint8)
    overlay.draw_on(picture, 0)
    assert overlay.covered.any()
    assert (picture[~overlay.covered] == 77).all()


def test_captions_change_with_time():
    rng = np.random.default_rng(0)
    overlay = random_overlay(Disturbance(caption=1.0), (320, 240), rng)
    pictures = [np.full((240, 320), 77, np.uint8) for _ in range(2)]
    for frame, picture in zip((0, 30), pictures, strict=True):
        overlay.draw_on(picture, frame)
    assert (pictures[0] != 77).any()
    assert (pictures[0] != pictures[1]).any()


@pytest.mark.parametrize("seed", range(4))
def test_a_crosshair_runs_down_and_across_the_middle_and_is_thin(seed):
    rng = np.random.default_rng(seed)
    covered = random_overlay(Disturbance(crosshair=1.0), (320, 240), rng).covered
    down, across = covered[:, 150:170].any(axis=1), covered[110:130].any(axis=0)
    assert down.sum() > 0.5 * len(down)
    assert across.sum() > 0.5 * len(across)
    assert covered.mean() < 0.02
