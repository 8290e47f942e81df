"""Results of a tracker for one frame, as the window and its history get them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
from cable_tracker.target.model.estimate import Box


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """Results of a filter for one frame, whatever it tracks.

    Attributes
    ----------
    number : int
        Counts the snapshots of a session; each has a larger one than those before.
    frame : int or None
        Number of the frame in its recording; None of a live camera.
    stamp : int
        Time of the frame [ns].
    image : Image
        The frame, uint8: grey, shape (H, W), of a target also blue-green-red, shape (H, W, 3).
    status : str
        Status as in diagnostics: TRACKING, LOST, INITIALISING, REFUSED, DISABLED, ...
    reason : str
        Reason of a refused frame or of a restart; empty on ordinary frames.
    presence : float or None
        Probability that a cable or a target is in view.
    n_eff, ms : float or None
        As in `estimates.csv`; None if not known.
    """

    number: int
    frame: int | None
    stamp: int
    image: Image
    status: str
    reason: str = ""
    presence: float | None = None
    n_eff: float | None = None
    ms: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class CableSnapshot(Snapshot):
    """Results of the filter of a cable for one frame.

    Attributes
    ----------
    state : CableState or None
        The estimate [px, rad, per second]; None while no cable is claimed.
    sigma : FloatArray or None
        Standard deviations of `state`, columns of `StateColumn`, shape (8,), or (4,) where those of
        the rates are not known; None while no cable is claimed.
    cloud : FloatArray or None
        Particles and their weights, shape (N, 9): columns of `StateColumn`, then the weight. None
        if there are none.
    hypotheses : tuple of Hypothesis
        Hypotheses, as `CableEstimate` has them; empty if they are not known.
    hypothesis_count : int or None
        Number of hypotheses where they are not known themselves; None otherwise.
    evidence : float or None
        As in `estimates.csv`; None if not known.
    truth : CableState or None
        True state of the cable, if the frame is labelled.
    metres : CrossTrack, Withheld or None
        The cable beside the vehicle, or why it is not known there; None where there are no
        instruments.
    """

    state: CableState | None = None
    sigma: FloatArray | None = None
    cloud: FloatArray | None = None
    hypotheses: tuple[Hypothesis, ...] = ()
    hypothesis_count: int | None = None
    evidence: float | None = None
    truth: CableState | None = None
    metres: CrossTrack | Withheld | None = None


@dataclass(frozen=True, slots=True, eq=False)
class TargetSnapshot(Snapshot):
    """Results of the filter of a target for one frame.

    Attributes
    ----------
    state : FloatArray or None
        x, y, scale, angle, v_x, v_y, shape (6,), from the image centre, y up [px, rad, per second];
        None while no target is claimed.
    sigma : FloatArray or None
        Standard deviations of the first four, shape (4,); None while no target is claimed.
    box : Box or None
        Around the contour; None while no target is claimed.
    outline : FloatArray
        Corners of the contour, from the top left corner [px], shape (K, 2).
    area : float or None
        Area of the contour [px²].
    cloud : FloatArray or None
        Particles, columns of `state`, and their weights, shape (N, 7); None if there are none.
    score : float or None
        Score of the fit of the estimated region.
    truth : Box or None
        True box of the target [px], if the frame is labelled.
    """

    state: FloatArray | None = None
    sigma: FloatArray | None = None
    box: Box | None = None
    outline: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    area: float | None = None
    cloud: FloatArray | None = None
    score: float | None = None
    truth: Box | None = None


AnySnapshot: TypeAlias = CableSnapshot | TargetSnapshot
