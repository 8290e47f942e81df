from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.line_pairs import Detection
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.errors import FrameError
from cable_tracker.evaluation.baselines import MISSES_TO_LOSE, DetectorTracker
from cable_tracker.evaluation.kalman import KalmanNoise
from cable_tracker.tracking.status import TrackingStatus

pytestmark = pytest.mark.slow

FRAME = np.zeros((240, 320), np.uint8)
NOISE = KalmanNoise((1.0, 0.5, 2.0, 0.5))
CABLE = CableState(10.0, 0.1, 30.0, 0.02)
NEAR = CableState(11.0, 0.11, 31.0, 0.02)
FAR = CableState(-90.0, 0.6, 20.0)
SEEK, HAVE, GONE = TrackingStatus.INITIALISING, TrackingStatus.TRACKING, TrackingStatus.LOST


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
