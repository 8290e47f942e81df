import asyncio
import importlib
import threading

import pytest

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from socket_end import Browser

from cable_tracker.gui.web.frame_channel import FrameChannel


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
