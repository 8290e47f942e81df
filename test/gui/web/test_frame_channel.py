import asyncio
import importlib
import json
import struct
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from socket_end import Browser

from cable_tracker.gui.web.frame_channel import (
    ALIGNMENT,
    FrameChannel,
    float_section,
    jpeg_section,
    pack,
)

from ..conftest import unpack

TABLES = arrays.arrays(
    np.float32,
    st.tuples(st.integers(0, 7), st.integers(1, 5)),
    elements=st.floats(-1e6, 1e6, width=32),
)
WORDS = st.dictionaries(
    st.text(max_size=8).filter(lambda key: key != "sections"),
    st.one_of(st.integers(-(2**53), 2**53), st.text(max_size=20), st.booleans(), st.none()),
)


def test_both_windows_can_be_opened_in_one_process():
    for name in ("tracking.window", "labelling.window"):
        importlib.import_module(f"cable_tracker.gui.{name}")


async def turns():
    for _ in range(20):
        await asyncio.sleep(0)


def watching(scenario, browsers=1):
    """Run a scenario with browsers that look at a channel."""

    async def run():
        channel = FrameChannel()
        seen = [Browser() for _ in range(browsers)]
        serving = [asyncio.create_task(channel.serve(browser)) for browser in seen]
        await turns()
        await scenario(channel, *seen)
        for browser in seen:
            browser.leaves()
        await asyncio.gather(*serving)
        assert not channel.is_wanted

    asyncio.run(run())


def test_a_packet_reaches_the_browser():
    async def scenario(channel, browser):
        channel.publish(b"one")
        assert await browser.received.get() == b"one"

    watching(scenario)


def test_the_next_packet_waits_until_the_last_is_drawn_and_is_the_newest():
    async def scenario(channel, browser):
        for packet in (b"one", b"two", b"three"):
            channel.publish(packet)
            await turns()
        assert browser.received.qsize() == 1
        assert not channel.is_wanted
        browser.has_drawn()
        await turns()
        assert [await browser.received.get() for _ in range(2)] == [b"one", b"three"]

    watching(scenario)


def test_a_packet_is_wanted_when_a_browser_could_draw_it():
    async def scenario(channel, browser):
        assert channel.is_wanted
        channel.publish(b"one")
        await turns()
        assert not channel.is_wanted
        browser.has_drawn()
        await turns()
        assert channel.is_wanted

    watching(scenario)


def test_no_packet_is_wanted_without_a_browser():
    assert not FrameChannel().is_wanted


def test_a_slow_browser_keeps_no_other_waiting():
    async def scenario(channel, slow, quick):
        for packet in (b"one", b"two", b"three"):
            channel.publish(packet)
            await turns()
            assert await quick.received.get() == packet
            quick.has_drawn()
            await turns()
        assert slow.received.qsize() == 1

    watching(scenario, browsers=2)


def test_a_browser_that_comes_later_gets_the_newest_at_once():
    async def run():
        channel = FrameChannel()
        channel.publish(b"old")
        channel.publish(b"new")
        browser = Browser()
        serving = asyncio.create_task(channel.serve(browser))
        assert await browser.received.get() == b"new"
        browser.leaves()
        await serving

    asyncio.run(run())


def test_packets_come_from_any_thread():
    async def scenario(channel, browser):
        thread = threading.Thread(target=channel.publish, args=(b"one",))
        thread.start()
        assert await browser.received.get() == b"one"
        thread.join()

    watching(scenario)


def test_names_cannot_be_guessed():
    assert len({FrameChannel().name for _ in range(100)}) == 100


@given(WORDS, st.binary(max_size=50), TABLES, TABLES)
def test_what_is_packed_comes_out_again(words, jpeg, first, second):
    message = pack(
        words, [float_section("a", first), jpeg_section(jpeg), float_section("b", second)]
    )
    description, sections = unpack(message)
    assert description == words
    assert sections["picture"] == jpeg
    np.testing.assert_array_equal(sections["a"], first)
    np.testing.assert_array_equal(sections["b"], second)


@given(st.binary(max_size=9), TABLES)
def test_numbers_begin_where_the_browser_can_read_them(jpeg, table):
    message = pack({"é": "ü"}, [jpeg_section(jpeg), float_section("table", table)])
    (length,) = struct.unpack_from("<I", message)
    offsets = [entry["offset"] for entry in json.loads(message[4 : 4 + length])["sections"]]
    assert all((4 + length + offset) % ALIGNMENT == 0 for offset in offsets)


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_json_knows_no_number_that_is_not_finite(number):
    with pytest.raises(ValueError, match="JSON"):
        pack({"d": number}, [])
