import cv2
import numpy as np
import pytest

from cable_tracker.cable.geometry import image_to_pixel, project_borders, sample_points
from cable_tracker.cable.state import CableState
from cable_tracker.simulation.renderer import SeabedRenderer

SIZE = (320, 240)


def _clean(size=SIZE, seed=0):
    return SeabedRenderer(size, 0.0, 0.0, (), np.random.default_rng(seed))


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


@pytest.fixture(scope="module")
def clean():
    return _clean()


@pytest.mark.parametrize(
    "state",
    [
        CableState(0.0, 0.0, 36.0, 0.0),
        CableState(30.3, 0.3, 30.0, 0.05),
        CableState(-60.0, -0.4, 46.0, 0.08),
        CableState(12.0, 1.4, 40.0, 0.03),
        CableState(-20.0, 0.1, 36.0, -0.05),
    ],
)
def test_the_sharpest_edges_lie_on_the_true_borders(clean, state):
    offsets = _edge_offsets(clean.render(state, 17.0), state, SIZE)
    assert offsets.size > 20
    assert np.mean(np.abs(offsets) <= 1.0) > 0.97
    assert abs(np.mean(offsets[np.abs(offsets) <= 1.0])) < 0.3


@pytest.mark.parametrize("size", [(640, 480), (161, 97)])
def test_edges_are_exact_in_other_sizes(size):
    scale = size[0] / 320
    state = CableState(-20.0 * scale, 0.2, 40.0 * scale, 0.04)
    offsets = _edge_offsets(_clean(size).render(state, 5.0), state, size)
    assert np.mean(np.abs(offsets) <= max(1.0, scale)) > 0.95


def test_a_wrong_state_is_noticed_by_the_edge_test(clean):
    image = clean.render(CableState(0.0, 0.0, 36.0), 0.0)
    offsets = _edge_offsets(image, CableState(3.0, 0.0, 36.0), SIZE)
    assert np.mean(np.abs(offsets) <= 1.0) < 0.1


def test_bottom_and_cable_move_together(clean):
    """At a width of 40 px one radius is 20 px: 2 radii further on, the picture is 40 px lower."""
    state = CableState(0.0, 0.0, 40.0)
    lamps = clean._lamps
    before = clean.render(state, 10.0) / lamps
    after = clean.render(state, 12.0) / lamps
    shifted, old = after[100:200], before[60:160]
    for columns in (slice(40, 110), slice(145, 175), slice(210, 280)):
        same = np.corrcoef(shifted[:, columns].ravel(), old[:, columns].ravel())[0, 1]
        assert same > 0.9


def test_sway_moves_the_bottom_with_the_cable(clean):
    lamps = clean._lamps
    left = clean.render(CableState(-20.0, 0.0, 40.0), 0.0) / lamps
    right = clean.render(CableState(20.0, 0.0, 40.0), 0.0) / lamps
    assert np.corrcoef(right[:, 60:120].ravel(), left[:, 20:80].ravel())[0, 1] > 0.9


def test_noise_has_the_strength_asked_for():
    state = CableState(0.0, 0.1, 36.0)
    clean = _clean().render(state, 0.0)
    noisy = SeabedRenderer(SIZE, 0.0, 6.0, (), np.random.default_rng(0)).render(state, 0.0)
    assert np.std(noisy.astype(float) - clean) == pytest.approx(6.0, rel=0.05)


def test_clutter_takes_contrast_away():
    state = CableState(0.0, 0.1, 36.0)
    spread = [
        SeabedRenderer(SIZE, clutter, 0.0, (), np.random.default_rng(0)).render(state, 0.0).std()
        for clutter in (0.0, 0.5, 1.0)
    ]
    assert spread[0] > spread[1] > spread[2] > 5.0


@pytest.mark.parametrize("skew", [0.3, -0.3])
def test_a_horizon_inside_the_image_is_survived(clean, skew):
    image = clean.render(CableState(0.0, 0.0, 30.0, skew), 0.0)
    assert image.shape == (240, 320)
    assert image.dtype == np.uint8
