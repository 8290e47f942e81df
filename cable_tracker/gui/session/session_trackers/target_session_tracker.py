"""The tracker of a target in a recording session."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.errors import ParameterError
from cable_tracker.gui.session.session import AnyStart
from cable_tracker.gui.session.session_trackers.session_tracker import SessionTracker
from cable_tracker.gui.session.snapshot import TargetSnapshot
from cable_tracker.gui.subject.subject import TARGET
from cable_tracker.metric.recorded.recorded_instruments import RecordedInstruments
from cable_tracker.metric.targets.target_instrument_fusion import TargetInstrumentFusion
from cable_tracker.offline.target_table import TargetRow, row_of
from cable_tracker.offline.track_target import follow_picture
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.encodings import decode_bgr_levels
from cable_tracker.sequences.frame import CompressedImage, Frame, RawImage
from cable_tracker.sequences.labels.target_labels import BoxTruth
from cable_tracker.target.model.start import StartText, TargetStart, parse_start_text
from cable_tracker.target.model.state import LOG_SCALE
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker, warm_up_target
from cable_tracker.tracking.parameter_table import ParameterSet


class TargetSessionTracker(SessionTracker):
    """Follows a target.

    Parameters
    ----------
    init : str
        Initialisation: `wait` for a mark, `detect`, or `x0,y0,x1,y1` [px].
    truth : BoxTruth
        True boxes of the labelled frames [px].
    instruments : RecordedInstruments or None
        The recording's instruments, which tell how the camera turned; None: it has none.

    Raises
    ------
    ParameterError
        There is no such start.
    """

    subject = TARGET
    _tracker: TargetTracker
    _parameters: TargetParameters
    _instruments: RecordedInstruments[TargetInstrumentFusion] | None

    def __init__(
        self,
        init: str,
        parameters: TargetParameters,
        truth: BoxTruth,
        instruments: RecordedInstruments[TargetInstrumentFusion] | None,
    ) -> None:
        self._truth = truth
        self._start: StartText = parse_start_text(init)
        if len(self._start.boxes) > 1:
            raise ParameterError("init: the window follows one target; mark only one")
        super().__init__(parameters, TargetTracker(self._with_detector(parameters)), instruments)

    def warm_up(self) -> None:
        """Compile and load what frames will need."""
        warm_up_target(self._with_detector(self._parameters))

    def _with_detector(self, parameters: TargetParameters) -> TargetParameters:
        """Return parameters with a detector where the start needs one; the user's stay as given."""
        return parameters.with_detector() if self._start.detects else parameters

    def _begin_tracker(self) -> None:
        for start in self._start.boxes:
            self._tracker.initialise(start)

    def initialise(self, start: AnyStart) -> None:
        """Follow what is marked in the next frame."""
        assert isinstance(start, TargetStart), "a target is marked with a box or an outline"
        height, width = self._decoded.shape[:2]
        start.check((width, height))
        self._tracker.initialise(start)

    def _configure_tracker(self, parameters: ParameterSet) -> None:
        assert isinstance(parameters, TargetParameters)
        self._tracker.configure(self._with_detector(parameters))

    def _decode(self, image: RawImage | CompressedImage) -> Image:
        return decode_bgr_levels(image)

    def follow(self, frame: Frame, number: int) -> TargetSnapshot:
        """Track a frame."""
        estimate, ms, _ = follow_picture(frame, self._decoded, self._tracker, self._instruments)
        return replace(
            self.show(frame, number, estimate.status.value),
            row=row_of(frame, estimate, ms),
            outline=estimate.outline if estimate.is_claimed else np.empty((0, 2)),
            cloud=_poses_of(self._tracker.particles),
            score=float(estimate.score),
        )

    def show(self, frame: Frame, number: int, status: str, reason: str = "") -> TargetSnapshot:
        """Return a snapshot of a frame that is not tracked."""
        return TargetSnapshot(
            number=number,
            frame=frame.index,
            image=self._shown,
            row=TargetRow(frame.index, frame.stamp, status, event=reason),
            truth=self._truth.box(frame),
        )


def _poses_of(particles: Particles | None) -> FloatArray | None:
    """Return the columns of `TargetClaim.state` and the weight of each particle, (N, 7)."""
    if particles is None:
        return None
    cloud = np.column_stack((particles.states, particles.weights))
    cloud[:, LOG_SCALE] = np.exp(cloud[:, LOG_SCALE])
    return cloud
