import pytest

from cable_tracker.commands.options.common import parse_size
from cable_tracker.errors import ParameterError


@pytest.mark.parametrize(
    ("text", "size"), [("320x240", (320, 240)), ("64X48", (64, 48)), ("1x1", (1, 1))]
)
def test_a_size_is_read_as_width_and_height(text, size):
    assert parse_size(text) == size


@pytest.mark.parametrize("text", ["", "x", "3x", "x3", "3.5x4", "3x4x5", "²x3"])
def test_a_malformed_size_is_refused(text):
    with pytest.raises(ParameterError, match="320x240"):
        parse_size(text)
