from cable_tracker.gui.session.snapshot_feed import SnapshotFeed


class Counter(SnapshotFeed):
    """Numbers stand for snapshots."""

    def tell(self, number):
        self._publish(number)


def test_listeners_are_told_until_they_leave_and_the_newest_is_kept():
    feed, heard, others = Counter(), [], []
    end = feed.listen(heard.append)
    feed.listen(others.append)
    assert feed.latest is None
    feed.tell(1)
    end()
    end()
    feed.tell(2)
    assert (heard, others, feed.latest) == ([1], [1, 2], 2)


def test_a_listener_may_leave_while_it_is_told():
    feed, heard = Counter(), []

    def hear_once(number):
        heard.append(number)
        end()

    end = feed.listen(hear_once)
    feed.tell(1)
    feed.tell(2)
    assert heard == [1]
