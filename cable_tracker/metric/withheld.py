"""Reasons for missing metres: each with a name, and words for a person."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Reason(str, Enum):
    """Reason for missing metres."""

    NOT_TRACKING = "no cable is claimed"
    NO_CALIBRATION = "no camera calibration"
    BAD_CALIBRATION = "unusable camera calibration"
    OTHER_IMAGE_SIZE = "calibration of another image size"
    NO_ALTITUDE = "no altitude"
    BAD_ALTITUDE = "unusable altitude"
    STALE_ALTITUDE = "stale altitude"
    BAD_ATTITUDE = "unusable attitude"
    STALE_ATTITUDE = "stale attitude"
    CAMERA_LOOKS_UP = "camera does not look down"
    CAMERA_TOO_LOW = "camera not above the cable"
    OUT_OF_VIEW = "centreline outside the image"
    HORIZON = "centreline at the horizon"
    ACROSS = "cable runs across"
    NO_TARGET = "no target is claimed"
    BEYOND_LENS = "target beyond the lens"
    RANGE_UNKNOWN = "range not known"
    NOT_COMPUTED = "the computation failed"


@dataclass(frozen=True, slots=True)
class Withheld:
    """Stands for a result that would not be true.

    Attributes
    ----------
    reason : Reason
        For programs.
    detail : str
        For people: what was seen, and what to do.
    """

    reason: Reason
    detail: str

    def __str__(self) -> str:
        return f"{self.reason.value}: {self.detail}"


UNCLAIMED = (Reason.NOT_TRACKING, Reason.NO_TARGET)
"""Reasons that the status says already."""


def newly_withheld(before: object, now: object) -> Withheld | None:
    """Return why there is no result, where that is news for a person.

    None where there is a result, where nothing is claimed, and where the frame before had the same
    reason.

    Parameters
    ----------
    before, now : object
        Results of the frame before and of this one; one that is withheld is a `Withheld`.
    """
    if not isinstance(now, Withheld) or now.reason in UNCLAIMED:
        return None
    if isinstance(before, Withheld) and before.reason is now.reason:
        return None
    return now
