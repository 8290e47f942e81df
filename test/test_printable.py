import codecs
import os
from pathlib import Path

import pytest

from cable_tracker.printable import encodable, printable


@pytest.mark.parametrize("name", ["dive", "tauchgang_ä", "深い"])
def test_names_of_utf8_are_printed_as_they_are(name):
    assert printable(name) == printable(Path(name)) == name


def test_bytes_that_are_no_utf8_are_printed_as_numbers():
    assert printable(os.fsdecode(b"dive\xe9.mcap")) == "dive\\xe9.mcap"


def test_bytes_of_file_names_survive_encoding():
    codecs.register_error("test_encodable", encodable)
    text = os.fsdecode(b"dive\xe9") + " \u03b1 \ud83d"
    assert text.encode("latin-1", "test_encodable") == b"dive\xe9 \\u03b1 \\ud83d"
    with pytest.raises(UnicodeDecodeError):
        b"\xe9".decode("ascii", "test_encodable")
