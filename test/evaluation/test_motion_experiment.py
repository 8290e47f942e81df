from __future__ import annotations

from cable_tracker.evaluation.aided import OdometryFault
from cable_tracker.evaluation.frames import ScenarioSequence
from cable_tracker.evaluation.metres_experiment import MetresExperiment
from cable_tracker.evaluation.motion_experiment import MotionExperiment, MotionSetting

SHORT = (ScenarioSequence("S3", 6),)


def test_settings_stand_in_rows_with_a_cell_for_every_heading():
    settings = (
        MotionSetting("as it is", None),
        MotionSetting("half the frame rate", OdometryFault.NONE, 0.5, 2),
    )
    told = []
    experiment = MotionExperiment((0, 1), SHORT, settings)
    (table,) = experiment.run(1, told.append).tables
    assert [row[:2] for row in table.rows] == [
        ("as it is", "none"),
        ("half the frame rate", "sound"),
    ]
    assert all(len(row) == len(table.headings) for row in table.rows)
    assert sum(told) == experiment.frame_count() == 12


def test_metres_are_within_the_goals_on_a_calm_flight():
    """3 % of the altitude, 1 deg: of tracker output, with noisy altimeter and imu."""
    experiment = MetresExperiment((0,), (ScenarioSequence("S3", 30),))
    (row,) = experiment.run(1, lambda count: None).tables[0].rows
    sequence, frames, with_metres, foot, ahead, heading = row[:6]
    assert (sequence, frames) == ("S3", "30")
    assert float(with_metres) > 80.0
    assert float(foot) < 3.0 and float(ahead) < 3.0 and float(heading) < 1.0


def test_a_flight_without_a_cable_has_no_metres():
    experiment = MetresExperiment((0,), (ScenarioSequence("no_cable", 3),))
    (row,) = experiment.run(1, lambda count: None).tables[0].rows
    assert row[1:4] == ("0", "0", "–")
