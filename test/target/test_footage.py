"""A real approach to a red buoy, with a swimmer and a second red thing as distractors."""

import cv2
import numpy as np
import pytest

from cable_tracker.evaluation.targets.comparison import EvaluatedClaim, overlap, success
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker

STEP = 40_000_000
"""Far less time than has passed between these pictures: size and place change in leaps [ns]."""


@pytest.fixture(scope="module")
def approach(real_footage):
    folder = real_footage("target/buoy")
    lines = (folder / "boxes.txt").read_text().splitlines()
    labels = [line.split() for line in lines if line and not line.startswith("#")]
    return [
        (cv2.imread(str(folder / name)), tuple(float(side) for side in sides))
        for name, _, *sides in labels
    ]


def follow(approach, seed):
    tracker = TargetTracker(TargetParameters(seed=seed).with_detector())
    claims = []
    for number, (picture, box) in enumerate(approach, start=1):
        estimate = tracker.process(picture, number * STEP)
        claim = estimate.box if estimate.status.value == "TRACKING" else None
        claims.append(EvaluatedClaim(box, claim, None, 0.0, len(claims)))
    return claims


def test_a_proposed_buoy_is_followed_through_leaps_and_nothing_else_is_claimed(approach):
    runs = [follow(approach, seed) for seed in range(3)]
    assert np.mean([success(claims) for claims in runs]) > 0.85
    claimed = [each for claims in runs for each in claims if each.claim is not None]
    assert all(overlap(each.truth, each.claim) > 0.1 for each in claimed)
