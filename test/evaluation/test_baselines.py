from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.line_pairs import Detection
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.errors import FrameError
from cable_tracker.evaluation.baselines import (
    MISSES_TO_LOSE,
    CableKalmanFilter,
    DetectorTracker,
    KalmanNoise,
)
from cable_tracker.tracking.status import TrackingStatus

NOTHING = (0.0, 0.0, 0.0, 0.0)
UNIT = (1.0, 1.0, 1.0, 1.0)
DEGREE = np.pi / 180

pytestmark = pytest.mark.slow

FRAME = np.zeros((240, 320), np.uint8)
NOISE = KalmanNoise((1.0, 0.5, 2.0, 0.5))
CABLE = CableState(10.0, 0.1, 30.0, 0.02)
NEAR = CableState(11.0, 0.11, 31.0, 0.02)
FAR = CableState(-90.0, 0.6, 20.0)
SEEK, HAVE, GONE = TrackingStatus.INITIALISING, TrackingStatus.TRACKING, TrackingStatus.LOST


def noise(measurement=UNIT, diffusion=NOTHING, rate=NOTHING, initial=NOTHING) -> KalmanNoise:
    return KalmanNoise(measurement, diffusion, rate, initial)


def start(state: CableState, width=320, **kinds) -> CableKalmanFilter:
    return CableKalmanFilter.start(state, noise(**kinds), width)


def test_the_start_is_the_measurement_with_its_noise():
    belief = start(CableState(5.0, 0.1, 30.0, 0.02, 99.0, 9.0), initial=(2, 1, 0, 0))
    np.testing.assert_allclose(belief.mean, [5.0, 0.1, 30.0, 0.02, 0, 0, 0, 0])
    # A rate per frame at 25 frames per second is 25 times as large per second.
    expected = [1, DEGREE**2, 1, DEGREE**2, 50.0**2, (25 * DEGREE) ** 2, 0, 0]
    np.testing.assert_allclose(belief.covariance, np.diag(expected))


def test_two_equal_measurements_halve_the_variance():
    belief = start(CableState(10.0, 0.0, 30.0)).updated(CableState(14.0, 0.0, 30.0))
    assert belief.state.distance == pytest.approx(12.0)
    assert belief.covariance[0, 0] == pytest.approx(0.5)


def test_a_prediction_and_an_update_by_hand():
    # d: variance 1, rate variance 25^2 = 625 per s^2; after 0.04 s the variance is 1 + 625 * 0.0016
    # = 2, and the covariance with the rate is 625 * 0.04 = 25.
    belief = start(CableState(10.0, 0.0, 30.0), initial=(1, 0, 0, 0)).predicted(0.04)
    assert belief.covariance[0, 0] == pytest.approx(2.0)
    assert belief.covariance[0, 4] == pytest.approx(25.0)
    # Gain 2 / 3 on d and 25 / 3 per s on its rate; the innovation is 3 px.
    updated = belief.updated(CableState(13.0, 0.0, 30.0))
    assert updated.mean[0] == pytest.approx(12.0)
    assert updated.mean[4] == pytest.approx(25.0)
    assert updated.covariance[0, 0] == pytest.approx(2 / 3)
    assert updated.covariance[4, 4] == pytest.approx(625 - 25 * 25 / 3)


def test_process_noise_by_hand():
    belief = start(CableState(0.0, 0.0, 30.0), diffusion=(2, 0, 0, 0), rate=(1, 0, 0, 0)).predicted(
        0.08
    )
    # Two frames: 2 * 2^2 by itself; the rate's q = 25^3 per s: q t^3 / 3, q t^2 / 2, q t.
    q = 25.0**3
    assert belief.covariance[0, 0] == pytest.approx(1 + 8 + q * 0.08**3 / 3)
    assert belief.covariance[0, 4] == pytest.approx(q * 0.08**2 / 2)
    assert belief.covariance[4, 4] == pytest.approx(q * 0.08)


def test_two_short_predictions_are_one_long_one():
    belief = start(
        CableState(1.0, 0.2, 30.0, 0.01),
        diffusion=(1, 0.3, 1, 0.2),
        rate=(0.5, 0.1, 0.2, 0.1),
        initial=UNIT,
    ).updated(CableState(3.0, 0.25, 28.0, 0.02))
    once, twice = belief.predicted(0.1), belief.predicted(0.03).predicted(0.07)
    np.testing.assert_allclose(once.mean, twice.mean)
    np.testing.assert_allclose(once.covariance, twice.covariance)


def test_a_steady_motion_is_learnt_whatever_the_intervals():
    rng = np.random.default_rng(7)
    belief = start(CableState(0.0, 0.0, 30.0), initial=(5, 1, 1, 1))
    time = 0.0
    for dt in rng.uniform(0.02, 0.08, 60):
        time += dt
        belief = belief.predicted(dt).updated(CableState(40.0 * time, 0.3 * time, 30.0))
    assert belief.state.distance_rate == pytest.approx(40.0, rel=0.01)
    assert belief.state.angle_rate == pytest.approx(0.3, rel=0.01)


def test_a_measurement_across_the_wrap_is_near():
    belief = start(CableState(30.0, 89 * DEGREE, 40.0, 0.05))
    across = CableState(-31.0, -89.5 * DEGREE, 40.0, -0.05)
    # 1 px and 1.5 deg away, each variance 2.
    assert belief.squared_distance(across) == pytest.approx((1.0 + 1.5**2) / 2)
    updated = belief.updated(across).state
    assert updated.distance == pytest.approx(30.5)
    assert updated.angle == pytest.approx(89.75 * DEGREE)
    assert updated.skew == pytest.approx(0.05)


def test_the_belief_turns_its_signs_when_it_crosses_the_wrap():
    belief = start(CableState(30.0, 89.9 * DEGREE, 40.0, 0.05), initial=UNIT)
    mean = np.array([30.0, 89.9 * DEGREE, 40.0, 0.05, 10.0, 10 * DEGREE, 2.0, 0.01])
    turning = CableKalmanFilter(mean, belief.covariance, belief.noise, 320)
    after = turning.predicted(0.04)
    expected = [-30.4, -89.7 * DEGREE, 40.08, -0.0504, -10.0, 10 * DEGREE, 2.0, -0.01]
    np.testing.assert_allclose(after.mean, expected)
    # d and alpha were not correlated with the rates of others; d and its own rate turn together.
    assert after.covariance[0, 4] > 0
    np.testing.assert_allclose(np.diag(after.covariance) > 0, True)


def test_the_covariance_of_components_that_turn_apart_changes_its_sign():
    covariance = np.diag(np.full(8, 4.0))
    covariance[0, 2] = covariance[2, 0] = 1.0
    mean = np.array([30.0, 89.9 * DEGREE, 40.0, 0.0, 0.0, 10 * DEGREE, 0.0, 0.0])
    after = CableKalmanFilter(mean, covariance, noise(), 320).predicted(0.04)
    assert after.covariance[0, 2] == pytest.approx(-1.0)


def test_lengths_of_the_noise_scale_with_the_image_and_angles_do_not():
    wide = start(CableState(0.0, 0.0, 30.0), width=640)
    np.testing.assert_allclose(np.diag(wide.covariance)[:4], [4.0, DEGREE**2, 4.0, DEGREE**2])


@given(
    st.lists(
        st.tuples(
            st.floats(-100, 100), st.floats(-1.57, 1.57), st.floats(5, 100), st.floats(-0.2, 0.2)
        ),
        min_size=1,
        max_size=15,
    )
)
def test_the_covariance_stays_symmetric_and_positive(measurements):
    belief = CableKalmanFilter.start(CableState(0.0, 0.0, 30.0), KalmanNoise(UNIT), 320)
    for values in measurements:
        belief = belief.predicted(0.04).updated(CableState(*values))
    np.testing.assert_allclose(belief.covariance, belief.covariance.T, rtol=1e-9, atol=1e-12)
    assert np.linalg.eigvalsh(belief.covariance).min() > 0
    assert -np.pi / 2 <= belief.state.angle <= np.pi / 2
    assert belief.state.to_array() == pytest.approx(belief.mean)


@dataclass
class Script:
    """A detector that says what it was told, whatever it sees, and notes where it had to look."""

    answers: list[list[Detection]]
    regions: list[SearchRegion | None] = field(default_factory=list)

    def detect(self, _image, region=None) -> list[Detection]:
        self.regions.append(region)
        return self.answers[len(self.regions) - 1]


def seen(*states: CableState) -> list[Detection]:
    return [Detection(state, 0.9 - 0.1 * rank) for rank, state in enumerate(states)]


def tracker(*answers, prior=None):
    detector = Script(list(answers))
    method = DetectorTracker(detector, NOISE)
    if prior is not None:
        method.initialise(GivenState.around(prior))
    return method, detector


def run(method, count, first=0):
    return [method.process(FRAME, 10**9 + 40_000_000 * (first + i)) for i in range(count)]


def statuses(estimates):
    return [estimate.status for estimate in estimates]


def test_three_hits_in_a_row_claim_a_cable():
    method, _ = tracker(seen(CABLE), seen(CABLE), seen(NEAR))
    assert statuses(run(method, 3)) == [SEEK, SEEK, HAVE]


def test_a_detection_elsewhere_is_no_hit():
    method, _ = tracker(seen(CABLE), seen(FAR), seen(CABLE), seen(CABLE), seen(CABLE))
    assert statuses(run(method, 5)) == [SEEK, SEEK, SEEK, SEEK, HAVE]


def test_before_the_claim_only_the_best_detection_counts():
    method, _ = tracker(seen(CABLE), seen(FAR, CABLE), seen(FAR, CABLE), seen(FAR, CABLE))
    assert statuses(run(method, 4)) == [SEEK, SEEK, SEEK, SEEK]


def test_a_first_glimpse_that_does_not_come_back_is_forgotten():
    method, _ = tracker(seen(FAR), [], [], seen(CABLE), seen(CABLE), seen(CABLE))
    assert statuses(run(method, 6)) == [SEEK, SEEK, SEEK, SEEK, SEEK, HAVE]


def test_the_status_is_tracking_from_a_prior_that_the_detector_confirms():
    method, _ = tracker(seen(NEAR), prior=CABLE)
    (estimate,) = run(method, 1)
    assert estimate.status is HAVE
    assert CABLE.distance < estimate.state.distance < NEAR.distance


def test_many_misses_in_a_row_lose_the_cable_and_it_is_found_again():
    answers = [seen(CABLE)] + [[]] * MISSES_TO_LOSE + [seen(FAR)] * 3
    method, detector = tracker(*answers, prior=CABLE)
    expected = [HAVE] * MISSES_TO_LOSE + [GONE, GONE, GONE, HAVE]
    assert statuses(run(method, len(answers))) == expected
    regions = [region is None for region in detector.regions]
    assert regions == [False] * (MISSES_TO_LOSE + 1) + [True] * 3


def test_a_hit_between_misses_keeps_the_cable():
    answers = ([seen(CABLE)] + [[]] * (MISSES_TO_LOSE - 1)) * 2
    method, _ = tracker(*answers, prior=CABLE)
    assert statuses(run(method, len(answers))) == [HAVE] * len(answers)


def test_the_region_follows_the_prediction_and_grows_with_misses():
    method, detector = tracker(seen(CABLE), [], [], [], [], prior=CABLE)
    run(method, 5)
    regions = detector.regions
    assert regions[1].state.distance == pytest.approx(CABLE.distance, abs=0.5)
    assert regions[4].distance > regions[1].distance >= 20.0
    assert regions[4].admits(CABLE.to_array()[None, :]).all()


def test_of_several_detections_the_expected_one_is_taken():
    method, _ = tracker(seen(FAR, NEAR, CABLE), prior=CABLE)
    (estimate,) = run(method, 1)
    assert abs(estimate.state.distance - CABLE.distance) < 1.0
    assert estimate.evidence in (0.8, 0.7)


def test_uncertainty_grows_while_nothing_is_seen():
    method, _ = tracker(seen(CABLE), [], [], prior=CABLE)
    sigmas = [estimate.standard_deviations()[0] for estimate in run(method, 3)]
    assert sigmas == sorted(sigmas)
    assert sigmas[0] < sigmas[2]


def test_a_cable_that_turns_across_the_wrap_is_followed():
    angles = np.deg2rad(np.arange(84.0, 97.0))
    truths = [
        CableState(20.0, a, 30.0) if a <= np.pi / 2 else CableState(-20.0, a - np.pi, 30.0)
        for a in angles
    ]
    method, _ = tracker(*[seen(truth) for truth in truths], prior=truths[0])
    estimates = run(method, len(truths))
    assert statuses(estimates) == [HAVE] * len(truths)
    assert estimates[-1].state.distance == pytest.approx(-20.0, abs=1.0)
    assert estimates[-1].state.angle == pytest.approx(truths[-1].angle, abs=0.02)


def test_all_that_is_said_is_finite_even_if_nothing_is_known():
    method, _ = tracker([])
    (estimate,) = run(method, 1)
    assert estimate.status is SEEK
    assert estimate.state.is_finite()
    assert estimate.evidence == 0.0
    assert np.isfinite(estimate.covariance).all()
    assert estimate.covariance.shape == (8, 8)


def test_the_time_between_frames_is_the_real_one():
    moving = [CableState(10.0 + 2.0 * i, 0.1, 30.0) for i in range(12)]
    slow, fast = (
        DetectorTracker(Script([seen(state) for state in moving]), NOISE) for _ in range(2)
    )
    for index in range(12):
        first = slow.process(FRAME, 10**9 + 80_000_000 * index)
        second = fast.process(FRAME, 10**9 + 40_000_000 * index)
    assert second.state.distance_rate == pytest.approx(50.0, rel=0.1)
    assert first.state.distance_rate == pytest.approx(25.0, rel=0.1)


@pytest.mark.parametrize(
    ("stamp", "size", "event"),
    [
        (700_000_000, (240, 320), "time went back by 0.300 s"),
        (7_000_000_000, (240, 320), "no frame for 6.000 s"),
        (1_040_000_000, (120, 160), "the image size changed from 320x240 to 160x120"),
    ],
)
def test_what_starts_the_search_anew(stamp, size, event):
    method, detector = tracker(seen(CABLE), [], prior=CABLE)
    run(method, 1)
    estimate = method.process(np.zeros(size, np.uint8), stamp)
    assert estimate.event == event
    assert estimate.status is SEEK
    assert detector.regions[-1] is None


@pytest.mark.parametrize(
    ("late", "words"), [(0, "that of the frame before"), (100_000_000, "out of order")]
)
def test_a_frame_that_is_no_later_is_refused_and_changes_nothing(late, words):
    method, _ = tracker(seen(CABLE), seen(CABLE), prior=CABLE)
    run(method, 1)
    with pytest.raises(FrameError, match=words):
        method.process(FRAME, 10**9 - late)
    assert statuses(run(method, 1, first=1)) == [HAVE]


def test_a_frame_that_is_no_picture_is_refused():
    method, _ = tracker()
    with pytest.raises(FrameError):
        method.process(np.zeros((4, 4), np.uint8), 1)


def test_a_prior_must_be_finite():
    method, _ = tracker()
    with pytest.raises(FrameError, match="must be finite"):
        method.initialise(GivenState.around(CableState(float("nan"), 0.0, 30.0)))
