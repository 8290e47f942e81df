"""Forward pass of a survey: track a dive, write the cable's position in each frame, find crossings.

Crossings are lines across the cable: other cables, pipes and ropes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.detection.baselines.hough import HoughDetector
from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.metric.odometry.motion import LONGEST_STEP
from cable_tracker.metric.recorded_instruments import (
    Pauses,
    RecordedCableInstruments,
    RecordedVehicle,
    recorded_vehicle,
)
from cable_tracker.metric.withheld import Withheld
from cable_tracker.sequences.bags.instrument_source import InstrumentMessage
from cable_tracker.sequences.bags.instruments import Instrument, InstrumentChoice
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.poses import unit_quaternion, yaw_of
from cable_tracker.sequences.source import open_source
from cable_tracker.sequences.source_base import Source
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.frame_table import (
    REFUSED,
    STATUSES,
    CrossingObservation,
    FrameRow,
    FrameTable,
    Samples,
)
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.picture_measurements import write_metres, write_profile, write_view
from cable_tracker.trackers import make_tracker
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.tracking.succession import SMALLEST_SIDE

POSE_WIDTH = 4
"""x, y, yaw, and speed [m, rad, m/s]."""

FIX_WIDTH = 4
"""Latitude, longitude, variances of east and north [deg, m²]."""

UNSAID_FIX_VARIANCE = 25.0
"""Variance of a fix that states none [m²]."""

MOST_RATE = 5.0
"""Largest number of pictures per second that are tracked with odometry [1/s]: it tells how the
cable moves in between, and another measurement some centimetres farther on adds little."""

FASTEST_RATE = 1000.0

EARLY = 0.05
"""A picture that is early by this share of the pause between two counts as in time."""

METRES_PAUSE = 190_000_000
"""Interval between two pictures in which metres are computed [ns]: at half a metre a second, a
cable is looked at every 10 cm, and each place of it several times."""

TEXTURE_PAUSE = 0.5
"""Interval between two measurements of the sea bed's texture while odometry agrees with it [s]."""

INSTRUMENT_PAUSE = 45_000_000
"""Shortest interval between two readings of a fast instrument that are read [ns]."""

POSE_PAUSE = 90_000_000
"""Shortest interval between two poses that are kept [ns]: a vehicle's trajectory is smooth over a
tenth of a second."""

CALIBRATION_PAUSE = NANOSECONDS
"""Shortest interval between two calibrations that are read [ns]."""

CROSSING_STRIDE = 0.5
"""Interval between two pictures that are searched for lines across the cable [s]."""

CROSSING_WIDTH = 160
"""Width of the picture that is searched [px]: a line's place need not be exact to a pixel."""

LEAST_CROSSING = math.radians(25.0)
"""Smallest angle of a crossing line to the cable; one that runs less across is not told from the
cable's own borders, ropes and furrows beside it [rad]."""

LEAST_SCORE = 0.3
"""Lines across that are seen less clearly do not count."""


@dataclass(frozen=True, slots=True)
class ForwardSettings:
    """How to track.

    Attributes
    ----------
    parameters : TrackerParameters
        Parameters of the filter.
    topic : str or None
        Image topic; None if there is just one.
    rate : float or None
        Frames per second of image folders; see `open_source`.
    choice : InstrumentChoice
        Topics of the instruments.
    vehicle : Path or None
        The user's `vehicle.yaml`.
    most_rate : float
        Pictures per second that are tracked at most where there is odometry [1/s]; 0: all.

    Raises
    ------
    ParameterError
        The rate is too high, or too low to follow a cable from one picture to the next.
    """

    parameters: TrackerParameters = field(default_factory=lambda: preset("default"))
    topic: str | None = None
    rate: float | None = None
    choice: InstrumentChoice = field(default_factory=InstrumentChoice)
    vehicle: Path | None = None
    most_rate: float = MOST_RATE

    def open(self, path: Path) -> Source:
        """Open a recording; see `open_source`."""
        return open_source(
            path, topic=self.topic, rate=self.rate, skip_bad_frames=True, with_truth=False
        )

    def __post_init__(self) -> None:
        # Over longer pauses odometry bridges nothing, or each picture is a start anew.
        slowest = 1.0 / min(LONGEST_STEP, self.parameters.maximum_gap)
        if self.most_rate != 0.0 and not slowest < self.most_rate <= FASTEST_RATE:
            raise ParameterError(
                f"most-rate is {self.most_rate:g}: give more than {slowest:g} /s and at most"
                f" {FASTEST_RATE:g} /s, or 0 for all pictures"
            )


@dataclass(slots=True, eq=False)
class ForwardDive:
    """A dive as it was tracked.

    Attributes
    ----------
    name : str
        Name of the recording.
    disk : Disk
        Allocator of the arrays.
    table : FrameTable
        One row a frame.
    poses : Samples
        Poses from odometry, `POSE_WIDTH` numbers each.
    fixes : Samples
        `FIX_WIDTH` numbers each.
    notes : list of str
        Remarks for the user: missing topics, where the recording broke off.
    view : GroundView or None
        The camera over the cable, when metres were known last; None if they never were.
    unusable_poses : int
        Number of readings of odometry without a place or an orientation.
    recording : Source or None
        Open, so that pictures can be looked at again; None: there are none.
    """

    name: str
    disk: Disk
    notes: list[str] = field(default_factory=list)
    view: GroundView | None = None
    unusable_poses: int = 0
    recording: Source | None = None
    table: FrameTable = field(init=False)
    poses: Samples = field(init=False)
    fixes: Samples = field(init=False)

    def __post_init__(self) -> None:
        self.table = FrameTable(self.disk)
        self.poses, self.fixes = Samples(POSE_WIDTH, self.disk), Samples(FIX_WIDTH, self.disk)


def track_forwards(
    recording: Source,
    name: str,
    settings: ForwardSettings,
    disk: Disk,
    advance: Callable[[int], None],
) -> ForwardDive:
    """Track an open recording from its beginning to its end, or to where it breaks off.

    Frames that cannot be used are passed over. `advance` is called with every frame.
    Arrays are allocated by `disk`; `name` is the dive's name.

    Raises
    ------
    RecordingError
        Not one frame can be read.
    ParameterError
        The vehicle file is not acceptable.
    """
    dive = ForwardDive(name, disk, recording=recording)
    vehicle = recorded_vehicle(recording, settings.choice, settings.vehicle)
    dive.notes += [*([recording.note] if recording.note else []), *vehicle.notes]
    tracker = _ForwardTracker(dive, settings, vehicle)
    try:
        _track_all(recording, tracker, advance)
    except RecordingError as error:
        if not len(dive.table):
            raise
        dive.notes.append(str(error))
    dive.notes += [*vehicle.remarks(), *tracker.remarks()]
    if tracker.passed_over:
        total = tracker.passed_over + len(dive.table)
        dive.notes.append(
            f"{len(dive.table)} of {total} pictures were tracked, {settings.most_rate:g} a"
            " second: odometry tells what lies between"
        )
    if not len(dive.table):
        raise RecordingError(f"{recording.path}: holds no frames; record it again")
    return dive


def _track_all(recording: Source, tracker: _ForwardTracker, advance: Callable[[int], None]) -> None:
    def wanted(stamp: int) -> bool:
        advance(1)
        return tracker.wants(stamp)

    try:
        for frame in recording.chosen_frames(wanted):
            tracker.take(frame)
    finally:
        tracker.close()


class _ForwardTracker:
    """Tracks the frames of a dive, and stores poses, fixes and measurements in it."""

    def __init__(
        self, dive: ForwardDive, settings: ForwardSettings, vehicle: RecordedVehicle
    ) -> None:
        self._dive = dive
        self._tracker = make_tracker(settings.parameters)
        pauses = Pauses(INSTRUMENT_PAUSE, CALIBRATION_PAUSE, TEXTURE_PAUSE)
        unaided = RecordedCableInstruments(vehicle.vehicle, None)
        self._instruments = vehicle.instruments(pauses) or unaided
        aided = self._instruments.is_aided and settings.most_rate > 0.0
        self._pause = round(NANOSECONDS / settings.most_rate) if aided else 0
        self._due: int | None = None
        self.passed_over = 0
        self._crossings = CrossingSearch(dive.table)
        self._measured = self._posed = -(2**62)

    def close(self) -> None:
        self._instruments.close()

    def remarks(self) -> tuple[str, ...]:
        return self._instruments.remarks()

    def wants(self, stamp: int) -> bool:
        """Tell whether the picture of a time [ns] is tracked; each is asked about once."""
        due, pause = self._due, self._pause
        if due is not None and due - 2 * pause < stamp < due - EARLY * pause:
            self.passed_over += 1
            return False
        # After a silence, or where the clock has jumped back, the count begins anew.
        on_time = due is not None and 0 <= stamp - due + pause < 2 * pause
        self._due = (due if on_time and due is not None else stamp) + pause
        return True

    def take(self, frame: Frame) -> None:
        """Track a frame into a new row of the table, after the messages received before it."""
        for message in self._instruments.advance(frame):
            self._store(message)
        row = self._dive.table.append()
        row["frame"], row["stamp"] = frame.index, frame.stamp
        try:
            grey = decode_grey(frame.image)
            motion = self._instruments.motion(frame.stamp, grey)
            estimate = self._tracker.process(grey, frame.stamp, motion)
        except FrameError:
            row["status"] = REFUSED
            return
        row["status"] = STATUSES.index(estimate.status.value)
        row["presence"] = np.nan if estimate.presence is None else estimate.presence
        self._instruments.fusion.observe(estimate)
        if estimate.status is TrackingStatus.TRACKING:
            row["d"], row["alpha"], row["w"], row["beta"] = estimate.state.to_array()[:4]
        if 0 <= frame.stamp - self._measured < METRES_PAUSE:
            return
        self._measured = frame.stamp
        self._measure(row, grey, estimate)

    def _measure(self, row: FrameRow, grey: Image, estimate: CableEstimate) -> None:
        """Write where the cable is in metres, and where its borders can be seen."""
        result = self._instruments.measure(estimate)
        if isinstance(result, Withheld):
            row["reason"] = self._dive.table.reason_number(result.reason.value)
        view = self._instruments.fusion.ground_view(estimate)
        if isinstance(view, GroundView):
            self._dive.view = view
            write_view(row, view, estimate)
        if isinstance(result, CrossTrack) and isinstance(view, GroundView):
            write_metres(row, result)
            write_profile(row, view, grey, estimate.state)
            self._crossings.search(view, grey, estimate)

    def _store(self, given: InstrumentMessage) -> None:
        message = given.message
        if given.instrument is Instrument.ODOMETRY:
            if 0 <= given.stamp - self._posed < POSE_PAUSE:
                return
            pose = read_pose(message)
            if pose is None:
                self._dive.unusable_poses += 1
            else:
                self._posed = given.stamp
                self._dive.poses.add(given.stamp, pose)
        elif given.instrument is Instrument.FIX:
            fix = read_fix(message)
            if fix is not None:
                self._dive.fixes.add(given.stamp, fix)


def read_pose(message: object) -> list[float] | None:
    """Read a nav_msgs/Odometry as `POSE_WIDTH` numbers; None where it has no place or orientation.

    A speed that is not finite is none, as that of odometry without a twist: 0.
    """
    odometry: Any = message
    p, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    twist = odometry.twist.twist
    place = [float(p.x), float(p.y)]
    # A quaternion that was never filled in would be read as a yaw of 0.
    if unit_quaternion(q) is None or not np.isfinite(place).all():
        return None
    speed = math.hypot(float(twist.linear.x), float(twist.linear.y), float(twist.linear.z))
    return [*place, yaw_of(q), speed if math.isfinite(speed) else 0.0]


def read_fix(message: object) -> list[float] | None:
    """Read a sensor_msgs/NavSatFix as `FIX_WIDTH` numbers; None where it has none.

    Receivers that have none yet may say 0, 0 all the same.
    """
    fix: Any = message
    if int(fix.status.status) < 0:
        return None
    place = [float(fix.latitude), float(fix.longitude)]
    if not (np.isfinite(place).all() and abs(place[0]) <= 90.0 and abs(place[1]) <= 360.0):
        return None
    if place == [0.0, 0.0]:
        return None
    variances = [float(fix.position_covariance[0]), float(fix.position_covariance[4])]
    is_said = all(0.0 < value < math.inf for value in variances)
    if not is_said or int(fix.position_covariance_type) == 0:
        variances = [UNSAID_FIX_VARIANCE] * 2
    return [*place, *variances]


class CrossingSearch:
    """Searches pictures now and then for lines across the cable, and notes them in the table.

    Parameters
    ----------
    table : FrameTable
        Table of the dive; its last row is that of the picture.
    """

    def __init__(self, table: FrameTable) -> None:
        self._table = table
        self._finder = HoughDetector()
        self._searched = -(2**62)

    def search(self, view: GroundView, grey: Image, estimate: CableEstimate) -> None:
        """Look for lines across a cable, unless the last picture that was searched is too near."""
        # Where the clock has been set back the next picture is searched.
        if 0 <= estimate.stamp - self._searched < round(CROSSING_STRIDE * NANOSECONDS):
            return
        self._searched = estimate.stamp
        state, (width, height) = estimate.state, estimate.image_size
        own = np.array([math.cos(state.angle), math.sin(state.angle)])
        # A long, low picture keeps as many rows as a detector needs.
        scale = max(min(width / CROSSING_WIDTH, height / SMALLEST_SIDE), 1.0)
        for found in self._finder.detect(_reduced(grey, scale)):
            other = found.state.scaled(scale)
            across = abs(math.remainder(other.angle - state.angle, math.pi))
            if found.score < LEAST_SCORE or across < LEAST_CROSSING:
                continue
            normal = np.array([math.cos(other.angle), math.sin(other.angle)])
            place = np.linalg.solve(np.array([own, normal]), [state.distance, other.distance])
            if abs(place[0]) > width / 2 or abs(place[1]) > height / 2:
                continue
            along = np.array([-normal[1], normal[0]])
            near, far = view.on_ground(np.array([place - 5.0 * along, place + 5.0 * along]))
            # Above the horizon there is no ground that a line could lie on.
            if not np.isfinite((near, far)).all():
                continue
            middle = (near + far) / 2
            angle = math.remainder(math.atan2(far[1] - near[1], far[0] - near[0]), math.pi)
            observation = CrossingObservation(len(self._table) - 1, float(middle[0]), angle)
            self._table.crossings.append(observation)


def _reduced(grey: Image, scale: float) -> Image:
    """Return a picture whose sides are divided by a factor."""
    if scale <= 1.0:
        return grey
    size = (round(grey.shape[1] / scale), round(grey.shape[0] / scale))
    return cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
