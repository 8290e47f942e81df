"""What the tracker says about one frame."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.state import CableState


class TrackingStatus(str, Enum):
    """How far the tracker may be trusted."""

    INITIALISING = "INITIALISING"
    """No cable found yet: the particles are spread out and search."""

    TRACKING = "TRACKING"
    """A cable is claimed; only now do state and covariance mean anything to a controller."""

    LOST = "LOST"
    """There was a cable, and the image does not support it any more."""


@dataclass(frozen=True, slots=True, eq=False)
class CableEstimate:
    """The posterior over the cable after one frame.

    Attributes
    ----------
    stamp : int
        Time of the frame [ns].
    status : TrackingStatus
        Whether a cable is claimed.
    state : CableState
        Weighted mean of the particles (MMSE) [px, rad, per second]. Meant for the controller only
        while the status is TRACKING.
    covariance : FloatArray
        Weighted covariance of the particles about the mean, shape (6, 6), columns of `StateColumn`.
    effective_sample_size : float
        N_eff, between 1 and N, before resampling.
    evidence : float
        How clearly the image shows the two borders of the estimate: mean response per point of the
        weaker border, in units of the frame's robust scale. Zero when the borders disagree.
    image_size : (int, int)
        Width and height of the frame [px].
    event : str
        Why the tracker started anew with this frame; empty on ordinary frames.
    """

    stamp: int
    status: TrackingStatus
    state: CableState
    covariance: FloatArray
    effective_sample_size: float
    evidence: float
    image_size: tuple[int, int]
    event: str = ""

    def standard_deviations(self) -> FloatArray:
        """Return the square roots of the covariance's diagonal, shape (6,)."""
        variances: FloatArray = np.maximum(np.diag(self.covariance), 0.0)
        return np.sqrt(variances)
