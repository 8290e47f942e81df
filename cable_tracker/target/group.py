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
    """Follow several targets through a sequence of frames.

    Parameters
    ----------
    count : int
        Number of targets, at least one.
    parameters : TargetParameters
        Parameters of all trackers; the seeds follow one another.
    """

    def __init__(self, count: int, parameters: TargetParameters) -> None:
        self._parameters = parameters
        self._trackers = tuple(
            TargetTracker(_with_seed(parameters, number)) for number in range(count)
        )
        self._estimates: list[TargetEstimate] = []

    @property
    def trackers(self) -> tuple[TargetTracker, ...]:
        """The trackers, one of each target."""
        return self._trackers

    @property
    def parameters(self) -> TargetParameters:
        """The parameters in force; the seed is that of the first target."""
        return self._parameters

    @property
    def shares(self) -> FloatArray:
        """Weights pi_m of the filters, by their presence; summing to one, or zero for none."""
        presences = np.array([estimate.presence for estimate in self._estimates])
        return presences / max(float(presences.sum()), 1e-300)

    def configure(self, parameters: TargetParameters) -> None:
        """Take other parameters from now on, and keep the beliefs; see `TargetTracker`."""
        self._parameters = parameters
        for number, tracker in enumerate(self._trackers):
            tracker.configure(_with_seed(parameters, number))

    def reset(self) -> None:
        """Forget everything, marks too."""
        self._estimates = []
        for tracker in self._trackers:
            tracker.reset()

    def initialise(self, number: int, start: TargetStart) -> None:
        """Take what is marked in the next frame for a target, instead of its present one.

        Raises
        ------
        FrameError
            It lies outside the frames that came before, or is larger.
        """
        self._trackers[number].initialise(start)

    def process(
        self, image: Image, stamp: int, motion: CameraMotion | None = None
    ) -> list[TargetEstimate]:
        """Take one frame into account; see `TargetTracker.process`.

        Raises
        ------
        FrameError
            The frame cannot be used, or cannot hold what was marked in it. Nothing has changed, but
            for marks, which are dropped.
        """
        for tracker in self._trackers:
            tracker.check(image, stamp)
        before, now = self._estimates, list(self._estimates)
        for number, tracker in enumerate(self._trackers):
            if tracker.is_searching:
                # Two of them must not take the same candidate.
                others = _followed_but(now, number, self._trackers)
            else:
                others = _claimed_but(before, number)
            now[number : number + 1] = [tracker.process(image, stamp, motion, others)]
        self._estimates = now
        return now


def _with_seed(parameters: TargetParameters, number: int) -> TargetParameters:
    return parameters.replaced({"seed": parameters.seed + number}) if number else parameters


def _claimed_but(estimates: Sequence[TargetEstimate], number: int) -> FloatArray:
    """Return the states of the claimed targets other than one, shape (K, 6)."""
    states = [
        estimate.state
        for index, estimate in enumerate(estimates)
        if index != number and estimate.status is TrackingStatus.TRACKING
    ]
    return np.array(states) if states else NO_OTHERS


def _followed_but(
    estimates: Sequence[TargetEstimate], number: int, trackers: Sequence[TargetTracker]
) -> FloatArray:
    """Return the states of the targets that are followed, claimed or not, other than one."""
    states = [
        estimate.state
        for index, estimate in enumerate(estimates)
        if index != number and not trackers[index].is_searching
    ]
    return np.array(states) if states else NO_OTHERS
