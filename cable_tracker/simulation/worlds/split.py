"""Two sets of worlds that share nothing: one to tune on, one to report on."""

from __future__ import annotations

from enum import Enum


class Split(str, Enum):
    """Purpose of a world."""

    TUNE = "tune"
    """Constants and tables are chosen on it."""

    REPORT = "report"
    """Nothing is chosen on it: figures in reports come from it."""

    @property
    def number(self) -> int:
        """Return what keeps the random numbers of the two apart."""
        return 1 if self is Split.TUNE else 2
