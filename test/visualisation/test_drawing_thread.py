from threading import Event, current_thread

import pytest

from cable_tracker.errors import OutputError
from cable_tracker.visualisation.drawing_thread import CAPACITY, DrawingThread


def test_jobs_are_done_in_order_in_another_thread():
    done = []
    with DrawingThread() as thread:
        for number in range(20):
            thread.do(lambda number=number: done.append((number, current_thread().name)))
    assert done == [(number, "drawing") for number in range(20)]


def test_no_more_jobs_wait_than_the_capacity():
    begun, go_on = Event(), Event()

    def hold():
        begun.set()
        assert go_on.wait(300)

    with DrawingThread() as thread:
        thread.do(hold)
        assert begun.wait(300)
        for _ in range(CAPACITY):
            thread.do(lambda: None)
        assert thread._jobs.full()
        go_on.set()


def test_an_error_is_told_at_a_later_job_or_at_the_end():
    def fail():
        raise OutputError("the disk is full")

    done = []
    with pytest.raises(OutputError, match="disk is full"), DrawingThread() as thread:
        thread.do(fail)
    with pytest.raises(OutputError, match="disk is full"), DrawingThread() as thread:
        thread.do(fail)
        for _ in range(1000):
            thread.do(lambda: done.append(1))
    assert not done


def test_after_an_exception_waiting_jobs_are_left_out():
    begun, go_on, done = Event(), Event(), []

    def hold():
        begun.set()
        assert go_on.wait(300)

    with pytest.raises(KeyboardInterrupt), DrawingThread() as thread:
        thread.do(hold)
        thread.do(lambda: done.append(1))
        assert begun.wait(300)
        thread._abandoned = True
        go_on.set()
        raise KeyboardInterrupt
    assert done == []
