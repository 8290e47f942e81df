import math
from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.simulation.targets.chase import (
    DIAMETER,
    FIRST_DISTANCE,
    ChaseSettings,
    ChaseWorld,
    target_size,
)
from cable_tracker.simulation.vehicle import VelocityCommand


def test_the_target_begins_before_the_camera_at_its_size():
    world = ChaseWorld(ChaseSettings(seed=1))
    view = world.view(world.state())
    assert view.image.shape == (240, 320, 3)
    assert np.linalg.norm(view.place) == pytest.approx(FIRST_DISTANCE, abs=0.2)
    area = world.camera.focal * target_size() / np.linalg.norm(view.place)
    assert math.sqrt(view.mask.sum()) == pytest.approx(area, rel=0.05)
    assert 0.8 * DIAMETER < target_size() < 1.1 * DIAMETER


def test_the_picture_shows_the_target_where_its_place_says():
    world = ChaseWorld(ChaseSettings(seed=2))
    for _ in range(25):
        world.advance(VelocityCommand(turn=0.1), world.settings.altitude, 0.08)
    view = world.view(world.state())
    rows, columns = np.nonzero(view.mask)
    ahead, left, up = view.place
    assert columns.mean() == pytest.approx(159.5 - world.camera.focal * left / ahead, abs=2.0)
    assert rows.mean() == pytest.approx(119.5 - world.camera.focal * up / ahead, abs=4.0)


def test_where_the_bow_goes_down_target_and_background_go_up_alike():
    world = ChaseWorld(ChaseSettings(seed=2))
    state, pitch = world.state(), math.radians(5.0)
    level, lowered = (
        world.view(replace(state, angles=np.array([0.0, angle, 0.0]))) for angle in (0.0, pitch)
    )
    rise = world.camera.focal * math.tan(pitch)
    rows = [np.nonzero(view.mask)[0].mean() for view in (level, lowered)]
    assert rows[0] - rows[1] == pytest.approx(rise, abs=2.0)
    # The rows' mean brightness, of the left third, which does not show the target.
    before, after = (view.image[:, :100].mean(axis=(1, 2)) for view in (level, lowered))
    shifts = range(-40, 41)
    unlike = [(np.roll(before, -shift) - after)[45:-45].std() for shift in shifts]
    assert shifts[int(np.argmin(unlike))] == pytest.approx(rise, abs=3.0)


def test_the_same_seed_gives_the_same_pictures():
    one, two = (ChaseWorld(ChaseSettings(seed=5)) for _ in range(2))
    for world in (one, two):
        world.advance(VelocityCommand(0.3), 5.0, 0.08)
    assert np.array_equal(one.view(one.state()).image, two.view(two.state()).image)


def test_silt_hides_the_target_for_a_while():
    world = ChaseWorld(ChaseSettings(hidden_every=5.0, hidden_for=1.0))
    seen = []
    for _ in range(90):
        seen.append(world.view(world.state()).mask.any())
        place = world.place(world.state())
        turn = math.atan2(place[1], place[0])
        world.advance(VelocityCommand(0.3, turn=turn), world.settings.altitude, 0.08)
    hidden = [number for number, visible in enumerate(seen) if not visible]
    assert hidden[0] == pytest.approx(5.0 / 0.08, abs=2)
    assert len(hidden) == pytest.approx(1.0 / 0.08, abs=2)
    assert seen[-1]


def test_one_may_look_all_round_without_a_seam():
    world = ChaseWorld(ChaseSettings(seed=3))
    panorama = world._background.panorama
    steps = np.abs(np.diff(panorama.mean(axis=0).mean(axis=1)))
    assert steps.max() < 12.0 * np.median(steps) + 3.0


@pytest.mark.parametrize("width", [320, 640])
def test_after_a_whole_turn_the_camera_sees_the_same(width):
    world = ChaseWorld(ChaseSettings(image_width=width, image_height=60))
    background, around = world._background, world._around
    first = background.panorama[:, background.margin :][:, :width]
    again = background.panorama[:, background.margin + around :][:, :width]
    assert np.array_equal(first, again)
