import os
from pathlib import Path

import pytest

from cable_tracker.printable import printable


@pytest.mark.parametrize("name", ["dive", "tauchgang_ä", "深い"])
def test_names_of_utf8_are_printed_as_they_are(name):
    assert printable(name) == printable(Path(name)) == name


def test_bytes_that_are_no_utf8_are_printed_as_numbers():
    assert printable(os.fsdecode(b"dive\xe9.mcap")) == "dive\\xe9.mcap"
