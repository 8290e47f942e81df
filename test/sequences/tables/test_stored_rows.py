import tracemalloc

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import OutputError
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.sequences.tables.stored_rows import StoredRows

ends = st.none() | st.integers(-12, 12)


@given(
    st.integers(0, 20), st.integers(1, 6), ends, ends, st.integers(-3, 3).filter(lambda step: step)
)
def test_rows_are_as_in_a_list(tmp_path_factory, count, block, start, stop, step):
    rows = StoredRows(tmp_path_factory.getbasetemp(), block)
    for number in range(count):
        rows.append(EstimateRow(number, number, "LOST"))
    expected = [EstimateRow(number, number, "LOST") for number in range(count)]
    assert list(rows) == expected
    assert len(rows) == count
    assert rows[start:stop:step] == expected[start:stop:step]
    assert [rows[number] for number in range(-count, count)] == expected * 2
    with pytest.raises(IndexError):
        rows[count]


def test_rows_can_be_added_while_others_are_read(tmp_path):
    rows = StoredRows(tmp_path, 2)
    for number in range(5):
        rows.append(number)
    reading = iter(rows)
    assert next(reading) == 0
    rows.append(5)
    assert list(rows) == list(range(6))
    assert next(reading) == 1


def test_more_rows_take_no_more_memory_and_leave_no_file(tmp_path):
    def kept(count):
        tracemalloc.start()
        rows = StoredRows(tmp_path, 50)
        for number in range(count):
            rows.append(EstimateRow(number, number, "LOST", sigma=(1.0 * number, 1.0, 1.0, 1.0)))
        size = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        assert len(rows) == count
        return size

    def least_kept(count):
        # What other threads, and what happens once, need meanwhile does not count.
        return min(kept(count) for _ in range(3))

    assert least_kept(5000) - least_kept(500) < 9000
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_does_not_take_rows_is_reported(tmp_path):
    rows = StoredRows(tmp_path / "none", 1)
    with pytest.raises(OutputError, match="none"):
        rows.append(1)
