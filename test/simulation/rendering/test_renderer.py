import dataclasses

import cv2
import numpy as np
import pytest

from cable_tracker.benchmark.cases import sample_points
from cable_tracker.cable.model.geometry import project_borders
from cable_tracker.cable.model.state import CableState
from cable_tracker.simulation.borders import project_tube, steer
from cable_tracker.simulation.rendering.appearance import Bottom, SceneAppearance, Skin, Water
from cable_tracker.simulation.rendering.camera import Camera
from cable_tracker.simulation.rendering.laid_cable import BuriedStretch, LaidCable, Tube
from cable_tracker.simulation.rendering.renderer import Scene, SceneRenderer
from cable_tracker.simulation.rendering.seabed import make_bed, make_cable
from cable_tracker.tracking.image_frame import image_to_pixel

SIZE = (320, 240)
CLEAR = Water(absorption=0.02, scatter=0.02, blur=0.6, flakes=0.0)
CLEAN = SceneAppearance(
    bottom=Bottom(stones=0.3, algae=0.3),
    skin=Skin(tone=0.7, stains=0.2, cover=0.0),
    water=CLEAR,
    lamps=(),
    daylight=1.0,
    clutter=0.0,
    noise=0.0,
)
TUBE = Tube(0.08)


def _scene(appearance, stretches=(), others=()):
    rng = np.random.default_rng(3)
    cable = LaidCable(TUBE, make_cable(16, appearance.skin, rng), stretches)
    upper = tuple(LaidCable(tube, make_cable(8, Skin(cover=0.0), rng)) for tube in others)
    return Scene(make_bed(16, appearance.bottom, rng), (cable, *upper), (), 0.08)


@pytest.fixture(scope="module")
def clean_scene():
    return _scene(CLEAN)


def _renderer(scene, appearance=CLEAN, camera=None):
    camera = camera or Camera(SIZE, 280.0 * SIZE[0] / 320)
    return SceneRenderer(camera, scene, appearance, np.random.default_rng(0))


def _poses(camera, state):
    return steer(TUBE, camera, state.to_array()[None], np.array([0.03]), np.array([1.7]))


def _picture(scene, state, appearance=CLEAN, camera=None):
    camera = camera or Camera(SIZE, 280.0)
    poses = _poses(camera, state)
    return _renderer(scene, appearance, camera).render(poses.positions[0], poses.rotations[0], 0.0)


def _edge_offsets(image, state, size):
    """Return where along each normal the grey value changes most, relative to the border [px]."""
    offsets = np.arange(-5.0, 5.01, 0.25)
    borders = project_borders(state.to_array()[None, :])
    points, inside = sample_points(borders, 8.0, size)
    found = []
    for side, sign in ((0, 1.0), (1, -1.0)):
        normal = np.array([np.cos(borders.angles[0, side]), np.sin(borders.angles[0, side])])
        along = points[0, side][inside[0, side]]
        places = image_to_pixel(along[:, None, :] + offsets[None, :, None] * normal, size)
        margin = (places >= 0).all(axis=(1, 2)) & (places <= np.array(size) - 1).all(axis=(1, 2))
        maps = places[margin].astype(np.float32)
        profile = cv2.remap(image.astype(np.float32), maps[..., 0], maps[..., 1], cv2.INTER_LINEAR)
        slope = sign * np.gradient(cv2.blur(profile, (5, 1)), axis=1)
        found.append(offsets[np.argmax(slope, axis=1)])
    return np.concatenate(found)


STATES = [
    CableState(0.0, 0.0, 36.0, 0.0),
    CableState(30.3, 0.3, 30.0, 0.05),
    CableState(-60.0, -0.4, 46.0, 0.08),
    CableState(12.0, 1.2, 40.0, 0.03),
    CableState(-20.0, 0.1, 36.0, -0.05),
]


@pytest.mark.parametrize("state", STATES, ids=["down", "pitched", "steep", "across", "backwards"])
def test_the_sharpest_edges_lie_on_the_true_borders(clean_scene, state):
    offsets = _edge_offsets(_picture(clean_scene, state), state, SIZE)
    assert offsets.size > 20
    assert np.mean(np.abs(offsets) <= 1.0) > 0.97
    assert abs(np.mean(offsets[np.abs(offsets) <= 1.0])) < 0.3


@pytest.mark.parametrize("size", [(640, 480), (161, 97)])
def test_edges_are_exact_in_other_sizes(clean_scene, size):
    scale = size[0] / 320
    state = CableState(-20.0 * scale, 0.2, 40.0 * scale, 0.04)
    image = _picture(clean_scene, state, camera=Camera(size, 280.0 * scale, 0.3))
    assert np.mean(np.abs(_edge_offsets(image, state, size)) <= max(1.0, scale)) > 0.95


def test_a_wrong_state_is_noticed_by_the_edge_test(clean_scene):
    offsets = _edge_offsets(_picture(clean_scene, STATES[0]), CableState(3.0, 0.0, 36.0), SIZE)
    assert np.mean(np.abs(offsets) <= 1.0) < 0.1


def test_bottom_and_cable_move_with_the_vehicle(clean_scene):
    """From 1.4 m above the bottom, 0.25 m further on it is 0.25 / 1.4 * 280 px = 50 px lower."""
    renderer = _renderer(clean_scene)
    first = np.array((0.4, 0.0, 1.4))
    before = renderer.render(first, np.eye(3), 0.0).astype(float)
    after = renderer.render(first + np.array((0.0, 0.25, 0.0)), np.eye(3), 0.0).astype(float)
    same = np.corrcoef(after[110:210, 150:300].ravel(), before[60:160, 150:300].ravel())[0, 1]
    assert same > 0.9


def test_noise_has_the_strength_asked_for(clean_scene):
    noisy = dataclasses.replace(CLEAN, noise=6.0)
    difference = _picture(clean_scene, STATES[0], noisy).astype(float) - _picture(
        clean_scene, STATES[0]
    )
    assert np.std(difference) == pytest.approx(6.0, rel=0.05)


def test_jpeg_compression_leaves_its_traces(clean_scene):
    poor = _picture(clean_scene, STATES[0], dataclasses.replace(CLEAN, jpeg_quality=10))
    rich = _picture(clean_scene, STATES[0], dataclasses.replace(CLEAN, jpeg_quality=95))
    clean = _picture(clean_scene, STATES[0]).astype(float)
    assert np.abs(poor - clean).mean() > 2 * np.abs(rich - clean).mean() > 0


def test_turbid_water_takes_contrast_away_with_distance(clean_scene):
    turbid = dataclasses.replace(CLEAN, water=Water(absorption=0.2, scatter=0.8, flakes=0.0))
    near, far = (
        _picture(clean_scene, CableState(0.0, 0.0, width), turbid)[60:180].std()
        / _picture(clean_scene, CableState(0.0, 0.0, width))[60:180].std()
        for width in (60.0, 20.0)
    )
    assert far < 0.8 * near < 0.8


def test_flakes_are_bright_spots(clean_scene):
    snowy = dataclasses.replace(CLEAN, water=dataclasses.replace(CLEAR, flakes=1.0))
    added = _picture(clean_scene, STATES[0], snowy).astype(int) - _picture(clean_scene, STATES[0])
    assert (added > 10).sum() > 20
    assert np.mean(added > 10) < 0.05


@pytest.mark.parametrize("pitch", [0.2, 0.9, 1.3])
def test_a_horizon_inside_the_image_is_survived(clean_scene, pitch):
    camera = Camera(SIZE, 280.0)
    poses = camera.poses(np.array([[0.0, 0, 0.8]]), np.array([[0.05, -pitch, 0.1]]))
    image = _renderer(clean_scene).render(poses.positions[0], poses.rotations[0], 0.0)
    assert image.shape == (240, 320)
    assert image.dtype == np.uint8
    assert image.max() > image.min()


def _visible(scene, camera=None):
    camera = camera or Camera(SIZE, 280.0)
    poses = _poses(camera, STATES[0])
    projected = project_tube(TUBE, camera, poses)
    hidden = _renderer(scene).hidden(
        scene.cables[0], poses.positions[0], projected.world[0], projected.inside[0]
    )
    return ~hidden[projected.inside[0]]


def test_a_clean_cable_is_visible_all_over(clean_scene):
    assert _visible(clean_scene).all()


def test_a_buried_cable_is_not_visible_and_leaves_no_trace(clean_scene):
    scene = _scene(CLEAN, (BuriedStretch(-10.0, 10.0, 0.1),))
    assert not _visible(scene).any()
    bare = dataclasses.replace(scene, cables=())
    difference = _picture(scene, STATES[0]).astype(int) - _picture(bare, STATES[0])
    assert np.abs(difference).max() <= 1


def test_a_cable_on_top_hides_part_of_the_lower_one():
    visible = _visible(_scene(CLEAN, others=(Tube(0.08, (), (0.0, 1.7), 0.8),)))
    assert 0.7 < visible.mean() < 0.95


def _with_skin(**changes):
    return _scene(dataclasses.replace(CLEAN, skin=dataclasses.replace(CLEAN.skin, **changes)))


def test_turf_and_drifts_take_from_what_is_visible():
    turf, drift = _visible(_with_skin(turf=0.4)), _visible(_with_skin(drift=0.9))
    assert 0.2 < turf.mean() < 0.9
    assert 0.3 < drift.mean() < 0.95


def test_silt_takes_contrast_but_nothing_that_is_visible(clean_scene):
    dusty = _with_skin(silt=0.4)
    assert _visible(dusty).all()
    assert _contrast(dusty) < 0.8 * _contrast(clean_scene)


def _contrast(scene):
    """Return how much brighter the middle of the cable is than the bottom [grey levels]."""
    image = _picture(scene, STATES[0]).astype(float)
    x, y = np.meshgrid(np.arange(SIZE[0]) - 159.5, 119.5 - np.arange(SIZE[1]))
    state = STATES[0]
    away = np.abs(x * np.cos(state.angle) + y * np.sin(state.angle) - state.distance)
    bottom = image[(away > state.width) & (away < 2 * state.width)].mean()
    return image[away < 0.3 * state.width].mean() - bottom


def test_turf_looks_like_the_bottom():
    turf = _with_skin(turf=1.0)
    assert abs(_contrast(turf)) < 0.25 * _contrast(_with_skin())


def test_crusts_displace_the_edges_that_are_seen(clean_scene):
    spread = [
        np.std(_edge_offsets(_picture(scene, STATES[0]), STATES[0], SIZE))
        for scene in (clean_scene, _with_skin(bulge=0.15))
    ]
    assert spread[1] > spread[0] + 0.5


def test_without_shadows_the_bottom_beside_the_cable_is_brighter(clean_scene):
    cable = dataclasses.replace(clean_scene.cables[0], shade=0.0)
    pale = dataclasses.replace(clean_scene, cables=(cable,))
    brighter = _picture(pale, STATES[0]).astype(int) - _picture(clean_scene, STATES[0])
    # The exposure answers with a little less gain everywhere.
    assert brighter.max() > 10
    assert brighter.min() > -5
