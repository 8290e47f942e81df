from __future__ import annotations

import pytest

from cable_tracker.ros.inputs.image_input import GapCounter, seconds_waited

NOW = 1_700_000_000_000_000_000


@pytest.mark.parametrize(
    ("received", "waited"),
    [
        (NOW - 30_000_000, 0.03),
        (NOW, 0.0),
        (0, 0.0),
        (None, 0.0),
        (NOW + 1, 0.0),
        (NOW - 61 * 10**9, 0.0),
    ],
)
def test_the_wait_is_taken_from_the_middleware_and_never_from_a_clock_that_was_set(
    received: int | None, waited: float
) -> None:
    assert seconds_waited({"received_timestamp": received}, NOW) == pytest.approx(waited)


def test_without_a_timestamp_the_message_has_come_now() -> None:
    assert seconds_waited({}, NOW) == 0.0


def missing(numbers: list[int | None], publishers: int = 1) -> list[int]:
    gaps = GapCounter()
    return [
        gaps.missing({"publication_sequence_number": number}, lambda: publishers)
        for number in numbers
    ]


def test_the_numbers_between_are_missing() -> None:
    assert missing([7, 8, 9, 12, 13, 100]) == [0, 0, 0, 2, 0, 86]


def test_a_restarted_publisher_has_lost_no_message() -> None:
    assert missing([7, 8, 1, 2, 5]) == [0, 0, 0, 0, 2]


def test_without_numbers_nothing_is_counted() -> None:
    assert missing([None, None, 4, None, 9]) == [0] * 5


def test_with_two_publishers_the_numbers_say_nothing() -> None:
    assert missing([7, 100, 8, 101], publishers=2) == [0] * 4
