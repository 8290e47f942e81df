import math

import pytest

from cable_tracker.evaluation.metrics.losses import loss_episodes, loss_statistics


def test_losses_end_with_recovery_or_with_the_cable(trace):
    recovered, departed, final = loss_episodes(trace("hllhxnnhl"))
    assert (recovered.start, recovered.frame_count, recovered.recovered) == (1, 2, True)
    assert recovered.seconds == pytest.approx(0.08)
    assert (departed.start, departed.frame_count, departed.recovered) == (4, 1, False)
    assert (final.start, final.frame_count, final.recovered) == (8, 1, False)
    assert final.seconds == pytest.approx(0.04)


def test_frames_without_a_label_do_not_interrupt_a_loss(trace):
    (loss,) = loss_episodes(trace("hlulh"))
    assert loss.frame_count == 2
    assert loss.seconds == pytest.approx(0.12)


def test_a_loss_ends_with_its_recording(trace, apart):
    first, second = loss_episodes(apart(trace("hll"), trace("lh")))
    assert (first.start, first.frame_count, first.recovered) == (1, 2, False)
    assert first.seconds == pytest.approx(0.08)
    assert (second.start, second.frame_count, second.recovered) == (3, 1, True)
    assert second.seconds == pytest.approx(0.04)


def test_loss_statistics_by_hand(trace):
    loss = loss_statistics(trace("hllhlnnhlllh"))
    assert loss.share == pytest.approx(6 / 10)
    assert loss.longest_frames == 3
    assert loss.longest_seconds == pytest.approx(0.12)
    assert loss.recovery_seconds == pytest.approx((0.08 + 0.12) / 2)
    assert loss.unrecovered == 1


def test_without_a_loss_there_is_no_time_to_recover(trace):
    loss = loss_statistics(trace("hhh"))
    assert (loss.share, loss.longest_frames, loss.unrecovered) == (0.0, 0.0, 0.0)
    assert math.isnan(loss.recovery_seconds)


def test_without_a_cable_nothing_can_be_lost(trace):
    assert math.isnan(loss_statistics(trace("fnn")).share)
