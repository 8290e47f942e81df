from pathlib import Path

import pytest

from cable_tracker.errors import GuiError
from cable_tracker.gui.web.typed_paths import typed_path


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
