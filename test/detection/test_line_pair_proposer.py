from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.line_pair_proposer import (
    MOST_CABLES,
    MOST_SKEW,
    STRONG,
    VOTE_CAP,
    LinePairProposer,
    strong_gradients,
)

CABLES = [
    CableState(12.0, 0.2, 24.0, 0.03),
    CableState(-30.0, -0.6, 16.0),
    CableState(10.0, np.pi / 2, 30.0),
    CableState(-10.0, -np.pi / 2 + 0.03, 30.0),
    CableState(0.0, 0.8, 40.0, -0.06),
]


def propose(image, working_width=320) -> np.ndarray:
    return LinePairProposer().propose(make_working_image(image, working_width))


def nearest(proposals, truth) -> np.ndarray:
    """The proposal with the nearest d, in the chart of the truth, shape (4,)."""
    states = np.zeros((len(proposals), 8))
    states[:, :4] = proposals
    chart = unwrap_states(states, truth.angle)[:, :4]
    return chart[np.argmin(np.abs(chart - truth.to_array()[:4]) @ [1.0, 60.0, 1.0, 60.0])]


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("cable", CABLES, ids=str)
def test_a_cable_in_the_picture_is_proposed(draw_strip, rng, cable, dark):
    strip, ground = (80.0, 160.0) if dark else (160.0, 80.0)
    picture = draw_strip(cable, (160, 120), strip=strip, ground=ground).astype(np.float32)
    picture += rng.normal(0.0, 5.0, picture.shape).astype(np.float32)
    found = nearest(propose(picture), cable)
    assert found[0] == pytest.approx(cable.distance, abs=4.0)
    assert found[1] == pytest.approx(cable.angle, abs=0.07)
    assert found[2] == pytest.approx(cable.width, abs=5.0)
    assert found[3] == pytest.approx(cable.skew, abs=0.07)


def test_two_cables_are_both_proposed(draw_strip):
    pictures = [draw_strip(cable, (320, 240)) for cable in (CABLES[0], CABLES[1])]
    proposals = propose(np.maximum(*pictures))
    for cable in CABLES[:2]:
        assert abs(nearest(proposals, cable)[0] - cable.distance) < 5.0


def test_lengths_are_those_of_the_frame_not_of_the_reduced_picture(draw_strip):
    large = CableState(48.0, 0.2, 96.0, 0.03)
    found = nearest(propose(draw_strip(large, (640, 480)), 160), large)
    assert found[0] == pytest.approx(48.0, abs=12.0)
    assert found[2] == pytest.approx(96.0, abs=20.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [(16, 16), (16, 200), (300, 16), (160, 120)])
@pytest.mark.parametrize("kind", ["black", "white", "noise", "one edge"])
def test_whatever_the_picture_proposals_are_plausible_cables(rng, size, kind):
    width, height = size
    pictures = {
        "black": np.zeros((height, width)),
        "white": np.full((height, width), 255.0),
        "noise": rng.uniform(0, 255, (height, width)),
        "one edge": np.where(np.arange(width) < width // 2, 0.0, 255.0) * np.ones((height, 1)),
    }
    proposals = propose(pictures[kind].astype(np.uint8))
    assert proposals.shape[1:] == (4,)
    assert len(proposals) <= MOST_CABLES
    assert np.isfinite(proposals).all()
    assert (proposals[:, 2] > 0.0).all()
    assert (np.abs(proposals[:, 3]) <= MOST_SKEW).all()
    assert ((proposals[:, 1] > -np.pi / 2) & (proposals[:, 1] <= np.pi / 2)).all()
    if kind in ("black", "white"):
        assert len(proposals) == 0


def test_only_the_strongest_gradients_vote(rng):
    # Short scratches everywhere on a quiet bottom.
    picture = rng.normal(100.0, 1.0, (240, 320))
    picture[:, ::9] += 60.0 * (rng.random((240, 36)) < 0.5)
    voters = strong_gradients(make_working_image(picture.astype(np.float32), 320))
    assert len(voters.weights) > 50
    assert (voters.weights > STRONG).all()
    assert (voters.weights <= VOTE_CAP).all()
    assert np.abs(voters.x).max() <= 160.0
    assert np.abs(voters.y).max() <= 120.0


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, -1.2])
def test_every_scan_line_votes_once_for_each_border_it_crosses(draw_strip, angle):
    cable = CableState(5.0, angle, 40.0)
    image = make_working_image(draw_strip(cable, (320, 240)), 320)
    voters = strong_gradients(image)
    inward = np.array([angle, angle + np.pi])
    across = voters.x[:, None] * np.cos(inward) + voters.y[:, None] * np.sin(inward)
    turn = np.abs(np.angle(np.exp(1j * (voters.directions[:, None] - inward))))
    steep = abs(np.cos(angle)) >= abs(np.sin(angle))
    lines = image.scanned.rows if steep else image.scanned.columns
    for side, offset in enumerate((5.0 - 20.0, -5.0 - 20.0)):
        near = (np.abs(across[:, side] - offset) < 1.5) & (turn[:, side] < 0.1)
        crossing = np.abs(offset / abs(np.cos(angle) if steep else np.sin(angle))) < 300.0
        assert crossing
        assert 0.6 * len(lines.places) <= near.sum() <= len(lines.places)
