import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.targets.comparison import (
    FIGURES,
    EvaluatedClaim,
    RunFigures,
    TargetCampaign,
    TargetMethodRun,
    claimed_in_view,
    claimed_while_absent,
    make_method,
    markdown_table,
    mean_figures,
    overlap,
    returns_found,
    share_on_own_target,
    success,
)
from cable_tracker.evaluation.targets.peers import PEERS
from cable_tracker.evaluation.targets.target_sequences import (
    RecordedTarget,
    SimulatedTarget,
    TargetEvaluationFrame,
)
from cable_tracker.sequences.labels.target_writer import write_target_bag
from cable_tracker.simulation.targets.sequence import labelled_frames, simulate_target
from cable_tracker.target.parameters.parameters import TargetParameters

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


def run(name, methods, length, **words):
    return TargetCampaign((SimulatedTarget(name, length),), (1,), methods, **words).run(
        lambda count: None
    )


def test_a_run_has_figures_for_every_method():
    counted = []
    methods = ("default", "CamShift", "grey default")
    campaign = TargetCampaign((SimulatedTarget("buoy", 12),), (1,), methods)
    results = campaign.run(counted.append)
    assert [each.method for each in results] == list(methods)
    assert all(each.values[FIGURES.index("claimed_in_view")] > 0.5 for each in results)
    assert results[0].values[FIGURES.index("success")] > 0.8
    assert results[0].values[FIGURES.index("centred")] > 0.8
    assert len(counted) == 12


@pytest.mark.parametrize("name", sorted(PEERS))
def test_peers_follow_an_easy_target(name):
    (result,) = run("near_surface", (name,), 8)
    assert result.values[0] > 0.5


def test_without_a_target_there_is_nothing_to_follow():
    assert run("nothing", ("default",), 3) == []


def test_parameters_of_the_users_are_a_method_of_their_own():
    own = TargetParameters(particle_count=60)
    (result,) = run("near_surface", ("few",), 6, tuned=(("few", own),))
    assert result.method == "few"
    assert result.values[FIGURES.index("claimed_in_view")] == 1.0


def test_frames_that_are_not_judged_do_not_count():
    frames = list(SimulatedTarget("near_surface", 6).frames(1))
    follower = TargetMethodRun("CamShift", make_method("CamShift", 1))
    for index, frame in enumerate(frames):
        follower.process(replace(frame, is_judged=index % 2 == 0))
    assert len(follower.claims) == 3


def test_a_frame_that_the_tracker_refuses_is_one_without_a_claim():
    first, second = list(SimulatedTarget("near_surface", 2).frames(1))
    follower = TargetMethodRun("default", make_method("default", 1))
    follower.process(first)
    follower.process(replace(second, stamp=first.stamp))
    assert [claim.claim is not None for claim in follower.claims] == [True, False]


def test_a_recording_with_boxes_is_judged_as_the_scenario_that_it_was_made_of(tmp_path):
    simulated = list(simulate_target("near_surface", 1, 6))
    write_target_bag(tmp_path / "dive", labelled_frames(simulated))
    recorded = RecordedTarget(tmp_path / "dive")
    assert recorded.frame_count() == 6
    (result,) = TargetCampaign((recorded,), (1,), ("default",)).run(lambda count: None)
    (expected,) = run("near_surface", ("default",), 6)
    assert result.values[:3] == expected.values[:3]


def test_a_recording_whose_target_is_never_seen_cannot_be_judged(tmp_path):
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 64), np.uint8))
    (tmp_path / "boxes.txt").write_text("0.png none\n")
    with pytest.raises(RecordingError, match="no frame has a box"):
        TargetCampaign((RecordedTarget(tmp_path),), (1,), ("default",)).run(lambda count: None)


def test_means_pass_over_what_has_no_figure():
    nan = math.nan
    rows = [
        RunFigures("buoy", 0, "default", (1.0, 1.0, 1.0, nan, nan, nan, 2.0)),
        RunFigures("leaving", 0, "default", (0.5, 0.0, 1.0, 0.2, 1.0, nan, 4.0)),
    ]
    means = mean_figures(rows, "default", None)
    assert means[:5] == [0.75, 0.5, 1.0, 0.2, 1.0]
    assert np.isnan(means[5])
    assert "| default | 75 | 50 | 100 | 20 | 100 |  | 3.0 |" in markdown_table(
        rows, ["default"], "note"
    )


def test_a_run_is_another_one_when_the_boxes_were_edited(tmp_path):
    boxes = tmp_path / "boxes.txt"
    boxes.write_text("1 1 5 5 # a.png\n")
    campaign = TargetCampaign((RecordedTarget(tmp_path, truth=boxes),), (1,), ("default",))
    before = campaign.fingerprint()
    assert campaign.fingerprint() == before
    boxes.write_text("1 1 5 50 # a.png\n")
    assert campaign.fingerprint() != before


@pytest.mark.parametrize("name", ["MIL", "CamShift", "default"])
@pytest.mark.parametrize(
    "box", [(310.0, 36.0, 324.0, 84.0), (150.0, 50.0, 152.0, 60.0), (400.0, 36.0, 424.0, 84.0)]
)
def test_a_box_that_a_method_cannot_take_ends_no_evaluation(name, box):
    picture = np.random.default_rng(0).integers(0, 255, (240, 320, 3), np.uint8)
    run = TargetMethodRun(name, make_method(name, 0))
    for number in range(2):
        run.process(TargetEvaluationFrame(picture, 1_000_000_000 + number * 40_000_000, box))
    assert len(run.claims) == 2
    if box[0] != 310.0:
        assert run.refusal.startswith("frame 0: ")


def test_frames_that_were_refused_are_told_below_the_table():
    figures = RunFigures("buoy", 0, "thesis", (0.0,) * 7, "frame 0: it does not stand out")
    table = markdown_table([figures], ["thesis"], "note")
    assert "`thesis` refused frames in 1 runs of buoy, first frame 0: it does not" in table
