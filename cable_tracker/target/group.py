"""Several targets at once: one filter each, kept apart by mutual exclusion.

J. Ha (2008), (38): the belief is a mixture of filters with weights of their own. He has no
exclusion; here a target that is claimed keeps the particles of the others away.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.target.model.camera_motion import CameraMotion, usable_motion
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import NO_OTHERS, FrameTask, TargetTracker
from cable_tracker.tracking.status import TrackingStatus

SEEDS = 2**31
"""Number of seeds; after the last one comes the first."""


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

    def configure(self, parameters: TargetParameters) -> None:
        """Use other parameters from now on, and keep the beliefs; see `TargetTracker`."""
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

        Targets that are marked in it come first, those that are searched for last: each keeps away
        from what the others have taken. Of two that are followed, neither has precedence: they keep
        away from where the other was claimed in the frame before.

        Raises
        ------
        FrameError
            The frame cannot be used, or cannot hold what was marked in it. Nothing has changed, but
            for a mark that the frame cannot hold: it is dropped.
        """
        tasks = [tracker.task_for(image, stamp) for tracker in self._trackers]
        before = self._claimed_before(motion, (image.shape[1], image.shape[0]))
        now: dict[int, TargetEstimate] = {}
        for number in sorted(range(len(tasks)), key=tasks.__getitem__):
            if tasks[number] is FrameTask.SEARCH:
                # Two of them must not take the same candidate, claimed or not.
                others = _stacked(
                    estimate.state
                    for each, estimate in now.items()
                    if not self._trackers[each].is_searching
                )
            else:
                started = {each: now[each] for each in now if tasks[each] is FrameTask.START}
                earlier = {each: before[each] for each in before if each not in started}
                known = earlier | _claimed(started)
                others = _stacked(known[each] for each in known if each != number)
            now[number] = self._trackers[number].process(image, stamp, motion, others)
        self._estimates = [now[number] for number in range(len(tasks))]
        return self._estimates

    def _claimed_before(
        self, motion: CameraMotion | None, image_size: tuple[int, int]
    ) -> dict[int, FloatArray]:
        """Return the states claimed in the frame before, moved with the camera, by their numbers.

        Otherwise a target that comes, as the camera pans, to where another one was would be kept
        from its own place.
        """
        claimed = _claimed(dict(enumerate(self._estimates)))
        motion = usable_motion(motion, image_size)
        if motion is None:
            return claimed
        return dict(zip(claimed, motion.moved(_stacked(claimed.values()), 1.0), strict=True))


def _with_seed(parameters: TargetParameters, number: int) -> TargetParameters:
    if number == 0:
        return parameters
    return parameters.replaced({"seed": (parameters.seed + number) % SEEDS})


def _claimed(estimates: Mapping[int, TargetEstimate]) -> dict[int, FloatArray]:
    """Return the states of the targets that are claimed, by their numbers."""
    return {
        number: estimate.state
        for number, estimate in estimates.items()
        if estimate.status is TrackingStatus.TRACKING
    }


def _stacked(states: Iterable[FloatArray]) -> FloatArray:
    """Return states of targets, each of shape (6,), as rows of one array (K, 6)."""
    rows = list(states)
    return np.array(rows) if rows else NO_OTHERS
