"""Which follower a recording and its parameters ask for."""

from __future__ import annotations

from dataclasses import replace

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.gui.session.followers.cable_follower import CableFollower
from cable_tracker.gui.session.followers.follower import Follower
from cable_tracker.gui.session.followers.target_follower import TargetFollower
from cable_tracker.gui.session.recording_request import RecordingRequest
from cable_tracker.metric.recorded.recorded_cable import RecordedVehicle
from cable_tracker.metric.recorded.recorded_target import RecordedSight
from cable_tracker.sequences.labels.target_labels import find_boxes, own_boxes
from cable_tracker.sequences.source import open_chosen
from cable_tracker.sequences.source_base import Source
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_table import ParameterSet


def open_for(request: RecordingRequest, parameters: ParameterSet) -> Source:
    """Open a recording; labels of a target are none of a cable, and are read by its follower."""
    is_target = isinstance(parameters, TargetParameters)
    return open_chosen(replace(request, truth=None) if is_target else request)


def make_follower(
    source: Source,
    request: RecordingRequest,
    parameters: ParameterSet,
    vehicle: RecordedVehicle,
) -> Follower:
    """Return what follows what the parameters are for.

    Parameters
    ----------
    vehicle : RecordedVehicle
        Instruments of the recording: metres of a cable, turns of the camera for a target.

    Raises
    ------
    ParameterError
        There is no such start.
    RecordingError
        The labels cannot be read.
    """
    if isinstance(parameters, TargetParameters):
        truth = own_boxes(source) if request.truth is None else find_boxes(source, request.truth)
        sight = RecordedSight(vehicle) if vehicle.has_instruments else None
        return TargetFollower(request.init, parameters, truth, sight)
    assert isinstance(parameters, TrackerParameters)
    return CableFollower(source, request.init, parameters, vehicle.metres())
