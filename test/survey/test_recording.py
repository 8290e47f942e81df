import numpy as np
import pytest
from survey_dives import Plan, make_dive

from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.survey.recording import SurveySettings, analyse, middle_fix

NEAR = np.array([[54.0 + 1e-5 * k, 8.0 - 2e-5 * k] for k in range(9)])


@pytest.mark.parametrize("old", [[10.0, 8.0], [54.0, -172.0], [-90.0, 0.0]])
def test_an_old_place_that_a_receiver_begins_with_is_not_the_datum(old):
    fixes = np.vstack(([old] * 4, NEAR))
    assert middle_fix(fixes) in list(map(tuple, NEAR.tolist()))


def test_the_only_fix_is_the_datum():
    assert middle_fix(np.array([[54.0, 8.0]])) == (54.0, 8.0)


def test_on_both_sides_of_180_degrees_fixes_are_near():
    fixes = np.array([[0.0, 20.0], [0.0, 179.9999], [0.0, -179.9999], [0.0, 179.9998]])
    assert middle_fix(fixes)[1] != 20.0


def test_a_datum_on_the_other_side_of_the_earth_is_told_and_lays_nothing_there():
    dive = make_dive(Plan())
    stamps = dive.table.rows["stamp"]
    for k, east in enumerate(np.linspace(0.0, 40.0, 20)):
        latitude, longitude = LocalFrame(54.25, 7.9).to_degrees(np.array([[east, 0.0]]))[0]
        dive.fixes.add(int(stamps[20 * k]), [latitude, longitude, 0.01, 0.01])
    right, _ = analyse(dive, SurveySettings(datum=(54.25, 7.9)))
    wrong, _ = analyse(dive, SurveySettings(datum=(7.9, 54.25)))
    assert right.on_earth and not wrong.on_earth
    assert any("km from the fixes" in note for note in wrong.notes)
