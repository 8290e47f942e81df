from __future__ import annotations

import os
from pathlib import Path

import pytest

from cable_tracker.errors import ResourceError
from cable_tracker.ros.process import environment
from cable_tracker.ros.process.environment import (
    MIDDLEWARE_VARIABLE,
    NEWER_PROFILE_VARIABLE,
    PROFILE_VARIABLE,
    RANGE_VARIABLE,
    check_profile,
    local_environment,
    use_local_environment,
)


@pytest.fixture(autouse=True)
def unset(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (PROFILE_VARIABLE, NEWER_PROFILE_VARIABLE, RANGE_VARIABLE, MIDDLEWARE_VARIABLE):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def mine(tmp_path: Path) -> str:
    """A profile of the user's own."""
    path = tmp_path / "mine.xml"
    path.write_text("<dds/>", encoding="utf-8")
    return str(path)


def test_traffic_is_kept_on_this_machine_by_the_shipped_profile() -> None:
    variables = local_environment()
    # LOCALHOST would open sockets beside those of the profile.
    assert variables[RANGE_VARIABLE] == "SYSTEM_DEFAULT"
    profile = Path(variables[PROFILE_VARIABLE])
    assert profile.name == "fastdds_loopback.xml"
    assert profile.is_file()
    assert PROFILE_VARIABLE not in os.environ


def test_variables_of_the_user_are_kept(monkeypatch: pytest.MonkeyPatch, mine: str) -> None:
    monkeypatch.setenv(PROFILE_VARIABLE, mine)
    monkeypatch.setenv(RANGE_VARIABLE, "SUBNET")
    variables = local_environment()
    assert variables[PROFILE_VARIABLE] == mine
    assert variables[RANGE_VARIABLE] == "SUBNET"


def test_with_a_profile_of_the_user_traffic_is_kept_here_by_its_range(
    monkeypatch: pytest.MonkeyPatch, mine: str
) -> None:
    monkeypatch.setenv(PROFILE_VARIABLE, mine)
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


@pytest.mark.parametrize("variable", [PROFILE_VARIABLE, NEWER_PROFILE_VARIABLE])
def test_a_profile_of_the_user_that_is_missing_is_an_error(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, variable: str
) -> None:
    monkeypatch.setenv(variable, str(tmp_path / "gone.xml"))
    with pytest.raises(ResourceError, match=rf"gone\.xml cannot be read; correct {variable}"):
        check_profile()
    with pytest.raises(ResourceError):
        local_environment()


def test_a_profile_that_is_no_xml_is_an_error(monkeypatch: pytest.MonkeyPatch, mine: str) -> None:
    Path(mine).write_text("<dds>", encoding="utf-8")
    monkeypatch.setenv(PROFILE_VARIABLE, mine)
    with pytest.raises(ResourceError, match="is no XML"):
        check_profile()


def test_another_middleware_does_not_care(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PROFILE_VARIABLE, "/gone.xml")
    monkeypatch.setenv(MIDDLEWARE_VARIABLE, "rmw_cyclonedds_cpp")
    check_profile()
