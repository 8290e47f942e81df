from itertools import accumulate
from types import SimpleNamespace

import pytest

from cable_tracker.sequences.bags.stream_gaps import H264Gaps, TimeGaps


def gaps(finder, packets):
    """Numbers of the packets before which others are missing."""
    return [number for number, each in enumerate(packets) if finder.is_after_gap(each)]


def at(stamp=0, count=0, data=b""):
    return SimpleNamespace(stamp=stamp, count=count, data=data)


@pytest.mark.parametrize(
    ("steps", "found"),
    [
        ([40] * 5 + [80] + [40] * 5, [6]),
        ([40, 44, 36, 41, 58, 40, 44], []),
        ([40] * 5 + [80] * 5, [6]),
        ([40, 80, 40, 40], []),
        ([40] * 5 + [-1000, 40, 40], []),
    ],
    ids=["one is missing", "jitter", "another rate", "too few", "the clock jumps back"],
)
def test_a_step_out_of_the_ordinary_is_a_gap(steps, found):
    stamps = accumulate(steps, initial=1000)
    assert gaps(TimeGaps(), [at(stamp) for stamp in stamps]) == found


def test_a_sender_that_counts_is_believed_more_than_stamps():
    late = [at(1000 * k + 5000 * (k > 6), count=k) for k in range(10)]
    assert gaps(TimeGaps(), late) == []
    missing = [at(1000 * k, count=k + (k > 6)) for k in range(10)]
    assert gaps(TimeGaps(), missing) == [7]


def slice_of(number, *, kind=1, is_reference=True):
    """Return a slice of H.264: first_mb 0, kind 0, parameter set 0, frame_num in 4 bits."""
    header = kind | (0x60 if is_reference else 0)
    return b"\x00\x00\x01" + bytes([header, 0b11100000 | number << 1, 0x80])


def parameter_set(*, may_skip=False, profile=66):
    """Return a sequence parameter set; frame_num has 4 bits, order of kind 2, one reference."""
    high = "0101100" if profile == 100 else ""
    bits = f"{profile:08b}" + "0" * 8 + "00001010" + "1" + high + "1" + "011" + "010"
    bits = (bits + ("1" if may_skip else "0") + "1").ljust(80, "0")
    return b"\x00\x00\x01\x67" + int(bits, 2).to_bytes(10, "big")


@pytest.mark.parametrize("profile", [66, 100])
def test_numbers_of_pictures_that_others_need_go_on_by_one(profile):
    first = at(data=parameter_set(profile=profile) + slice_of(0, kind=5))
    whole = [first, *(at(data=slice_of(k % 16)) for k in range(1, 40))]
    assert gaps(H264Gaps(), whole) == []
    assert gaps(H264Gaps(), whole[:7] + whole[8:]) == [7]


def test_a_picture_that_no_other_needs_may_be_missing():
    whole = [at(data=parameter_set() + slice_of(0, kind=5))]
    for k in range(1, 8):
        whole += [at(data=slice_of(k, is_reference=False)), at(data=slice_of(k))]
    assert gaps(H264Gaps(), whole) == []
    assert gaps(H264Gaps(), whole[:5] + whole[6:]) == []


def test_skipped_numbers_are_no_gap_where_the_stream_allows_them():
    numbers = [at(data=slice_of(k)) for k in (1, 4, 5, 9)]
    assert gaps(H264Gaps(), [at(data=parameter_set(may_skip=True)), *numbers]) == []


@pytest.mark.parametrize("data", [b"", b"\x00\x00\x01", b"\x00\x00\x01\x67", slice_of(3)])
def test_a_stream_that_is_not_understood_has_no_gaps(data):
    assert gaps(H264Gaps(), [at(data=data)] * 5) == []
