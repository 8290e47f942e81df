import os
import socket
import urllib.request
from pathlib import Path

import cv2
import numpy as np
import pytest

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from cable_tracker.errors import GuiError
from cable_tracker.gui.web.server import (
    Channels,
    Listening,
    claim_port,
    listen_on,
    serve,
    typed_path,
)

from ..conftest import Running


def test_a_port_that_is_taken_is_named():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(GuiError, match=f"port {port}.*--port"):
            claim_port("127.0.0.1", port)


def test_an_address_of_another_machine_is_refused():
    with pytest.raises(GuiError, match=r"192\.0\.2\.1"):
        claim_port("192.0.2.1", 0)


def test_port_zero_is_any_free_one():
    assert claim_port("127.0.0.1", 0) > 0


def test_loopback_needs_no_token_and_others_do():
    assert listen_on("127.0.0.1", 0).token is None
    assert listen_on("0.0.0.0", 0).token


def test_a_server_without_token_is_not_given_to_others():
    with pytest.raises(GuiError, match="token"):
        serve(lambda: None, Channels(), Listening("0.0.0.0", 8080), "title")


def test_the_address_to_open_holds_the_token():
    assert Listening("127.0.0.1", 8080).url == "http://127.0.0.1:8080/"
    assert Listening("::1", 8080).url == "http://[::1]:8080/"
    url = Listening("0.0.0.0", 8080, "secret").url
    assert socket.gethostname() in url
    assert url.endswith("?token=secret")


@pytest.mark.parametrize(
    ("host", "there"),
    [("::1", "[::1]"), ("127.0.0.2", "127.0.0.2"), ("localhost", "127.0.0.1"),
     ("0.0.0.0", "127.0.0.1")],
)  # fmt: skip
def test_the_ssh_line_leads_to_where_it_listens(host, there):
    assert f"-L 8123:{there}:8123" in Listening(host, 8123).ssh_line()


def test_the_ssh_line_forwards_the_port():
    assert "-L 8123:127.0.0.1:8123" in Listening("127.0.0.1", 8123).ssh_line()


@pytest.mark.parametrize("command", ["gui", "label"])
def test_a_recording_in_a_folder_whose_name_is_no_utf8_is_shown(tmp_path, command):
    dive = tmp_path / os.fsdecode(b"caf\xe9") / "dive"
    dive.mkdir(parents=True)
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 64), np.uint8))
    (tmp_path / "0.png").rename(dive / "0.png")
    running = Running([command, dive, "--port", "0"], tmp_path)
    try:
        with urllib.request.urlopen(running.url, timeout=60) as page:
            assert b"caf\\\\xe9" in page.read()
    finally:
        running.stop()


def test_a_typed_path_may_begin_at_the_home_folder(monkeypatch):
    monkeypatch.setenv("HOME", "/home/pilot")
    assert typed_path(" ~/dive.mcap ") == Path("/home/pilot/dive.mcap")
    assert typed_path("dive.mcap") == Path("dive.mcap")


def test_the_home_folder_of_an_unknown_user_is_refused_in_words():
    with pytest.raises(GuiError, match=r"~nosuchuser/dive\.mcap: no such home folder"):
        typed_path("~nosuchuser/dive.mcap")


@pytest.mark.parametrize("text", ["", "  "])
def test_no_path_at_all_is_not_the_folder_that_the_server_was_started_in(text):
    with pytest.raises(GuiError, match="no path is given"):
        typed_path(text)
