"""Pictures drawn and videos encoded beside the tracking, in a thread of their own."""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from threading import Thread
from types import TracebackType
from typing import Self, TypeAlias

Job: TypeAlias = Callable[[], None]

CAPACITY = 8
"""Jobs that may wait, so that memory stays bounded: each holds a frame."""


class DrawingThread:
    """Does jobs one after the other in a thread of its own. A context manager.

    When the block ends well, all jobs have been done. When it ends with an exception, those that
    wait are left out.
    """

    def __init__(self) -> None:
        self._jobs: Queue[Job | None] = Queue(CAPACITY)
        self._thread = Thread(target=self._work, name="drawing", daemon=True)
        self._error: BaseException | None = None
        self._abandoned = False

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._abandoned = error is not None
        self._jobs.put(None)
        self._thread.join()
        if error is None:
            self._raise_error()

    def do(self, job: Job) -> None:
        """Have a job done after those before it.

        Raises
        ------
        Exception
            What an earlier job raised.
        """
        self._raise_error()
        self._jobs.put(job)

    def _raise_error(self) -> None:
        if self._error is not None:
            raise self._error

    def _work(self) -> None:
        # Jobs are taken to the end in any case, so that `do` never waits for ever.
        while (job := self._jobs.get()) is not None:
            if self._abandoned or self._error is not None:
                continue
            try:
                job()
            # Told in the thread that gave the job.
            except BaseException as error:  # noqa: BLE001
                self._error = error
