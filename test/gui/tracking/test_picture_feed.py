import asyncio

import numpy as np
import pytest
from stub_session import StubSession

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from socket_end import Browser

from cable_tracker.gui.session.session import CableSnapshot
from cable_tracker.gui.tracking.picture_feed import PictureFeed
from cable_tracker.sequences.tables.estimates import EstimateRow

from ..conftest import unpack

TIMEOUT = 300.0


async def picture_at(browser):
    """Wait for a picture; return its description and its sections."""
    return unpack(await asyncio.wait_for(browser.received.get(), TIMEOUT))


class Shown(StubSession):
    """Shows black pictures."""

    def show(self, number, **given):
        given = {"image": np.zeros((24, 32), np.uint8)} | given
        row = EstimateRow(number, number * 40_000_000, "TRACKING")
        self.tell(CableSnapshot(number, number, row=row, **given))


@pytest.fixture
def feed():
    feed = PictureFeed()
    yield feed
    feed.close()


@pytest.fixture
def session(feed):
    session = Shown()
    feed.watch(session)
    return session


def test_what_a_session_tells_when_another_is_watched_is_not_shown(feed, session):
    (telling,) = session._listeners
    other = Shown()
    feed.watch(other)
    other.show(1)
    late = EstimateRow(7, 280_000_000, "LOST")
    telling(CableSnapshot(7, 7, np.zeros((24, 32), np.uint8), late))
    assert feed._snapshot is other.latest


def looking(feed, *visits):
    """Run visits of browsers one after the other."""

    async def run():
        for visit in visits:
            browser = Browser()
            serving = asyncio.create_task(feed.channel.serve(browser))
            await visit(browser)
            browser.leaves()
            await serving

    asyncio.run(run())


def test_a_browser_that_comes_late_sees_what_stands_still(feed, session):
    session.show(1)

    async def visit(browser):
        assert (await picture_at(browser))[0]["number"] == 1

    looking(feed, visit)


def test_a_slow_browser_misses_pictures_and_ends_with_the_newest(feed, session):
    session.show(1)

    async def visit(browser):
        assert (await picture_at(browser))[0]["number"] == 1
        for number in range(2, 50):
            session.show(number)
        number = 1
        while number < 49:
            browser.has_drawn()
            number = (await picture_at(browser))[0]["number"]

    looking(feed, visit)


def test_who_comes_gets_the_whole_history(feed, session):
    for number in range(1, 300):
        session.show(number)

    async def visit(browser):
        description, sections = await picture_at(browser)
        while not description["history_is_whole"]:
            browser.has_drawn()
            description, sections = await picture_at(browser)
        assert len(sections["history"]) == 299

    looking(feed, visit, visit)


def test_a_frame_that_cannot_be_shown_is_said_and_the_next_one_comes(feed, session):
    session.show(1, image=np.zeros((0, 8), np.uint8))

    async def visit(browser):
        description, _ = await picture_at(browser)
        assert description["number"] == 1
        assert description["status"] == "TRACKING"
        assert "cannot be encoded as JPEG" in description["reason"]
        session.show(2)
        browser.has_drawn()
        assert (await picture_at(browser))[0]["number"] == 2

    looking(feed, visit)


def test_another_session_takes_the_place_of_the_first(feed, session):
    session.show(5)
    other = Shown()
    feed.watch(other)
    other.show(1)
    session.show(6)

    async def visit(browser):
        assert (await picture_at(browser))[0]["number"] == 1

    looking(feed, visit)
