import numpy as np
import pytest
from survey_dives import DISK, LOOK, Plan, make_dive, poses_of, true_aside

from cable_tracker.survey.keyframes import make_keyframes
from cable_tracker.survey.smoother import smooth


def smoothed(plan: Plan):
    dive = make_dive(plan)
    rows = dive.table.rows
    keyframes = make_keyframes(rows, poses_of(dive).at(rows["stamp"]), DISK)
    cable = smooth(keyframes, DISK)
    where = keyframes.look_lines.copy()
    where[:, 0] -= 0.7 * np.cos(where[:, 2])
    where[:, 1] -= 0.7 * np.sin(where[:, 2])
    truth = np.array([true_aside(pose, plan.bend)[0] for pose in where])
    return keyframes, cable, truth


def rms(values) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_claims_become_better_by_what_lies_before_and_behind():
    keyframes, cable, truth = smoothed(Plan(noise=0.05))
    known = np.isfinite(keyframes.claims[:, 0])
    assert rms((cable.states[:, 0] - truth)[known]) < 0.7 * rms(
        (keyframes.claims[:, 0] - truth)[known]
    )


def test_a_buried_stretch_is_bridged_with_honest_doubt():
    keyframes, cable, truth = smoothed(Plan(hidden=((15.0, 22.0),)))
    gap = ~np.isfinite(keyframes.claims[:, 0])
    sigma = np.sqrt(cable.covariances[:, 0, 0])
    assert gap.sum() > 50
    assert rms((cable.states[:, 0] - truth)[gap]) < 0.15
    assert sigma[gap].max() > 2 * sigma[~gap].max()
    assert np.mean(np.abs(cable.states[:, 0] - truth) < 1.96 * sigma) > 0.85


def test_wrong_claims_lose_their_weight():
    keyframes, cable, truth = smoothed(Plan(wrong=((20.0, 20.6),)))
    off = np.abs(keyframes.claims[:, 0] - truth) > 0.4
    assert off.any()
    assert cable.weights[off].max() < 0.2
    assert rms((cable.states[:, 0] - truth)[off]) < 0.1


@pytest.mark.parametrize("diameter", [0.06, 0.11])
def test_claims_of_something_thinner_over_a_buried_stretch_do_not_draw_the_cable_along(diameter):
    plan = Plan(hidden=((15.0, 24.0),), rope=((16.0, 23.0),), rope_diameter=diameter)
    keyframes, cable, truth = smoothed(plan)
    assert keyframes.doubtful.sum() > 50
    assert cable.weights[keyframes.doubtful].max() == 0.0
    sigma = np.sqrt(cable.covariances[:, 0, 0])
    assert rms((cable.states[:, 0] - truth)[keyframes.doubtful]) < 0.2
    assert np.mean(np.abs(cable.states[:, 0] - truth) < 1.96 * sigma) > 0.85


@pytest.mark.parametrize("clear", [False, True])
def test_a_short_claim_of_something_else_in_a_buried_stretch_does_not_bend_the_cable(clear):
    dive = make_dive(Plan(hidden=((15.0, 24.0),), rope=((18.0, 18.7),), rope_diameter=0.16))
    rows = dive.table.rows
    along = 0.05 * np.arange(len(rows)) + LOOK
    other = (along > 18.0) & (along < 18.7)
    if clear:
        rows["profile_score"][other] = 3.0
    keyframes = make_keyframes(rows, poses_of(dive).at(rows["stamp"]), DISK)
    cable = smooth(keyframes, DISK)
    on_it = np.isfinite(keyframes.claims[:, 0]) & other[keyframes.first]
    assert on_it.any()
    assert keyframes.doubtful[on_it].all()
    assert cable.weights[on_it].max() == 0.0


def test_a_dive_of_short_claims_alone_is_believed():
    dive = make_dive(Plan(hidden=tuple((start + 1.2, start + 4.0) for start in range(0, 40, 4))))
    rows = dive.table.rows
    keyframes = make_keyframes(rows, poses_of(dive).at(rows["stamp"]), DISK)
    assert not keyframes.doubtful.any()
    assert (smooth(keyframes, DISK).weights > 0.3).any()


def test_a_cable_that_looks_thin_where_it_is_known_to_be_counts():
    dive = make_dive(Plan())
    rows = dive.table.rows
    rows["diameter"][100:120] = 0.08
    keyframes = make_keyframes(rows, poses_of(dive).at(rows["stamp"]), DISK)
    assert keyframes.doubtful.any()
    assert smooth(keyframes, DISK).weights[keyframes.doubtful].min() > 0.2


def test_without_the_backward_pass_claims_that_come_later_tell_nothing():
    keyframes, cable, truth = smoothed(Plan(hidden=((15.0, 22.0),)))
    forwards = smooth(keyframes, DISK, backward_pass=False)
    gap = ~np.isfinite(keyframes.claims[:, 0])
    assert rms((forwards.states[:, 0] - truth)[gap]) > 2 * rms((cable.states[:, 0] - truth)[gap])


@pytest.mark.parametrize("seed", range(4))
def test_regions_hold_the_cable_about_as_often_as_they_say(seed):
    _, cable, truth = smoothed(Plan(length=80.0, noise=0.03, seed=seed))
    sigma = np.sqrt(cable.covariances[:, 0, 0])
    held = np.mean(np.abs(cable.states[:, 0] - truth) < 1.96 * sigma)
    assert 0.8 < held <= 1.0


def test_claims_that_are_off_by_alike_where_sand_begins_make_nothing_sure():
    """Clear claims are better than the tracker says; unsure ones in a row are off together."""
    dive = make_dive(Plan(hidden=((15.0, 22.0),)))
    rows = dive.table.rows
    poses = poses_of(dive).at(rows["stamp"])
    ahead = poses[:, 0] + LOOK
    rows["aside_variance"] = 0.1**2
    unsure = (ahead > 11.0) & (ahead < 15.0)
    rows["aside_variance"][unsure] = 0.2**2
    rows["aside"][unsure] += 0.12
    keyframes = make_keyframes(rows, poses, DISK)
    cable = smooth(keyframes, DISK)
    truth = np.array([true_aside(pose, 0.03)[0] for pose in poses[keyframes.first]])
    sigma = np.sqrt(cable.covariances[:, 0, 0])
    edge = (keyframes.look_lines[:, 0] > 11.0) & (keyframes.look_lines[:, 0] < 16.0)
    assert cable.scales[0] < 0.5
    assert (np.abs(cable.states[:, 0] - truth) < 1.96 * sigma)[edge].all()


def test_the_way_along_the_cable_is_its_length():
    _, cable, _ = smoothed(Plan())
    assert cable.along[-1] - cable.along[0] == pytest.approx(40.0, rel=0.03)


def test_a_gap_in_the_navigation_ends_a_piece():
    dive = make_dive(Plan())
    rows = dive.table.rows
    poses = poses_of(dive).at(rows["stamp"])
    poses[300:420] = np.nan
    cable = smooth(make_keyframes(rows, poses, DISK), DISK)
    assert set(cable.piece) == {0, 1}


@pytest.mark.parametrize("course", ["on the spot", "between two pictures"])
def test_a_cable_that_is_followed_back_the_other_way_is_another_piece(course):
    dive = make_dive(Plan(bend=0.0, length=20.0))
    there = dive.table.rows
    poses = [poses_of(dive).at(there["stamp"])]
    rows = [there.copy()]
    if course == "on the spot":
        turn = np.repeat(poses[0][-1:], 30, axis=0)
        turn[:, 2] += np.linspace(0.1, np.pi - 0.1, 30)
        unseen = np.repeat(there[-1:], 30)
        unseen["status"], unseen["aside"], unseen["heading"] = 0, np.nan, np.nan
        poses.append(turn)
        rows.append(unseen)
    back = there[::-1].copy()
    back["aside"] *= -1.0
    poses.append(poses[0][::-1] + np.array([0.0, 0.0, np.pi]))
    rows.append(back)
    table = np.concatenate(rows)
    table["stamp"] = there["stamp"][0] + np.arange(len(table)) * 100_000_000
    cable = smooth(make_keyframes(table, np.concatenate(poses), DISK), DISK)
    claimed = cable.weights > 0.0
    pieces = np.unique(cable.piece[claimed])
    ends = [np.ptp(cable.along[claimed & (cable.piece == piece)]) for piece in pieces]
    assert ends == pytest.approx([20.0, 20.0], abs=2.5)
