"""`report.html` of a long survey in a real Chromium."""

import cv2
import numpy as np
import pytest

from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.survey.outputs.maps import SurveyMap
from cable_tracker.survey.outputs.report import RecordingRow, write_report
from cable_tracker.survey.routes.events import Event, EventKind
from cable_tracker.survey.routes.merging import MergedRoute

EVENTS = 300


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A route of 10 km with many events, the first of which has a picture."""
    folder = tmp_path_factory.mktemp("report")
    pictures = folder / "recordings" / "dive" / "pictures"
    pictures.mkdir(parents=True)
    for frame in range(100):
        cv2.imwrite(str(pictures / f"{frame}.jpg"), np.full((18, 24), frame, np.uint8))
    along = np.arange(20_001) * 0.5
    headings = 0.4 * np.sin(along / 300)
    places = np.cumsum(0.5 * np.column_stack((np.cos(headings), np.sin(headings))), axis=0)
    level = np.ones(len(along))
    events = tuple(
        Event(
            EventKind.CROSSING, 30.0 * k, 30.0 * k + 5, tuple(places[60 * k]), 10**9, k, "a line",
            "dive",
        )
        for k in range(EVENTS)
    )  # fmt: skip
    route = MergedRoute(
        along, places, headings, 0.05 * level, level, 0.16 * level, 0.1 * level, level, events,
        ("dive",),
    )  # fmt: skip
    survey = SurveyMap((route,), LocalFrame(54.25, 7.9), ("route 1",), folder=folder)
    rows = [RecordingRow("dive", "done", 1000, 900, 50.0, ())]
    write_report(folder / "report.html", survey, rows, "Cable")
    return (folder / "report.html").as_uri()


def drawn(page, canvas) -> int:
    """Return how many pixels of a canvas are not empty."""
    return page.evaluate(
        """(name) => {
          const own = document.getElementById(name);
          const { data } = own.getContext("2d").getImageData(0, 0, own.width, own.height);
          return data.filter((value, place) => place % 4 === 3 && value).length;
        }""",
        canvas,
    )


def test_map_and_profile_are_drawn_at_once(visit, report):
    with visit(report) as page:
        assert drawn(page, "map") > 1000
        assert drawn(page, "profile") > 1000


def test_pictures_are_made_when_they_are_scrolled_to(visit, report):
    with visit(report) as page:
        assert page.locator("td img").count() == 0
        page.locator("#events").scroll_into_view_if_needed()
        page.locator("td img").first.wait_for()
        assert 0 < page.locator("td img").count() < 100


def test_an_event_of_the_table_is_shown_in_the_map(visit, report):
    with visit(report) as page:
        page.locator('tr.event[data-event="7"]').click()
        page.locator("#detail h3", has_text="crossing").wait_for()
        assert "KP 0.210" in page.locator("#detail").inner_text()
        assert page.locator("#detail img").evaluate("image => image.naturalWidth") == 24
        page.locator('tr.event[data-event="200"]').click()
        page.locator("#detail", has_text="KP 6.000").wait_for()
        assert page.locator("#detail img").count() == 0
