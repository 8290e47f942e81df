from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.survey.outputs.report import RecordingRow, _summary, write_report


def test_the_report_fetches_nothing_and_cannot_be_broken_by_a_name(survey, tmp_path):
    rows = [RecordingRow("</script><b>dive", "done", 10, 9, 1.0, ("<i>note</i>",))]
    write_report(tmp_path / "report.html", survey, rows, "Cable")
    page = (tmp_path / "report.html").read_text()
    assert "http:" not in page and "https:" not in page and 'src="' not in page
    assert "</script><b>" not in page and "<i>note" not in page


@pytest.mark.parametrize(
    ("shares", "words"),
    [([1.0, 1.0, 0.5, 0.5], "75.0"), ([0.5, 0.5, np.nan, 0.5], "50.0"), ([np.nan] * 4, "")],
)
def test_a_cable_that_one_of_two_dives_sees_is_visible_to_half_of_them(survey, shares, words):
    count = len(survey.routes[0].along)
    route = replace(survey.routes[0], visible=np.resize(shares, 4 * (count // 4)))
    assert _summary("route 1", route)["visible"] == words
