"""What all sessions share; numbers stand for snapshots."""

from stub_session import StubSession


def test_listeners_are_told_until_they_leave_and_the_newest_is_kept():
    session, heard, others = StubSession(), [], []
    end = session.listen(heard.append)
    session.listen(others.append)
    assert session.latest is None
    session.tell(1)
    end()
    end()
    session.tell(2)
    assert (heard, others, session.latest) == ([1], [1, 2], 2)


def test_a_listener_may_leave_while_it_is_told():
    session, heard = StubSession(), []

    def hear_once(number):
        heard.append(number)
        end()

    end = session.listen(hear_once)
    session.tell(1)
    session.tell(2)
    assert heard == [1]
