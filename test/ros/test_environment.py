from __future__ import annotations

import os
from pathlib import Path

import pytest

from cable_tracker.errors import ResourceError
from cable_tracker.ros import environment
from cable_tracker.ros.environment import (
    PROFILE_VARIABLE,
    RANGE_VARIABLE,
    local_environment,
    use_local_environment,
)


@pytest.fixture(autouse=True)
def unset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(PROFILE_VARIABLE)
    monkeypatch.delenv(RANGE_VARIABLE)


def test_traffic_is_kept_on_this_machine_by_the_shipped_profile() -> None:
    variables = local_environment()
    # LOCALHOST would open sockets beside those of the profile.
    assert variables[RANGE_VARIABLE] == "SYSTEM_DEFAULT"
    profile = Path(variables[PROFILE_VARIABLE])
    assert profile.name == "fastdds_loopback.xml"
    assert profile.is_file()
    assert PROFILE_VARIABLE not in os.environ


def test_what_the_user_has_set_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PROFILE_VARIABLE, "/mine.xml")
    monkeypatch.setenv(RANGE_VARIABLE, "SUBNET")
    variables = local_environment()
    assert variables[PROFILE_VARIABLE] == "/mine.xml"
    assert variables[RANGE_VARIABLE] == "SUBNET"


def test_with_a_profile_of_the_user_traffic_is_kept_here_by_its_range(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(PROFILE_VARIABLE, "/mine.xml")
    assert local_environment()[RANGE_VARIABLE] == "LOCALHOST"


def test_the_rest_of_the_environment_is_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOMETHING_ELSE", "7")
    assert local_environment()["SOMETHING_ELSE"] == "7"


def test_a_missing_profile_is_an_error_not_a_silent_default(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(environment, "DDS_PROFILE", Path("config") / "missing.xml")
    with pytest.raises(ResourceError, match=r"missing\.xml"):
        local_environment()


def test_this_process_can_take_it_on() -> None:
    use_local_environment()
    try:
        assert RANGE_VARIABLE in os.environ
        assert Path(os.environ[PROFILE_VARIABLE]).is_file()
    finally:
        del os.environ[RANGE_VARIABLE], os.environ[PROFILE_VARIABLE]
