"""What the filters may be told about the camera's own motion between two frames."""

from __future__ import annotations

from typing import Protocol

from cable_tracker.arrays import FloatArray


class MotionAid(Protocol):
    """How the cable moves in the image from the frame before to this one, as odometry has it."""

    def moved(self, states: FloatArray) -> FloatArray:
        """Return states (N, 8) of the frame before as they are in this frame, angles not wrapped.

        Their rates become those of this motion.
        """
        ...

    def scales(self) -> FloatArray:
        """Return the scales of the diffusion over what is still unknown, shape (8,)."""
        ...
