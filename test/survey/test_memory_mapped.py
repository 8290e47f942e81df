import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import OutputError
from cable_tracker.survey.memory_mapped import (
    Disk,
    Unwrapping,
    interpolated_locally,
    running_sum,
    surroundings,
)

numbers = st.floats(-1e6, 1e6)
blocks = st.integers(1, 9)


def parts(count, block):
    return [slice(first, first + block) for first in range(0, count, block)]


@given(st.integers(0, 40), blocks)
def test_blocks_cover_all_rows_in_both_directions(count, block):
    disk = Disk(block=block)
    rows = np.arange(count)
    assert [k for part in disk.blocks(count) for k in rows[part]] == rows.tolist()
    back = [rows[part].tolist() for part in disk.blocks_reversed(count)]
    assert [k for part in back[::-1] for k in part] == rows.tolist()
    assert all(0 < len(part) <= block for part in back)


@given(st.lists(numbers, max_size=40), blocks)
def test_what_grows_holds_what_was_added(values, block):
    disk = Disk(block=block)
    growing, whole = disk.growing(np.float64), disk.growing(np.dtype([("a", "f8")]))
    for part in parts(len(values), block):
        growing.extend(np.array(values[part]))
    for value in values:
        whole.append()["a"] = value
    assert growing.rows().tolist() == values
    assert whole.rows()["a"].tolist() == values
    assert len(growing) == len(whole) == len(values)


def test_what_is_written_into_rows_stays_when_more_are_added():
    growing = Disk(block=4).growing(np.int64)
    growing.extend(np.arange(4))
    growing.extend(np.arange(3))
    growing.rows()[1] = 17
    growing.extend(np.arange(4))
    assert growing.rows().tolist() == [0, 17, 2, 3, 0, 1, 2, 0, 1, 2, 3]


def test_what_was_let_go_of_is_read_again():
    disk = Disk(block=10)
    values = disk.array((5000, 3))
    values[...] = np.arange(15_000).reshape(5000, 3)
    disk.release_pages()
    assert (values == np.arange(15_000).reshape(5000, 3)).all()


def test_arrays_begin_with_zeros_and_leave_no_file(tmp_path):
    disk = Disk(tmp_path, block=10)
    assert not disk.array((100, 2), np.int64).any()
    assert disk.array(0).shape == (0,)
    assert list(tmp_path.iterdir()) == []


def test_a_disk_without_room_is_told_in_words(monkeypatch, tmp_path, full_disk):
    monkeypatch.setattr("os.posix_fallocate", full_disk)
    with pytest.raises(OutputError, match="No space left"):
        Disk(tmp_path, block=1).array(100)


def test_a_folder_that_is_not_there_is_told_in_words(tmp_path):
    growing = Disk(tmp_path / "none", block=1).growing(np.float64)
    growing.extend(np.zeros(1))
    with pytest.raises(OutputError, match="none"):
        growing.extend(np.zeros(1))


@given(st.lists(numbers, min_size=1, max_size=40), blocks)
def test_the_median_is_that_of_numpy(values, block):
    array = np.array(values)
    kept = array >= np.median(array)
    found = Disk(block=block).median(array, lambda part: kept[part])
    assert found == np.median(array[kept])


@given(st.lists(numbers, min_size=2, max_size=40, unique=True), st.lists(numbers, max_size=20))
def test_interpolation_reads_only_what_lies_around(places, wanted):
    places, wanted = np.sort(places), np.array(wanted)
    values = np.sin(places)
    found = interpolated_locally(wanted, places, values)
    assert found.tolist() == np.interp(wanted, places, values).tolist()
    if len(wanted):
        around = places[surroundings(places, wanted[:1])]
        assert len(around) <= 3


@given(st.lists(numbers, max_size=40), blocks)
def test_sums_go_on_from_one_block_to_the_next(steps, block):
    sums, before = [], 0.0
    for part in parts(len(steps), block):
        some = running_sum(np.array(steps[part]), before)
        before = some[-1]
        sums += some.tolist()
    assert sums == np.cumsum(steps).tolist()


@given(st.lists(st.floats(-50.0, 50.0), max_size=40), blocks)
def test_angles_go_on_as_those_of_numpy(angles, block):
    unwrapping, found = Unwrapping(), []
    for part in parts(len(angles), block):
        found += unwrapping.apply(np.array(angles[part])).tolist()
    assert found == np.unwrap(np.array(angles)).tolist()


def test_half_a_turn_is_taken_as_numpy_takes_it():
    angles = np.array([0.0, math.pi, 0.0, -math.pi, math.pi])
    assert Unwrapping().apply(angles).tolist() == np.unwrap(angles).tolist()
