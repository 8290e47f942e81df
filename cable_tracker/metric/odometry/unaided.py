"""Why a filter is not told of the vehicle's motion."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Unaided:
    """Stands for a motion that is unknown, or that the filter is not told of.

    Attributes
    ----------
    why : str
        In words.
    disagrees : bool
        Whether odometry has come and contradicts what the camera sees.
    """

    why: str
    disagrees: bool = False


SWITCHED_OFF = Unaided("the parameter motion_aid is false")
NO_FRAME = Unaided("no frame has come")
FIRST_FRAME = Unaided("no frame has come before")
NOT_PROVED = Unaided("odometry has not yet been seen to agree with what the camera sees")
CABLE_DISAGREES = Unaided("odometry disagrees with what the camera sees", disagrees=True)
TEXTURE_DISAGREES = Unaided(
    "odometry disagrees with how the sea bed moves in the image", disagrees=True
)
