"""Axis of a merged route, and where the points of other routes lie beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray, true_runs
from cable_tracker.survey.routes.dive_route import DiveRoute
from cable_tracker.survey.routes.route import SPACING

REACH = 5.0
"""Routes farther apart are not of one cable [m]; `SIGMAS` standard deviations if these are more."""

SIGMAS = 4.0

ALONG, ROUGHLY_ALONG = 0.9, 0.5
"""Least cosine of the angle between two routes of one cable, whichever way they run, and of that
with the points of an axis that are far apart."""

NOT_ALONG = 1e6
"""What another direction counts for, beside the distance [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """Line of points beside which the routes of one cable are laid.

    Attributes
    ----------
    points : FloatArray
        x, y, `SPACING` apart, shape (N, 2) [m].
    sigmas : FloatArray
        Standard deviation across it, shape (N,) [m].
    """

    points: FloatArray
    sigmas: FloatArray

    def coordinates(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return arc lengths along the axis [points] and distances to its left [m], points (M, 2).

        Points of a route beyond the ends of the axis have an arc length below 0 or above N - 1.
        Where the axis crosses itself, the branch counts that runs as the route does.
        """
        from_axis = np.empty((len(points), 2))
        directions, own_directions = directions_of(self.points), directions_of(points)
        block = 512
        for begin in range(0, len(points), block):
            part = points[begin : begin + block]
            nearest = _nearest(self.points, directions, part, own_directions[begin : begin + block])
            apart = part - self.points[nearest]
            beyond = (apart * directions[nearest]).sum(axis=1) / SPACING
            normal = np.column_stack((-directions[nearest, 1], directions[nearest, 0]))
            from_axis[begin : begin + block, 0] = nearest + beyond
            from_axis[begin : begin + block, 1] = (apart * normal).sum(axis=1)
        return from_axis[:, 0], from_axis[:, 1]

    def overlap(self, route: DiveRoute) -> float:
        """Return the length of the longest stretch that a route shares with the axis [m]."""
        along, aside = self.coordinates(route.places)
        shared = (along >= 0) & (along <= len(self.points) - 1)
        shared &= self.is_along(route, along, aside)
        return max((last - first for first, last in true_runs(shared)), default=0) * SPACING

    def is_along(self, route: DiveRoute, along: FloatArray, aside: FloatArray) -> BoolArray:
        """Tell which points of a route (N,) are near the axis, and run along it.

        `along` and `aside` are the `coordinates` of the route's points.
        """
        directions = directions_of(self.points)[self._nearest_points(along)]
        cosines = (directions_of(route.places) * directions).sum(axis=1)
        fits: BoolArray = self._is_near(route, along, aside) & (np.abs(cosines) > ALONG)
        return fits

    def _is_near(self, route: DiveRoute, along: FloatArray, aside: FloatArray) -> BoolArray:
        """Tell which points of a route (N,) are not too far from the axis for one cable."""
        sigmas = np.hypot(route.total_sigmas, self.sigmas[self._nearest_points(along)])
        is_near: BoolArray = np.abs(aside) <= np.maximum(REACH, SIGMAS * sigmas)
        return is_near

    def _nearest_points(self, along: FloatArray) -> IndexArray:
        """Return the points of the axis that are nearest to arc lengths (M,) along it [points]."""
        nearest: IndexArray = np.clip(np.round(along), 0, len(self.points) - 1).astype(np.int64)
        return nearest

    def extended(self, route: DiveRoute) -> tuple[Axis, int]:
        """Return the axis with what a route has beyond its ends, unless it left the cable before.

        And how many points that is before its beginning.
        """
        along, aside = self.coordinates(route.places)
        points, sigmas = route.places, route.total_sigmas
        is_near = self._is_near(route, along, aside)
        if along[-1] < along[0]:
            along, points, sigmas, is_near = along[::-1], points[::-1], sigmas[::-1], is_near[::-1]
        before = np.flatnonzero(along < -0.5)
        after = np.flatnonzero(along > len(self.points) - 0.5)
        all_points, all_sigmas, added = [self.points], [self.sigmas], 0
        if len(before) and is_near[before[-1]]:
            end = self.points[0] - directions_of(self.points)[0] * SPACING
            all_points.insert(0, points[before] + (end - points[before[-1]]))
            all_sigmas.insert(0, sigmas[before])
            added = len(before)
        if len(after) and is_near[after[0]]:
            end = self.points[-1] + directions_of(self.points)[-1] * SPACING
            all_points.append(points[after] + (end - points[after[0]]))
            all_sigmas.append(sigmas[after])
        return Axis(np.concatenate(all_points), np.concatenate(all_sigmas)), added


def directions_of(points: FloatArray) -> FloatArray:
    """Return unit vectors along a line of points (N, 2), shape (N, 2)."""
    steps = np.gradient(points, axis=0)
    length = np.maximum(np.hypot(*steps.T), 1e-9)
    directions: FloatArray = steps / length[:, None]
    return directions


def _nearest(
    axis: FloatArray, directions: FloatArray, points: FloatArray, own_directions: FloatArray
) -> IndexArray:
    """Return the axis' nearest point for each point: of every 16th first, then of those around.

    What runs along the point's own direction, whichever way, is nearer than all that does not.
    """
    stride = 16

    def away(others: FloatArray, courses: FloatArray, least: float) -> FloatArray:
        squares: FloatArray = ((points[:, None] - others) ** 2).sum(axis=2)
        cosines = np.abs((own_directions[:, None] * courses).sum(axis=2))
        return np.where(cosines > least, squares, squares + NOT_ALONG**2)

    coarse = away(axis[None, ::stride], directions[None, ::stride], ROUGHLY_ALONG).argmin(axis=1)
    begin = np.clip((coarse - 1) * stride, 0, max(len(axis) - 2 * stride - 1, 0))
    window = np.minimum(begin[:, None] + np.arange(2 * stride + 1), len(axis) - 1)
    fine = away(axis[window], directions[window], ALONG).argmin(axis=1)
    nearest: IndexArray = window[np.arange(len(points)), fine]
    return nearest
