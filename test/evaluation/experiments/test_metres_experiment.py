from __future__ import annotations

import pytest

from cable_tracker.campaigns.settings import HERE
from cable_tracker.evaluation.evaluation_sequences import ScenarioSequence
from cable_tracker.evaluation.experiments.metres_experiment import MetresExperiment

pytestmark = pytest.mark.slow


def run(experiment):
    return experiment.run(HERE, lambda count: None).tables


def test_metres_are_within_the_goals_on_a_calm_flight():
    """3 % of the altitude, 1 deg: of tracker output, with noisy altimeter and imu."""
    experiment = MetresExperiment((0,), (ScenarioSequence("S3", 30),))
    for table in run(experiment):
        (row,) = table.rows
        sequence, runs, with_metres, foot, heading, on_cable = row[:6]
        assert (sequence, runs) == ("S3", "1")
        assert float(with_metres) > 80.0 and float(on_cable) == 100.0
        assert float(foot) < 3.0 and float(heading) < 1.0


def test_over_several_dives_medians_stand_with_their_range():
    experiment = MetresExperiment((0, 1), (ScenarioSequence("S3", 6),))
    told = []
    without, with_odometry = experiment.run(HERE, told.append).tables
    assert sum(told) == experiment.frame_count() == 24
    assert "–" in without.rows[0][4]
    assert len(without.rows[0]) == len(without.headings)
    assert without.rows != with_odometry.rows


def test_a_flight_without_a_cable_has_no_metres():
    experiment = MetresExperiment((0,), (ScenarioSequence("no_cable", 1),))
    for table in run(experiment):
        assert set(table.rows[0][2:]) == {"–"}
