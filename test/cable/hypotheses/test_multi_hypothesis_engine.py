from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.multi_hypothesis_engine import (
    SMALLEST_HYPOTHESIS,
    MultiHypothesisEngine,
)
from cable_tracker.cable.hypotheses.proposer import NoProposer
from cable_tracker.cable.measure.response_table import load_table
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.bootstrap_engine import BootstrapEngine
from cable_tracker.tracking.status import StatusMachine

SIZE = (160, 120)
FRAME = 0.04
STRIP = CableState(12.0, 0.2, 24.0, 0.03)
PARAMETERS = TrackerParameters(particle_count=300, border_displacement=0.0)


class Told:
    """Proposes what it was told."""

    def __init__(self, *states: CableState) -> None:
        self.states = np.array([state.to_array()[:4] for state in states])
        self.asked = 0

    def propose(self, image):
        self.asked += 1
        return self.states


def engine(proposer=None, parameters=PARAMETERS) -> MultiHypothesisEngine:
    rng = np.random.default_rng(3)
    return MultiHypothesisEngine(parameters, load_table(""), proposer or NoProposer(), rng)


def cloud(state, count=300) -> np.ndarray:
    sigma = np.array([2.0, 0.03, 2.0, 0.02, 5.0, 0.05, 2.0, 0.02])
    return state.to_array() + np.random.default_rng(0).standard_normal((count, 8)) * sigma


@pytest.fixture
def strip(draw_strip):
    return make_working_image(draw_strip(STRIP, SIZE), 320)


def test_who_is_told_of_a_cable_that_is_there_claims_it_with_the_first_frame(strip):
    finding = engine().start(cloud(STRIP), strip, StatusMachine().expecting())
    assert finding.rises
    assert finding.holds
    assert finding.presence > 0.9
    assert finding.hypotheses[0].state == CableState.from_array(finding.mean)
    np.testing.assert_allclose(finding.mean[[0, 2]], [12.0, 24.0], atol=1.5)


def test_a_flat_picture_neither_rises_nor_holds():
    flat = make_working_image(np.full(SIZE[::-1], 90, np.uint8), 320)
    tracked = engine()
    finding = tracked.start(cloud(STRIP), flat, StatusMachine())
    for _ in range(10):
        finding = tracked.advance(flat, FRAME, StatusMachine())
    assert not finding.rises
    assert not finding.holds
    assert finding.presence < 0.5


def test_the_detector_is_asked_once_a_frame_and_can_be_exchanged(strip):
    first, second = Told(STRIP), Told(STRIP)
    tracked = engine(first)
    tracked.advance(strip, FRAME, StatusMachine())
    tracked.use(second)
    tracked.advance(strip, FRAME, StatusMachine())
    assert (first.asked, second.asked) == (1, 1)


def test_two_strips_are_two_hypotheses_that_are_reported_likeliest_first(draw_strip):
    other = CableState(-45.0, -0.15, 20.0)
    picture = np.maximum(draw_strip(STRIP, SIZE), draw_strip(other, SIZE))
    image = make_working_image(picture, 320)
    tracked = engine(Told(STRIP, other))
    states = np.concatenate((cloud(STRIP, 150), cloud(other, 150)))
    finding = tracked.start(states, image, StatusMachine())
    both = 0
    for _ in range(8):
        shares = [hypothesis.probability for hypothesis in finding.hypotheses]
        assert shares == sorted(shares, reverse=True)
        assert sum(shares) <= 1.0 + 1e-9
        assert min(shares[1:], default=1.0) >= SMALLEST_HYPOTHESIS
        assert min(abs(finding.mean[0] - 12.0), abs(finding.mean[0] + 45.0)) < 3.0
        assert finding.covariance[0, 0] < 9.0  # Of one cluster, not across both.
        places = [hypothesis.state.distance for hypothesis in finding.hypotheses]
        both += min(abs(d - 12) for d in places) < 3 and min(abs(d + 45) for d in places) < 3
        finding = tracked.advance(image, FRAME, StatusMachine())
    assert both >= 6


def test_the_covariance_goes_with_the_estimate_across_the_wrap(draw_strip):
    lying = CableState(10.0, np.pi / 2, 24.0)
    image = make_working_image(draw_strip(lying, SIZE), 320)
    tracked = engine()
    finding = tracked.start(cloud(lying), image, StatusMachine())
    signs = set()
    for _ in range(15):
        assert -np.pi / 2 < finding.mean[1] <= np.pi / 2
        side = np.sign(finding.mean[1])
        signs.add(side)
        assert finding.mean[0] * side == pytest.approx(10.0, abs=1.5)
        np.testing.assert_array_equal(finding.covariance, finding.covariance.T)
        assert np.linalg.eigvalsh(finding.covariance).min() > -1e-9
        assert finding.covariance[0, 0] < 4.0
        finding = tracked.advance(image, FRAME, StatusMachine())
    assert signs <= {-1.0, 1.0}


def test_what_the_likelihood_does_not_know_widens_the_covariance(strip):
    plain = engine().start(cloud(STRIP), strip, StatusMachine())
    wide = engine(parameters=PARAMETERS.replaced({"border_displacement": 4.0})).start(
        cloud(STRIP), strip, StatusMachine()
    )
    added = wide.covariance - plain.covariance
    # Each border is off by 4 px at the reference width, 2 px here: variances 2 and 8.
    np.testing.assert_allclose(np.diag(added)[[0, 2]], [2.0, 8.0])
    np.testing.assert_allclose(added, np.diag(np.diag(added)), atol=1e-12)
    np.testing.assert_array_equal(wide.mean, plain.mean)


def test_the_belief_of_another_filter_is_taken_over_as_one_that_was_told(strip):
    thesis = BootstrapEngine(preset("thesis"), load_table(""), np.random.default_rng(0))
    thesis.start(cloud(STRIP, 500), strip, StatusMachine())
    tracked = engine()
    tracked.take_over(thesis, SIZE)
    assert tracked.particles.count == 300
    assert np.median(tracked.particles.states[:, 0]) == pytest.approx(12.0, abs=2.0)
    finding = tracked.advance(strip, FRAME, StatusMachine())
    assert finding.presence > 0.9
    back = BootstrapEngine(preset("thesis"), load_table(""), np.random.default_rng(0))
    back.take_over(tracked, SIZE)
    assert back.particles.count == preset("thesis").particle_count
    assert back.advance(strip, FRAME, StatusMachine()).mean[0] == pytest.approx(12.0, abs=3.0)


def test_who_takes_over_from_one_that_knows_nothing_knows_nothing(strip):
    tracked = engine()
    tracked.take_over(engine(), SIZE)
    assert tracked.particles is None
    assert tracked.advance(strip, FRAME, StatusMachine()).mean.shape == (8,)


def test_what_is_forgotten_is_gone(strip):
    tracked = engine()
    tracked.start(cloud(STRIP), strip, StatusMachine())
    tracked.forget()
    assert tracked.particles is None
    assert tracked.advance(strip, FRAME, StatusMachine()).presence < 0.5
