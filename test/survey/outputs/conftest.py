import pytest
from survey_dives import Plan, make_dive

from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.survey.outputs.maps import WRITERS, SurveyMap
from cable_tracker.survey.recording import SurveySettings, analyse
from cable_tracker.survey.routes.merging import merge


@pytest.fixture(scope="session")
def survey() -> SurveyMap:
    surveyed, _ = analyse(make_dive(Plan(hidden=((15.0, 21.0),))), SurveySettings())
    return SurveyMap(tuple(merge(surveyed.routes)), LocalFrame(54.25, 7.9), ("route 1",))


@pytest.fixture(scope="session")
def written(survey, tmp_path_factory):
    folder = tmp_path_factory.mktemp("map")
    for name, write in WRITERS.items():
        write(folder / name, survey)
    return folder
