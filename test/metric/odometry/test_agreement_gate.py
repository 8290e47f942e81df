import numpy as np
import pytest

from cable_tracker.metric.odometry.agreement_gate import CALM_FRAMES, FEWEST, AgreementGate
from cable_tracker.metric.odometry.motion import CABLE_DISAGREES, NOT_PROVED

UNKNOWN = np.array([0.36, 1e-5])
OBSERVED = np.array([1.0, 1e-4])


def shown(gate, residuals):
    for residual in residuals:
        gate.compare(np.array([residual, 0.0]), UNKNOWN, OBSERVED)
    return gate


@pytest.fixture
def proved() -> AgreementGate:
    """A gate that has seen enough agreement to be open."""
    gate = shown(AgreementGate(), [0.1, -0.1] * (CALM_FRAMES + FEWEST))
    assert gate.doubt is None
    return gate


def test_odometry_has_to_prove_itself():
    gate = AgreementGate()
    assert gate.disagreement() is None
    assert gate.doubt == NOT_PROVED
    shown(gate, [0.1, -0.1] * ((CALM_FRAMES + FEWEST - 2) // 2))
    assert gate.doubt is not None
    assert shown(gate, [0.1, -0.1]).doubt is None


def test_noise_does_not_close_the_gate(proved):
    rng = np.random.default_rng(1)
    for residual in rng.normal(0.0, 0.6, 2000):
        assert shown(proved, [residual]).doubt is None


def test_a_drift_closes_the_gate(proved):
    assert shown(proved, [1.1] * 12).doubt == CABLE_DISAGREES


def test_a_motion_to_and_fro_that_is_missed_closes_the_gate(proved):
    assert shown(proved, [2.0, -2.0] * 6).doubt is not None


def test_a_jump_of_the_filter_does_not_close_the_gate(proved):
    assert shown(proved, [60.0] + [0.1, -0.1] * 10).doubt is None


def test_a_drift_of_the_angle_closes_the_gate_too(proved):
    for _ in range(12):
        proved.compare(np.array([0.0, 0.02]), UNKNOWN, OBSERVED)
    assert proved.doubt is not None


def test_the_gate_opens_again_after_long_agreement(proved):
    shown(proved, [2.5] * 12)
    assert shown(proved, [0.1, -0.1] * (CALM_FRAMES // 2)).doubt is not None
    assert shown(proved, [0.1, -0.1] * CALM_FRAMES).doubt is None


def test_drift_does_not_add_up_across_a_gap(proved):
    proved.interrupt()
    shown(proved, [2.5] * (FEWEST - 1))
    proved.interrupt()
    assert shown(proved, [2.5] * (FEWEST - 1)).doubt is None
