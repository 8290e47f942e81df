import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cable_tracker.cable.compiled.evidence import border_evidence, median


@given(arrays(np.float32, st.integers(1, 500), elements=st.floats(0.0, 255.0, width=32)))
def test_the_same_median_as_numpy(values):
    expected = np.median(values.astype(np.float64))
    assert median(values.copy()) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("scores", "counts", "evidence"),
    [
        ((30.0, -20.0), (10.0, 10.0), 2.0 / 1.4826),
        ((30.0, 20.0), (10.0, 10.0), 0.0),
        ((30.0, -1e-4), (10.0, 10.0), 0.0),
        ((30.0, -20.0), (10.0, 2.9), 0.0),
    ],
)
def test_the_weaker_border_decides(scores, counts, evidence):
    scattered = np.ones(5, np.float32)
    found = border_evidence(np.array(scores), np.array(counts), scattered)
    assert found == pytest.approx(evidence)
