"""Frames made ready for measuring as the tracker does it, of which nothing is taken out."""

from __future__ import annotations

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.picture.working_image import WorkingImage, working_image_for
from cable_tracker.cable.parameters.parameters import TrackerParameters


def plain_image(image: Image, working_width: int = 320, **changes: float) -> WorkingImage:
    """Return the working image of a frame (H, W), with changes of the tracker's parameters."""
    parameters = TrackerParameters(
        working_width=working_width, light_correction=0.0, burned_in_time=0.0
    )
    return working_image_for(image, parameters.replaced(changes))
