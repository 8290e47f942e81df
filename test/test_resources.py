from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cable_tracker import resources
from cable_tracker.errors import ResourceError
from cable_tracker.resources import DDS_PROFILE, resource, share_folder


def make_share(prefix: Path) -> Path:
    folder = prefix / "share" / "cable_tracker"
    (folder / "config").mkdir(parents=True)
    (folder / "package.xml").write_text("<package/>")
    return folder


@pytest.fixture(autouse=True)
def no_workspace(monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)


@pytest.fixture
def installed(monkeypatch, tmp_path) -> Path:
    """Act as if the package lay in an environment without its source."""
    monkeypatch.setattr(resources, "__file__", str(tmp_path / "lib" / "cable_tracker" / "x.py"))
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "environment"))
    return tmp_path


def test_in_a_checkout_it_is_the_checkout():
    assert share_folder() == Path(__file__).resolve().parents[1]
    assert resource(DDS_PROFILE).read_text(encoding="utf-8").startswith("<?xml")


def test_in_an_environment_it_is_its_share_folder(installed):
    folder = make_share(installed / "environment")
    assert share_folder() == folder


def test_a_sourced_workspace_goes_first_and_the_first_of_several(monkeypatch, tmp_path):
    second = make_share(tmp_path / "b")
    prefixes = f"{tmp_path / 'a'}:{tmp_path / 'b'}:"
    monkeypatch.setenv("AMENT_PREFIX_PATH", prefixes)
    assert share_folder() == second
    first = make_share(tmp_path / "a")
    assert share_folder() == first


def test_a_folder_without_config_does_not_count(installed):
    folder = make_share(installed / "environment")
    (folder / "config").rmdir()
    with pytest.raises(ResourceError, match="install the package anew") as caught:
        share_folder()
    assert "\n" not in str(caught.value)


def test_a_file_that_is_missing_is_named(installed):
    make_share(installed / "environment")
    with pytest.raises(ResourceError, match=r"fastdds_loopback\.xml is missing"):
        resource(DDS_PROFILE)
