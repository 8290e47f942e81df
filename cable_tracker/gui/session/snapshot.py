"""Results of a tracker for one frame, as the window and its history get them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
from cable_tracker.offline.target_table import TargetRow
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.target.model.estimate import Box

Row = TypeVar("Row", EstimateRow, TargetRow)


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot(Generic[Row]):
    """Results of a filter for one frame, whatever it tracks.

    Attributes
    ----------
    number : int
        Counts the snapshots of a session; each has a larger one than those before.
    frame : int or None
        Number of the frame in its recording; None of a live camera.
    image : Image
        The frame, uint8: grey, shape (H, W), of a target also blue-green-red, shape (H, W, 3).
    row : EstimateRow or TargetRow
        The frame's row of the table; of a live camera its frame is the number of the snapshot. The
        status may also be another one of diagnostics: DISABLED, WARMING UP, ...
    """

    number: int
    frame: int | None
    image: Image
    row: Row


@dataclass(frozen=True, slots=True, eq=False)
class CableSnapshot(Snapshot[EstimateRow]):
    """Results of the filter of a cable for one frame.

    Attributes
    ----------
    rate_sigma : tuple of float
        Standard deviations of the rates [per second]; empty where they are not known.
    cloud : FloatArray or None
        Particles and their weights, shape (N, 9): columns of `CableState`, then the weight. None
        if there are none.
    hypotheses : tuple of Hypothesis
        Hypotheses, as `CableEstimate` has them; empty if they are not known.
    truth : CableState or None
        True state of the cable, if the frame is labelled.
    metres : CrossTrack, Withheld or None
        The cable beside the vehicle, or why it is not known there; None where there are no
        instruments.
    """

    rate_sigma: tuple[float, ...] = ()
    cloud: FloatArray | None = None
    hypotheses: tuple[Hypothesis, ...] = ()
    truth: CableState | None = None
    metres: CrossTrack | Withheld | None = None


@dataclass(frozen=True, slots=True, eq=False)
class TargetSnapshot(Snapshot[TargetRow]):
    """Results of the filter of a target for one frame.

    Attributes
    ----------
    outline : FloatArray
        Corners of the contour, from the top left corner [px], shape (K, 2).
    cloud : FloatArray or None
        Particles, columns of `TargetClaim.state`, and their weights, shape (N, 7); None if there
        are none.
    score : float or None
        Score of the fit of the estimated region.
    truth : Box or None
        True box of the target [px], if the frame is labelled.
    """

    outline: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    cloud: FloatArray | None = None
    score: float | None = None
    truth: Box | None = None


AnySnapshot: TypeAlias = CableSnapshot | TargetSnapshot
