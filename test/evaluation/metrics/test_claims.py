import pytest

from cable_tracker.evaluation.metrics.claims import claim_statistics
from cable_tracker.evaluation.metrics.losses import loss_statistics


def test_claims_by_hand(trace):
    claims = claim_statistics(trace("hhlsxffnu"))
    assert claims.silence == pytest.approx(2 / 5)
    assert claims.wrong_claims == pytest.approx(1 / 3)
    assert claims.false_tracking == pytest.approx(2 / 3)
    assert claims.useful == pytest.approx(2 / 5)


@pytest.mark.parametrize("letters", ["hlsx", "h", "sx", "lll", "hhlss"])
def test_silence_wrong_claims_and_useful_frames_are_all_there_is(trace, letters):
    claims = claim_statistics(trace(letters))
    wrong = 0.0 if claims.silence == 1.0 else claims.wrong_claims * (1.0 - claims.silence)
    assert claims.useful + claims.silence + wrong == pytest.approx(1.0)
    assert loss_statistics(trace(letters)).share == pytest.approx(1.0 - claims.useful)
