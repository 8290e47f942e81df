"""`cable-tracker dds-profile`."""

from pathlib import Path


def test_the_dds_profile_is_found(command):
    assert Path(command("dds-profile").out.strip()).name == "fastdds_loopback.xml"
