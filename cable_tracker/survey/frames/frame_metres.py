"""Metres of one picture, as they stand in its row of the table."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import points_on_lines
from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.odometry.homography import Overflight
from cable_tracker.survey.frames.frame_table import FrameRow
from cable_tracker.survey.frames.visibility import border_profile


def put_view(row: FrameRow, flight: Overflight, estimate: CableEstimate) -> None:
    """Note from where the camera looks, and how far it sees to either side."""
    row["look"] = on_ground(flight, np.zeros((1, 2)))[0, 0]
    row["half_view"] = 0.5 * _seen_across(flight, float(row["look"]), estimate.image_size)
    row["altitude"] = flight.height
    row["roll"], row["pitch"] = flight.attitude.roll, flight.attitude.pitch


def _seen_across(flight: Overflight, look: float, image_size: tuple[int, int]) -> float:
    """Return the length inside the image of the line at x = `look`, at the cable's height [m].

    However the camera is turned about its axis.
    """
    if depth_of_ground(flight) <= 0.0:
        return math.nan
    # The line's points in homogeneous coordinates: at y = 0, and by how much they change with y.
    start, step = (to_image(flight) @ np.array([[0.0, look, 1.0], [-1.0, 0.0, 0.0]]).T).T
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


def put_metres(row: FrameRow, result: CrossTrack) -> None:
    """Note where the cable is beside the vehicle, and at the place where the camera looks."""
    sigma = result.standard_deviations()
    row["offset"], row["sigma_offset"] = result.offset, sigma[0]
    row["heading"], row["sigma_heading"] = result.heading, sigma[2]
    row["diameter"] = result.diameter
    row["aside"], covariance = result.at(float(row["look"]))
    row["aside_variance"], row["aside_heading"] = covariance[0]
    row["heading_variance"] = covariance[1, 1]


def put_profile(row: FrameRow, flight: Overflight, grey: Image, state: CableState) -> bool:
    """Note where along a cable its borders can be seen; False: too little of it is inside."""
    profile = border_profile(grey, state)
    if profile is None:
        return False
    along, scores = profile
    points = points_on_lines(np.array(state.angle), np.array(state.distance), along)
    row["profile_ahead"] = on_ground(flight, points)[:, 0]
    row["profile_score"] = scores
    return True


def on_ground(flight: Overflight, points: FloatArray) -> FloatArray:
    """Return where points of the image (N, 2) [px] lie at the cable's height, (N, 2) [m].

    In the level frame; the lens counts as a pinhole. NaN at and above the horizon, and where the
    camera is no higher than the cable.
    """
    if depth_of_ground(flight) <= 0.0:
        return np.full((len(points), 2), np.nan)
    places = np.column_stack((points, np.ones(len(points)))) @ np.linalg.inv(to_image(flight)).T
    # What lies behind the camera, or nowhere, has a depth that is not positive.
    with np.errstate(divide="ignore", invalid="ignore"):
        right, ahead = np.where(places[:, 2:] > 0.0, places[:, :2] / places[:, 2:], np.nan).T
    return np.column_stack((ahead, -right))


def depth_of_ground(flight: Overflight) -> float:
    """Return how far below the camera the cable's height is [m]; not above 0: it sees no ground."""
    return float(flight.height + (flight.attitude.rotation @ flight.mounting.position)[2])


def to_image(flight: Overflight) -> FloatArray:
    """Return what takes the ground, seen from above, to the image, shape (3, 3).

    The ground from above, at the cable's height, is an image frame in metres: x to the right, y
    ahead, in the level frame. The third number that a point gets is its depth before the camera.
    """
    level = flight.attitude.rotation
    centre = level @ flight.mounting.position
    ground = np.array(
        [[0.0, 1.0, -centre[0]], [-1.0, 0.0, -centre[1]], [0.0, 0.0, -depth_of_ground(flight)]]
    )
    mapping: FloatArray = flight.camera.image_matrix @ (level @ flight.mounting.rotation).T @ ground
    return mapping
