"""The whole tracker by compiled loops: like the NumPy one, repeatable, and compiled at once."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from cable_tracker.cable.model.initialisation import StatePrior
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.simulation.scenario import SimulationSettings, simulate
from cable_tracker.trackers import make_tracker

pytest.importorskip("numba")

KERNELS = ("numpy", "compiled")

ALIKE_FRAMES = 4
"""Later, rounding may have drawn another particle, and from there on the two differ as seeds do."""


@pytest.fixture(scope="module")
def dive():
    settings = SimulationSettings(
        frame_count=25, image_size=(160, 120), clutter=0.1, seed=3, noise=2.0
    )
    return [(decode_grey(each.image), each.stamp, each.truth) for each in simulate(settings)]


def run(kernels, frames, *, told=True, seed=0):
    tracker = make_tracker(TrackerParameters(kernels=kernels, seed=seed))
    if told:
        tracker.initialise(StatePrior.around(frames[0][2]))
    estimates = [tracker.process(image, stamp) for image, stamp, _ in frames]
    return tracker, estimates


def places(estimates) -> np.ndarray:
    return np.array([estimate.state.to_array()[:4] for estimate in estimates])


@pytest.mark.parametrize("seed", range(4))
def test_the_first_estimates_of_a_cable_that_was_told_are_those_of_numpy(dive, seed):
    frames = dive[:ALIKE_FRAMES]
    (_, expected), (_, found) = (run(kernels, frames, seed=seed) for kernels in KERNELS)
    np.testing.assert_allclose(places(found), places(expected), atol=1e-4)
    for one, other in zip(found, expected, strict=True):
        assert one.status is other.status
        np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-3, atol=1e-4)
        assert one.presence == pytest.approx(other.presence, abs=1e-4)
        assert one.evidence == pytest.approx(other.evidence, abs=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_from_nothing_both_find_the_same(dive, seed):
    (_, expected), (_, found) = (
        run(kernels, dive[:10], told=False, seed=seed) for kernels in KERNELS
    )
    np.testing.assert_allclose(places(found), places(expected), atol=0.5)
    assert [each.status for each in found] == [each.status for each in expected]


def test_over_a_whole_dive_both_follow_the_cable(dive):
    for kernels in KERNELS:
        _, estimates = run(kernels, dive)
        for estimate, (_, _, truth) in zip(estimates[5:], dive[5:], strict=True):
            assert abs(estimate.state.distance - truth.distance) < 3.0
            assert abs(estimate.state.width - truth.width) < 4.0


def test_the_same_seed_gives_the_same_particles_bit_for_bit(dive):
    def record(seed):
        tracker, estimates = run("compiled", dive, told=False, seed=seed)
        numbers = [(each.state, each.covariance.tobytes(), each.presence) for each in estimates]
        return numbers, tracker.particles.states.tobytes()

    assert record(5) == record(5)
    assert record(5) != record(6)


COUNT_WHAT_IS_COMPILED = """
import sys
import numpy as np
from cable_tracker.cable.model.initialisation import StatePrior
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.model.state import CableState
from cable_tracker.trackers import make_tracker
from cable_tracker.trackers import warm_up


def compiled():
    return {
        (name, function, len(value.signatures))
        for name, module in list(sys.modules.items())
        if name.startswith("cable_tracker")
        for function, value in vars(module).items()
        if hasattr(value, "signatures")
    }


parameters = TrackerParameters(kernels="compiled")
warm_up(parameters)
before = compiled()
assert sum(count for *_, count in before) > 20

rng = np.random.default_rng(0)
pictures = {}
for dtype in (np.uint8, np.float32):
    pictures[f"{dtype.__name__}"] = rng.uniform(0, 255, (120, 160)).astype(dtype)
    pictures[f"{dtype.__name__}, read-only"] = rng.uniform(0, 255, (120, 160)).astype(dtype)
    pictures[f"{dtype.__name__}, read-only"].setflags(write=False)
    pictures[f"{dtype.__name__}, every other pixel"] = (
        rng.uniform(0, 255, (240, 320)).astype(dtype)[::2, ::2]
    )
    pictures[f"{dtype.__name__}, by columns"] = np.asfortranarray(
        rng.uniform(0, 255, (120, 160)).astype(dtype)
    )
    pictures[f"{dtype.__name__}, wide"] = rng.uniform(0, 255, (480, 640)).astype(dtype)
    pictures[f"{dtype.__name__}, small"] = rng.uniform(0, 255, (16, 16)).astype(dtype)
    pictures[f"{dtype.__name__}, flat"] = np.full((120, 160), 90, dtype)
    strip = np.full((120, 160), 60, dtype)
    strip[:, 70:94] = 160
    pictures[f"{dtype.__name__}, with a cable"] = strip

for name, picture in pictures.items():
    for told in (False, True):
        tracker = make_tracker(parameters)
        if told:
            tracker.initialise(StatePrior.around(CableState(2.0, 0.0, 24.0, 0.0)))
        for number in range(1, 12):
            tracker.process(picture, stamp=number * 40_000_000)
        new = compiled() - before
        assert not new, f"{name}, told={told}: {sorted(new)}"
"""


def test_after_the_warm_up_no_frame_has_anything_compiled():
    done = subprocess.run(
        [sys.executable, "-c", COUNT_WHAT_IS_COMPILED], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
