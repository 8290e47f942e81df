"""Re-detection of the cable in frames without a claim, around its smoothed position.

The tracker goes forwards only: where the cable comes out of the sand it may still be on a rope, or
may need a second to find it. When a dive has been smoothed, the place of the cable is known there
from what comes later. So these pictures are read again, and the cable is looked for beside that
place, with the width that it has elsewhere.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cable_tracker.arrays import Image, IndexArray
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.metric.calibration import camera_for
from cable_tracker.metric.frames import Attitude
from cable_tracker.metric.ground_view import GroundView, move_states
from cable_tracker.metric.withheld import Withheld
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.survey.curve_filter import SmoothedCable
from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import (
    HIDDEN,
    NOT_AGAIN,
    SEEN,
    TRACKING,
    FrameRow,
)
from cable_tracker.survey.picture_measurements import border_step_of, find_beside, write_profile
from cable_tracker.survey.routes.profile import LEAST_WEIGHT
from cable_tracker.survey.routes.route import Course
from cable_tracker.survey.smoother import SURE_ENOUGH

REACH = 2.0
"""Distance to either side of its smoothed place within which the cable is looked for [standard
deviations]."""

LEAST_REACH = 0.5
"""Smallest distance within which the cable is looked for, to either side [diameters]."""

CLEAR_ENOUGH = 0.65
"""Smallest border steps with which the cable is found, as a share of the dive's usual ones."""

HEADING_SIGMA = math.radians(5.0)
"""Standard deviation of the cable's direction, which re-detection does not measure [rad]."""

SHARE_OF_DIAMETER = 0.25
"""Standard deviation of the cable's place [diameters]."""


def redetect_cable(dive: ForwardDive, course: Course) -> int:
    """Look for the cable in pictures without a claim that counts; return in how many it was found.

    The rows of the dive's table are written: the cable's columns where it is found, else only how
    clearly it is seen at its smoothed place.
    """
    rows = dive.table.rows
    wanted = _without_claim(dive, course)
    usual = _usual(dive, course)
    if not len(wanted) or usual is None or dive.view is None or dive.recording is None:
        return 0
    stamps = dive.disk.filled(len(wanted), lambda part: rows["stamp"][wanted[part]], np.int64)
    stamps.sort()
    last, found, number = int(rows["frame"][wanted[-1]]), 0, 0
    try:
        for frame in dive.recording.chosen_frames(lambda stamp: _is_among(stamps, stamp)):
            while number < len(wanted) and rows["frame"][wanted[number]] < frame.index:
                number += 1
            if number < len(wanted) and rows["frame"][wanted[number]] == frame.index:
                row = int(wanted[number])
                keyframe = int(course.keyframes.of(np.array([row]))[0])
                picture = _picture_of(rows[row], dive.view, frame.image)
                if picture is not None:
                    found += _redetect(rows[row], course.cable, keyframe, picture, usual)
                if row % dive.disk.block == 0:
                    dive.disk.release_pages()
            if frame.index >= last:
                break
    except RecordingError:
        # Where it breaks off stands in the notes already.
        pass
    return found


def _is_among(sorted_stamps: IndexArray, stamp: int) -> bool:
    place = int(np.searchsorted(sorted_stamps, stamp))
    return place < len(sorted_stamps) and int(sorted_stamps[place]) == stamp


def _without_claim(dive: ForwardDive, course: Course) -> IndexArray:
    """Return rows without a claim that counts, where the cable's place is known and in view."""
    cable, wanted = course.cable, dive.disk.growing(np.int64)
    for part in dive.disk.blocks(len(dive.table)):
        rows, owner = dive.table.rows[part], course.keyframes.of_rows(part)
        sure = cable.covariances[owner, 0, 0] < SURE_ENOUGH**2
        known = (owner >= 0) & sure & np.isfinite(rows["roll"])
        # A claim that looks like the cable is not of something else, even if it does not fit.
        counts = (cable.weights[owner] > LEAST_WEIGHT) | ~course.keyframes.doubtful[owner]
        counts &= (rows["status"] == TRACKING) & np.isfinite(rows["aside"])
        in_view = np.abs(cable.states[owner, 0]) < rows["half_view"]
        chosen = known & ~counts & in_view & (rows["again"] == NOT_AGAIN)
        wanted.extend(part.start + np.flatnonzero(chosen))
    return wanted.rows()


def _usual(dive: ForwardDive, course: Course) -> tuple[float, float] | None:
    """Return the usual diameter [m] and step of the borders; None without a claim."""
    disk = dive.disk
    diameters, steps = disk.growing(np.float32), disk.growing(np.float32)
    for part in disk.blocks(len(dive.table)):
        rows, owner = dive.table.rows[part], course.keyframes.of_rows(part)
        counts = (owner >= 0) & (course.cable.weights[owner] > LEAST_WEIGHT)
        counts &= (rows["status"] == TRACKING) & np.isfinite(rows["diameter"])
        own = border_step_of(rows["profile_score"][counts].astype(np.float32))
        diameters.extend(rows["diameter"][counts])
        steps.extend(own[np.isfinite(own)])
    if not len(steps):
        return None
    return disk.median_in_place(diameters), disk.median_in_place(steps)


def _redetect(
    row: FrameRow,
    cable: SmoothedCable,
    keyframe: int,
    picture: tuple[Image, GroundView],
    usual: tuple[float, float],
) -> bool:
    """Look for the cable around its smoothed place at a keyframe; tell whether it is seen.

    Parameters
    ----------
    row : FrameRow
        Row of the picture, which is written.
    picture : (Image, GroundView)
        See `_picture_of`.
    usual : (float, float)
        Usual diameter [m] and step of the borders.
    """
    (grey, view), (diameter, border_step) = picture, usual
    aside, heading = (float(value) for value in cable.states[keyframe, :2])
    sigma = math.sqrt(float(cable.covariances[keyframe, 0, 0])) * math.cos(heading)
    reach = max(REACH * sigma / diameter, LEAST_REACH)
    expected = place_in_image(view, float(row["look"]), (aside, heading), diameter)
    beside = find_beside(grey, expected, reach)
    if beside is None:
        return False
    shift, clear = beside
    if clear < CLEAR_ENOUGH * border_step:
        if write_profile(row, view, grey, expected):
            row["again"] = HIDDEN
        return False
    aside -= shift * diameter / math.cos(heading)
    state = place_in_image(view, float(row["look"]), (aside, heading), diameter)
    if not write_profile(row, view, grey, state):
        return False
    row["again"] = SEEN
    _write_cable(row, state, (aside, heading), diameter)
    return True


def _picture_of(
    row: FrameRow, view: GroundView, encoded: RawImage | CompressedImage
) -> tuple[Image, GroundView] | None:
    """Return a row's picture and its view of the ground; None if one of them is of no use.

    `view` is that of the last picture of the dive: those before may have had another size.
    """
    try:
        grey = decode_grey(encoded)
    except FrameError:
        return None
    camera = camera_for(view.camera.calibration, (grey.shape[1], grey.shape[0]))
    if isinstance(camera, Withheld):
        return None
    attitude = Attitude(float(row["roll"]), float(row["pitch"]), view.attitude.sigma)
    view = replace(view, camera=camera, attitude=attitude, height=float(row["altitude"]))
    return (grey, view) if view.clearance > 0.0 else None


def _write_cable(
    row: FrameRow, state: CableState, place: tuple[float, float], diameter: float
) -> None:
    aside, heading = place
    look, variance = float(row["look"]), (SHARE_OF_DIAMETER * diameter) ** 2
    row["d"], row["alpha"], row["w"], row["beta"] = wrap_state(state.to_array())[:4]
    row["aside"], row["heading"], row["diameter"] = aside, heading, diameter
    row["aside_variance"], row["aside_heading"] = variance, 0.0
    row["heading_variance"] = HEADING_SIGMA**2
    row["offset"] = aside - look * math.tan(heading)
    row["sigma_offset"] = math.sqrt(variance + (look * HEADING_SIGMA) ** 2)
    row["sigma_heading"] = HEADING_SIGMA
    row["reason"] = 0


def place_in_image(
    view: GroundView, look: float, place: tuple[float, float], diameter: float
) -> CableState:
    """Return where in the picture a cable is seen that lies beside a look line [m, rad]."""
    aside, heading = place
    # In the frame of the ground from above, see `GroundView.ground_to_image`.
    distance = -aside * math.cos(heading) + look * math.sin(heading)
    seen = move_states(np.array([[distance, heading, diameter, 0.0]]), view.ground_to_image())[0]
    return CableState.from_array(seen)
