from itertools import pairwise

import numpy as np
import pytest

from cable_tracker.benchmark.footage import FRAME_STEP
from cable_tracker.benchmark.library_filters import LIBRARY_LOOPS, LibraryMethod, is_installed
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.stamps import FIRST_STAMP

pytestmark = pytest.mark.slow


@pytest.fixture(params=LIBRARY_LOOPS)
def library(request):
    if not is_installed(request.param):
        pytest.skip(f"{request.param} IS MISSING: pip install {request.param}")
    return request.param


def followed(library, shown, seed=0):
    method = LibraryMethod(library, 500, seed)
    method.initialise(GivenState.around(shown.truths[0]))
    return [
        method.process(image, FIRST_STAMP + number * FRAME_STEP)
        for number, image in enumerate(shown.images)
    ]


def test_it_follows_the_cable_so_that_the_comparison_is_fair(library, shown):
    estimates = followed(library, shown)
    errors = np.array(
        [
            (e.state.distance - truth.distance, e.state.angle - truth.angle)
            for e, truth in zip(estimates, shown.truths, strict=True)
        ]
    )
    assert len(errors) == 30
    assert np.abs(errors[:, 0]).max() < 8.0
    assert np.median(np.abs(errors[:, 0])) < 3.0
    assert np.rad2deg(np.abs(errors[:, 1])).max() < 8.0
    assert all(1.0 <= e.effective_sample_size <= 500.0 for e in estimates)


def test_it_resamples(library, shown):
    sizes = [e.effective_sample_size for e in followed(library, shown)]
    grown = [after > before for before, after in pairwise(sizes)]
    assert any(grown)


def test_the_same_seed_gives_the_same_estimates_whatever_the_global_state(library, shown):
    first = [e.state for e in followed(library, shown)]
    np.random.random(5)  # noqa: NPY002
    assert [e.state for e in followed(library, shown)] == first
    assert [e.state for e in followed(library, shown, seed=1)] != first


def test_the_global_state_is_as_it_was(library, shown):
    before = np.random.get_state()  # noqa: NPY002
    followed(library, shown)
    after = np.random.get_state()  # noqa: NPY002
    assert before[2] == after[2]
    assert (before[1] == after[1]).all()


def test_without_a_start_it_searches(library, shown):
    estimate = LibraryMethod(library, 50).process(shown.images[0], FIRST_STAMP)
    assert isinstance(estimate.state, CableState)
    assert estimate.state.is_finite()


def test_what_is_not_there_is_not_installed():
    assert not is_installed("no_such_package_anywhere")
