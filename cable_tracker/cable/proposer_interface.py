"""What the tracker asks of a whole-image detector; the detectors themselves are in `detection`."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.model.state import POSE_SIZE


class CableProposer(Protocol):
    """Proposes cables in a frame, without a memory."""

    def propose(self, image: WorkingImage, *, is_searching: bool) -> FloatArray:
        """Return d, alpha, w, beta of cables in the frame [px, rad], best first, shape (K, 4).

        Parameters
        ----------
        image : WorkingImage
            The frame.
        is_searching : bool
            Whether it is more likely than not that the tracker follows none: a proposal may take
            more time then.
        """
        ...


class NoProposer:
    """Proposes nothing."""

    def propose(self, image: WorkingImage, *, is_searching: bool) -> FloatArray:
        """Return no cables, shape (0, 4)."""
        return np.empty((0, POSE_SIZE))
