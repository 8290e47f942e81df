import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from cable_tracker.gui.web.packet import ALIGNMENT, float_section, jpeg_section, pack

from ..conftest import unpack

TABLES = arrays.arrays(
    np.float32,
    st.tuples(st.integers(0, 7), st.integers(1, 5)),
    elements=st.floats(-1e6, 1e6, width=32),
)
WORDS = st.dictionaries(
    st.text(max_size=8).filter(lambda key: key != "sections"),
    st.one_of(st.integers(-(2**53), 2**53), st.text(max_size=20), st.booleans(), st.none()),
)


@given(WORDS, st.binary(max_size=50), TABLES, TABLES)
def test_what_is_packed_comes_out_again(words, jpeg, first, second):
    message = pack(
        words, [float_section("a", first), jpeg_section(jpeg), float_section("b", second)]
    )
    description, sections = unpack(message)
    assert description == words
    assert sections["picture"] == jpeg
    np.testing.assert_array_equal(sections["a"], first)
    np.testing.assert_array_equal(sections["b"], second)


@given(st.binary(max_size=9), TABLES)
def test_numbers_begin_where_the_browser_can_read_them(jpeg, table):
    message = pack({"é": "ü"}, [jpeg_section(jpeg), float_section("table", table)])
    (length,) = struct.unpack_from("<I", message)
    offsets = [entry["offset"] for entry in json.loads(message[4 : 4 + length])["sections"]]
    assert all((4 + length + offset) % ALIGNMENT == 0 for offset in offsets)


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_json_knows_no_number_that_is_not_finite(number):
    with pytest.raises(ValueError, match="JSON"):
        pack({"d": number}, [])
