"""Writes what is measured in one picture into its row of the table."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import points_on_lines
from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.survey.frames.frame_table import FrameRow
from cable_tracker.survey.frames.visibility import border_profile


def write_view(row: FrameRow, view: GroundView, estimate: CableEstimate) -> None:
    """Write where the camera looks, and how far it sees to either side."""
    row["look"] = view.on_ground(np.zeros((1, 2)))[0, 0]
    row["half_view"] = 0.5 * _view_width(view, float(row["look"]), estimate.image_size)
    row["altitude"] = view.height
    row["roll"], row["pitch"] = view.attitude.roll, view.attitude.pitch


def _view_width(view: GroundView, look: float, image_size: tuple[int, int]) -> float:
    """Return the length inside the image of the line at x = `look`, at the cable's height [m].

    However the camera is turned about its axis.
    """
    if view.clearance <= 0.0:
        return math.nan
    # The line's points in homogeneous coordinates: at y = 0, and by how much they change with y.
    start, step = (view.ground_to_image() @ np.array([[0.0, look, 1.0], [-1.0, 0.0, 0.0]]).T).T
    low, high = -math.inf, math.inf
    for side, sign in product(range(2), (-1.0, 1.0)):
        edge = 0.5 * (image_size[side] - 1)
        beyond = sign * start[side] - edge * start[2]
        change = sign * step[side] - edge * step[2]
        if change > 0.0:
            high = min(high, -beyond / change)
        elif change < 0.0:
            low = max(low, -beyond / change)
        elif beyond > 0.0:
            return 0.0
    return float(max(high - low, 0.0))


def write_metres(row: FrameRow, result: CrossTrack) -> None:
    """Write where the cable is beside the vehicle, and at the place where the camera looks."""
    sigma = result.standard_deviations()
    row["offset"], row["sigma_offset"] = result.offset, sigma[0]
    row["heading"], row["sigma_heading"] = result.heading, sigma[2]
    row["diameter"] = result.diameter
    row["aside"], covariance = result.at(float(row["look"]))
    row["aside_variance"], row["aside_heading"] = covariance[0]
    row["heading_variance"] = covariance[1, 1]


def write_profile(row: FrameRow, view: GroundView, grey: Image, state: CableState) -> bool:
    """Write where along a cable its borders can be seen; False: too little of it is inside."""
    profile = border_profile(grey, state)
    if profile is None:
        return False
    along, scores = profile
    points = points_on_lines(np.array(state.angle), np.array(state.distance), along)
    row["profile_ahead"] = view.on_ground(points)[:, 0]
    row["profile_score"] = scores
    return True
