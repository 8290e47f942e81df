"""Route of the cable as one dive has it, with the cable's visibility along it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray

PROFILE_SPACING = 0.1
"""Distance between two places at which the visibility of the cable is judged [m]."""

VISIBLE = 1.6
"""A mean score of the borders above this is a cable that can be seen; see `visibility`."""

SMOOTHED_BINS = 3
"""Places over which the mean score is averaged."""


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """Visibility of a cable along its length.

    Attributes
    ----------
    start : float
        Arc length of the beginning [m]; the places are `PROFILE_SPACING` apart.
    seen : FloatArray
        Clearness of the borders, shape (B,); NaN where it was not measured.
    in_view : BoolArray
        Whether the cable, seen or not, was inside some picture, shape (B,).
    withheld : BoolArray
        Whether it was claimed there, but without metres, shape (B,): then its borders were not
        looked at.
    """

    start: float
    seen: FloatArray
    in_view: BoolArray
    withheld: BoolArray

    @property
    def along(self) -> FloatArray:
        """Middle of each place along the cable, shape (B,) [m]."""
        return np.array(self.start + PROFILE_SPACING * (np.arange(len(self.seen)) + 0.5))

    @property
    def visible(self) -> BoolArray:
        """Whether the cable can be seen, shape (B,)."""
        kernel = np.ones(SMOOTHED_BINS)
        known = np.isfinite(self.seen)
        total = np.convolve(np.where(known, self.seen, 0.0), kernel, "same")
        count = np.convolve(known.astype(float), kernel, "same")
        with np.errstate(invalid="ignore", divide="ignore"):
            above: BoolArray = known & (total / count > VISIBLE)
        return above

    @property
    def unjudged(self) -> BoolArray:
        """Whether nothing tells that, though the cable was claimed there, shape (B,)."""
        return self.withheld & np.isnan(self.seen)


@dataclass(frozen=True, slots=True, eq=False)
class DiveRoute:
    """A piece of cable as one dive has it.

    Columns have one value for each point; see `SPACING`.

    Attributes
    ----------
    start : float
        Arc length at which the route starts, as `SmoothedCable` has it [m].
    along : FloatArray
        Arc length along the cable from there [m].
    places : FloatArray
        x, y, shape (N, 2) [m].
    headings : FloatArray
        Direction of the cable from +x [rad].
    sigmas : FloatArray
        Standard deviation across the cable [m], in the dive's frame.
    frame_variances : FloatArray
        Variance that georeferencing adds [m²]; 0 in the frame of odometry.
    bends : FloatArray
        Curvature, to the left [1/m].
    bend_sigmas : FloatArray
        Standard deviation of the bends, shape (N,) [1/m].
    stamps : IndexArray
        Time of the first keyframe at or beyond each point, along the cable, shape (N,) [ns].
    rows : IndexArray
        First row of the table of that keyframe, shape (N,).
    diameters : FloatArray
        [m]; NaN where there was no claim.
    asides : FloatArray
        Distance of the cable from the vehicle's middle, to the left [m].
    profile : Profile
        Visibility of the cable along the route.
    """

    start: float
    along: FloatArray
    places: FloatArray
    headings: FloatArray
    sigmas: FloatArray
    frame_variances: FloatArray
    bends: FloatArray
    bend_sigmas: FloatArray
    stamps: IndexArray
    rows: IndexArray
    diameters: FloatArray
    asides: FloatArray
    profile: Profile = field(repr=False)

    @property
    def total_sigmas(self) -> FloatArray:
        """Standard deviation across the cable, with what is unknown of the frame [m]."""
        return np.array(np.sqrt(self.sigmas**2 + self.frame_variances))

    def visible(self) -> BoolArray:
        """Tell at each point whether the cable can be seen, shape (N,)."""
        return self._at_points(self.profile.visible)

    def unjudged(self) -> BoolArray:
        """Tell at each point whether that is not known: see `Profile.unjudged`, shape (N,)."""
        return self._at_points(self.profile.unjudged)

    def _at_points(self, judged: BoolArray) -> BoolArray:
        shares = np.interp(self.along, self.profile.along, judged.astype(float))
        return np.asarray(shares > 0.5)
