import math

import pytest

from cable_tracker.evaluation.targets.metrics import (
    EvaluatedClaim,
    claimed_in_view,
    claimed_while_absent,
    overlap,
    returns_found,
    share_on_own_target,
    success,
)

HERE, BESIDE, FAR = (0, 0, 10, 10), (0, 4, 10, 14), (50, 50, 60, 60)


def judged(*pairs, twin=None):
    return [
        EvaluatedClaim(truth, claim, twin, 1.0, number)
        for number, (truth, claim) in enumerate(pairs)
    ]


def test_overlap_is_intersection_over_union():
    assert overlap(HERE, HERE) == 1.0
    assert overlap(HERE, BESIDE) == pytest.approx(60 / 140)
    assert overlap(HERE, FAR) == overlap(HERE, None) == 0.0


def test_success_counts_frames_in_view_only():
    claims = judged((HERE, HERE), (HERE, BESIDE), (HERE, None), (HERE, HERE), (None, HERE))
    assert success(claims) == 0.5
    assert claimed_in_view(claims) == 0.75
    assert claimed_while_absent(claims) == 1.0


def test_what_never_happens_has_no_figure():
    assert math.isnan(claimed_while_absent(judged((HERE, HERE))))
    assert math.isnan(success(judged((None, None))))


def test_a_return_is_found_within_fifteen_frames_or_not():
    late = [(None, None)] + [(HERE, FAR)] * 16 + [(HERE, HERE)]
    soon = [(None, None)] + [(HERE, FAR)] * 15 + [(HERE, HERE)]
    assert returns_found(judged(*late)) == [False]
    assert returns_found(judged(*soon)) == [True]


def test_the_own_target_is_the_one_that_the_box_overlaps_more():
    assert share_on_own_target(judged((HERE, BESIDE), twin=FAR)) == 1.0
    assert share_on_own_target(judged((HERE, FAR), twin=FAR)) == 0.0


def test_a_return_is_found_in_time_by_frames_and_before_the_next_absence():
    box = (10.0, 10.0, 50.0, 50.0)

    def claim(number, truth, found):
        return EvaluatedClaim(truth, found, None, 1.0, number)

    sparse = [claim(0, None, None), claim(10, box, None), claim(20, box, None), claim(30, box, box)]
    assert returns_found(sparse) == [False]
    twice = [
        claim(0, None, None), claim(1, box, None), claim(2, None, None), claim(3, box, box),
    ]  # fmt: skip
    assert returns_found(twice) == [False, True]
