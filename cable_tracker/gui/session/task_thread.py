"""A thread that runs calls from other threads, and periodic work of its own between them."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from cable_tracker.errors import GuiError

Result = TypeVar("Result")


class TaskThread:
    """Runs tasks one after the other; calls from other threads come before its own work.

    Parameters
    ----------
    begin : callable
        Called once, before anything else.
    next_time : callable
        When `work` is due, as of `time.monotonic`; None if there is nothing to do. Called with
        every change.
    work : callable
        Unit of work, called when due.
    """

    def __init__(
        self,
        name: str,
        *,
        begin: Callable[[], None],
        next_time: Callable[[], float | None],
        work: Callable[[], None],
    ) -> None:
        self._begin = begin
        self._next_time = next_time
        self._work = work
        self._tasks: deque[Callable[[], None]] = deque()
        self._condition = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    @property
    def is_closing(self) -> bool:
        """Whether it has been asked to end; long work should look at this."""
        return self._closing

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def wake(self) -> None:
        """Let it ask for the time of its work again."""
        with self._condition:
            self._condition.notify_all()

    def call(self, function: Callable[[], Result]) -> Result:
        """Run a function in the thread, and return what it returns, or raise what it raises.

        Raises
        ------
        GuiError
            The thread has ended.
        """
        future: Future[Result] = Future()

        def task() -> None:
            try:
                future.set_result(function())
            except BaseException as error:  # noqa: BLE001
                # Told to the caller that waits for the result.
                future.set_exception(error)

        with self._condition:
            if self._closing:
                raise GuiError("the recording is closed; open it again")
            self._tasks.append(task)
            self._condition.notify_all()
        return future.result()

    def close(self) -> None:
        """End it, after all that it was asked to do."""
        with self._condition:
            self._closing = True
            self._condition.notify_all()
        self._thread.join()

    def _run(self) -> None:
        try:
            self._begin()
            while (task := self._wait()) is not None:
                task()
        finally:
            # No caller may wait for ever, not even after a failure.
            with self._condition:
                self._closing = True
                left = tuple(self._tasks)
            for task in left:
                task()

    def _wait(self) -> Callable[[], None] | None:
        with self._condition:
            while not self._closing:
                if self._tasks:
                    return self._tasks.popleft()
                due = self._next_time()
                left = None if due is None else due - time.monotonic()
                if left is not None and left <= 0.0:
                    return self._work
                self._condition.wait(left)
            return None
