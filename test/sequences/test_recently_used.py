import pytest

from cable_tracker.sequences.recently_used import RecentlyUsed


@pytest.fixture
def kept():
    return RecentlyUsed(30)


def test_a_missing_key_gives_none(kept):
    assert kept.get(1) is None


def test_the_least_recently_used_entry_is_dropped(kept):
    for number in (1, 2, 3):
        kept.put(number, str(number), 10)
    assert kept.get(1) == "1"
    kept.put(4, "4", 10)
    assert kept.get(2) is None
    assert [kept.get(number) for number in (1, 3, 4)] == ["1", "3", "4"]


def test_an_item_that_comes_again_takes_no_more_room(kept):
    kept.put(1, "one", 10)
    for _ in range(5):
        kept.put(2, "two", 10)
    kept.put(3, "three", 10)
    assert [kept.get(number) for number in (1, 2, 3)] == ["one", "two", "three"]


def test_the_newest_is_kept_however_large_it_is(kept):
    kept.put(1, "small", 1)
    kept.put(2, "large", 1000)
    assert kept.get(1) is None
    assert kept.get(2) == "large"
