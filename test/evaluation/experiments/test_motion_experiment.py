from __future__ import annotations

import pytest

from cable_tracker.campaigns.settings import HERE
from cable_tracker.evaluation.evaluation_sequences import ScenarioSequence
from cable_tracker.evaluation.experiments import motion_experiment
from cable_tracker.evaluation.experiments.aided import OdometryFault
from cable_tracker.evaluation.experiments.motion_experiment import (
    SETTINGS,
    MotionExperiment,
    MotionSetting,
)

pytestmark = pytest.mark.slow

SHORT = (ScenarioSequence("S3", 6),)


def test_settings_stand_in_rows_with_a_cell_for_every_heading():
    settings = (
        MotionSetting("as it is", None),
        MotionSetting("half the frame rate", OdometryFault.NONE, 0.5, 2),
        MotionSetting("as it is", None, preset="thesis"),
    )
    told = []
    experiment = MotionExperiment((0, 1), SHORT, settings)
    default, thesis = experiment.run(HERE, told.append).tables
    assert [row[:3] for row in default.rows] == [
        ("as it is", "none", "2"),
        ("half the frame rate", "sound", "2"),
    ]
    assert [row[:3] for row in thesis.rows] == [("as it is", "none", "2")]
    # Beside the frames lost stand those of the same dives without odometry, if they were run.
    assert default.rows[0][4] == default.rows[0][3] and default.rows[1][4] == "–"
    assert all(len(row) == len(t.headings) for t in (default, thesis) for row in t.rows)
    assert sum(told) == experiment.frame_count() == 12


def test_broken_odometry_is_run_on_the_first_seeds_only(monkeypatch):
    monkeypatch.setattr(motion_experiment, "FAULT_SEEDS", 1)
    settings = (MotionSetting("as it is", None), MotionSetting("as it is", OdometryFault.TURNED))
    experiment = MotionExperiment((7, 8), (ScenarioSequence("S3", 2),), settings)
    (table,) = experiment.run(HERE, lambda n: None).tables
    assert [row[2] for row in table.rows] == ["2", "1"]


def test_every_fault_is_run_with_everything_that_makes_it_harder():
    assert len(set(SETTINGS)) == len(SETTINGS)
    default = {(s.name, s.fault) for s in SETTINGS if s.preset == "default"}
    names = {name for name, _ in default}
    assert default == {(name, fault) for name in names for fault in (None, *OdometryFault)}
