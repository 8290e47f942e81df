"""Statuses that are no belief of a tracker, beside those of `TrackingStatus`."""

from __future__ import annotations

from typing import Final

REFUSED: Final = "REFUSED"
"""The frame could not be used."""

WARMING_UP: Final = "WARMING UP"
"""Its functions are being compiled; frames that come are not used."""

DISABLED: Final = "DISABLED"
"""The user has switched it off."""
