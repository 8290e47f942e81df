"""Several targets at once: a mixture of filters, which meet only in where they are not.

J. Ha (2008), (38): the belief is a mixture of filters with weights of their own. He has no
exclusion; here a target that is claimed keeps the particles of the others away.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import NO_OTHERS, TargetTracker
from cable_tracker.tracking.status import TrackingStatus


class TargetGroup:
    """Follow several marked targets through a sequence of frames.

    Parameters
    ----------
    starts : sequence of TargetStart
        One for each target, in the first frame.
    parameters : TargetParameters
        Of all; the seeds follow one another.
    """

    def __init__(self, starts: Sequence[TargetStart], parameters: TargetParameters) -> None:
        self._trackers = [
            TargetTracker(parameters.replaced({"seed": parameters.seed + number}))
            for number in range(len(starts))
        ]
        for tracker, start in zip(self._trackers, starts, strict=True):
            tracker.initialise(start)
        self._estimates: list[TargetEstimate] = []

    @property
    def shares(self) -> FloatArray:
        """Weights pi_m of the filters, by their presence; summing to one, or zero for none."""
        presences = np.array([estimate.presence for estimate in self._estimates])
        return presences / max(float(presences.sum()), 1e-300)

    def process(
        self, image: Image, stamp: int, motion: CameraMotion | None = None
    ) -> list[TargetEstimate]:
        """Take one frame into account; see `TargetTracker.process`.

        Raises
        ------
        FrameError
            The frame cannot be used.
        """
        before = self._estimates
        self._estimates = [
            tracker.process(image, stamp, motion, _claimed_but(before, number))
            for number, tracker in enumerate(self._trackers)
        ]
        return self._estimates


def _claimed_but(estimates: Sequence[TargetEstimate], number: int) -> FloatArray:
    """Return the states of the claimed targets other than one, shape (K, 6)."""
    states = [
        estimate.state
        for index, estimate in enumerate(estimates)
        if index != number and estimate.status is TrackingStatus.TRACKING
    ]
    return np.array(states) if states else NO_OTHERS
