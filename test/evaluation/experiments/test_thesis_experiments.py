import dataclasses

import pytest

from cable_tracker.cable.measure.scan_filters import scan_kernels
from cable_tracker.campaigns.settings import HERE, CampaignSettings, ClusterSettings
from cable_tracker.evaluation.experiments.thesis_experiments import (
    SPEED_TAPS,
    ReinitialisationExperiment,
    SequenceExperiment,
    SpeedExperiment,
    _SpeedSetting,
)


@pytest.fixture(scope="module")
def begun_anew(stripe):
    """Tables of two long sequences, the second with a cable that is half hidden."""
    clear = dataclasses.replace(stripe, length=130)
    faint = dataclasses.replace(clear, name="faint", visibility=0.5)
    experiment = ReinitialisationExperiment((0,), (clear, faint), ("default",))
    return experiment.run(HERE, lambda count: None).tables


def test_sequences_are_followed_by_every_method(stripe):
    experiment = SequenceExperiment((0, 1), (stripe,))
    told = []
    result = experiment.run(HERE, told.append)
    assert [row[:3] for row in result.tables[0].rows] == [
        ("stripe", "default", "2"),
        ("stripe", "thesis", "2"),
    ]
    assert [picture.file_name for picture in result.pictures] == ["sequence_stripe.png"]
    assert sum(told) == experiment.frame_count() == 24


def test_the_search_begins_anew_every_100_frames(begun_anew):
    sequence, _, everything = begun_anew[0].rows
    # 130 frames: one whole part and one of 30 frames, enough to tell.
    assert sequence[:3] == ("stripe", "default", "2")
    assert everything[:3] == ("all", "default", "4")
    assert sum(float(share) for share in sequence[3:6]) == pytest.approx(100.0)


def test_clear_starts_are_told_apart(begun_anew):
    every, clear = begun_anew
    assert [row[2] for row in every.rows] == ["2", "2", "4"]
    assert [row[2] for row in clear.rows] == ["2", "0", "2"]
    assert clear.rows[0] == every.rows[0]
    assert set(clear.rows[1][3:]) == {"–"}


def test_speed_is_measured_for_every_combination(stripe):
    experiment = SpeedExperiment((0,), stripe, particles=(50, 400), taps=(5, 11))
    result = experiment.run(CampaignSettings(ClusterSettings(2)), lambda count: None)
    assert [row[:2] for row in result.tables[0].rows] == [
        ("50", "5"),
        ("400", "5"),
        ("50", "11"),
        ("400", "11"),
    ]
    # Which takes longer hangs on what else the computer does.
    for row in result.tables[0].rows:
        assert 0.0 < float(row[2]) <= float(row[3])


@pytest.mark.parametrize("taps", SPEED_TAPS)
def test_filters_are_as_long_as_their_row_says(taps):
    parameters = _SpeedSetting(50, taps).filter().parameters
    assert len(scan_kernels(parameters.filter_sigma, 1.0, 1).derivative) == taps


def test_every_row_has_a_number_for_every_heading(stripe):
    result = SpeedExperiment((0,), stripe, particles=(50,), taps=(5,)).run(HERE, lambda count: None)
    (table,) = result.tables
    assert all(len(row) == len(table.headings) for row in table.rows)
