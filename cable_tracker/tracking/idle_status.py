"""Statuses of a tracker that takes no frames, beside those of `TrackingStatus`."""

from __future__ import annotations

from typing import Final

WARMING_UP: Final = "WARMING UP"
"""Its functions are being compiled; frames that come are not used."""

DISABLED: Final = "DISABLED"
"""The user has switched it off."""
