"""SIGINT and SIGTERM end a command like an exception, also where Python drops what a signal raises.

An exception that a signal's handler raises is lost if it comes up in a destructor or in a function
that C code calls (Numba and LLVM have both). A timer looks whether it still unwinds the command and
raises it anew if it is gone.
"""

from __future__ import annotations

import signal
import sys
import weakref
from types import FrameType

CHECK_INTERVAL = 0.5
"""Time between two looks at whether the exception has been dropped [s]."""


class Stopped(BaseException):
    """SIGINT or SIGTERM has come. No `Exception`: nothing must take it for an error of its own."""

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.exit_code = 128 + signal_number


class StopSignals:
    """Handlers of SIGINT and SIGTERM that raise `Stopped` until it arrives.

    Attributes
    ----------
    is_stopping : bool
        Whether a signal has come.
    """

    def __init__(self) -> None:
        self.is_stopping = False
        self._raised: weakref.ref[Stopped] | None = None
        self._signal_number = signal.SIGTERM.value
        self._former_hook = sys.unraisablehook

    def install(self) -> None:
        """Take the signals of this process, and what it cannot raise; from the main thread."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._stop)
        signal.signal(signal.SIGALRM, self._stop_again_if_dropped)
        self._former_hook = sys.unraisablehook
        sys.unraisablehook = self._report_unraisable

    def arrived(self) -> None:
        """Note that `Stopped` has unwound the command: it is not raised again."""
        signal.setitimer(signal.ITIMER_REAL, 0)

    def _stop(self, signal_number: int, _frame: FrameType | None) -> None:
        self.is_stopping = True
        self._signal_number = signal_number
        signal.setitimer(signal.ITIMER_REAL, CHECK_INTERVAL, CHECK_INTERVAL)
        self._raise()

    def _stop_again_if_dropped(self, _number: int, _frame: FrameType | None) -> None:
        """Raise anew what is gone; what still lives is unwinding the command, or in a clean-up."""
        if self._raised is not None and self._raised() is None:
            self._raise()

    def _raise(self) -> None:
        stopped = Stopped(self._signal_number)
        self._raised = weakref.ref(stopped)
        try:
            raise stopped
        finally:
            # The traceback holds this frame: a reference from here would keep it alive for ever.
            del stopped

    def _report_unraisable(self, unraisable: sys.UnraisableHookArgs) -> None:
        """Pass on exceptions that cannot be raised, but for those that the stop itself causes.

        That is `Stopped`, which is raised anew, and the complaints of objects whose construction it
        interrupted.
        """
        if not self.is_stopping:
            self._former_hook(unraisable)
