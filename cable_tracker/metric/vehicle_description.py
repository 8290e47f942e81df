"""Description of a vehicle, known before its recording is tracked: mounting, calibration, sigmas.

It comes from the bag's `/tf_static`, and from a file `vehicle.yaml` that wins over it: parameters
by name as the tracker node reads them, and the calibration under the names that ROS' camera
calibration writes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import ParameterError
from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.frames import camera_parameters
from cable_tracker.node_parameter_tables import MOUNTING_PARAMETERS, CableVehicleParameters
from cable_tracker.sequences.bags.instrument_source import InstrumentSource
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.messages.static_transforms import pose_in
from cable_tracker.tracking.parameter_files import read_parameter_file
from cable_tracker.tracking.parameter_table import parameter_table

CALIBRATION_NAMES = (
    "image_width", "image_height", "distortion_model", "camera_matrix", "distortion_coefficients",
)  # fmt: skip
PROJECTION = "projection_matrix"
IGNORED_NAMES = ("camera_name", "rectification_matrix")

TURNED = math.radians(1.0)
"""An imu that is turned by more against base_link cannot be read as if it were not [rad]."""

UNKNOWN_MOUNTING = (
    "the mounting of the camera is not known: it counts as looking straight down at a cable, or"
    f" ahead at a target; say so in vehicle.yaml ({', '.join(MOUNTING_PARAMETERS)})"
)

LEANING = math.radians(5.0)
"""A beam that is farther from straight down is noted [rad]: it makes an altitude 0.4 % too large,
and from there the error grows as the square."""


@dataclass(frozen=True, slots=True)
class VehicleDescription:
    """A vehicle as it is described.

    Attributes
    ----------
    parameters : CableVehicleParameters
        Mounting of camera and instruments, and how they are read.
    calibration : Calibration or None
        Calibration of the camera, where no topic gives one.
    notes_on_frames : tuple of str
        What the user should know of the bag's frames.
    said : frozenset of str
        Names of those parameters that the bag's frames or the file say; the others are defaults.
    is_mounting_unknown : bool
        There is a calibration, so that metres can be told, but neither says how the camera looks.
    """

    parameters: CableVehicleParameters = field(default_factory=CableVehicleParameters)
    calibration: Calibration | None = None
    notes_on_frames: tuple[str, ...] = ()
    said: frozenset[str] = frozenset()
    is_mounting_unknown: bool = False

    @property
    def notes(self) -> tuple[str, ...]:
        """All that the user should know of the description."""
        return (*self.notes_on_frames, *([UNKNOWN_MOUNTING] if self.is_mounting_unknown else []))


@dataclass(frozen=True, slots=True)
class VehicleFile:
    """Content of a vehicle file.

    Attributes
    ----------
    values : dict
        Values of the parameters that it names.
    calibration : Calibration or None
        Calibration of the camera.
    """

    values: dict[str, object] = field(default_factory=dict)
    calibration: Calibration | None = None


def read_vehicle_file(path: Path) -> VehicleFile:
    """Read a `vehicle.yaml`.

    Raises
    ------
    ParameterError
        It cannot be read, names something unknown, or a value is not acceptable.
    """
    content = read_parameter_file(path)
    specs = {spec.name: spec for spec in parameter_table(CableVehicleParameters)}
    known = (*specs, *CALIBRATION_NAMES, PROJECTION, *IGNORED_NAMES)
    unknown = sorted(set(content) - set(known))
    if unknown:
        raise ParameterError(
            f"{path}: {', '.join(unknown)}: no such parameter; known are {', '.join(known)}"
        )
    values: dict[str, object] = {}
    for name in specs.keys() & content.keys():
        try:
            values[name] = specs[name].coerce(content[name])
        except ParameterError as error:
            raise ParameterError(f"{path}: {error}") from error
    given = [name for name in CALIBRATION_NAMES if name in content]
    if not given:
        return VehicleFile(values)
    is_rectified = bool(values.get("image_is_rectified", False))
    return VehicleFile(values, _calibration(path, content, is_rectified=is_rectified))


def _calibration(path: Path, content: Mapping[str, object], *, is_rectified: bool) -> Calibration:
    """Return the calibration of the images: raw ones, or rectified ones."""
    try:
        matrix, coefficients = (
            _numbers(content[name]) for name in ("camera_matrix", "distortion_coefficients")
        )
        size = (int(str(content["image_width"])), int(str(content["image_height"])))
        model = str(content["distortion_model"])
    except (KeyError, TypeError, ValueError) as error:
        raise ParameterError(
            f"{path}: the calibration is not complete or no numbers ({error}); it needs"
            f" {', '.join(CALIBRATION_NAMES)}"
        ) from error
    if len(matrix) != 9:
        raise ParameterError(f"{path}: camera_matrix has {len(matrix)} numbers; it needs 9")
    if is_rectified and (PROJECTION in content or any(coefficients)):
        return Calibration.of_projection(size, _projection(path, content))
    return Calibration.of_matrices(size, model, matrix, coefficients)


def _projection(path: Path, content: Mapping[str, object]) -> list[float]:
    try:
        numbers = _numbers(content[PROJECTION])
    except (KeyError, TypeError, ValueError) as error:
        raise ParameterError(
            f"{path}: image_is_rectified needs the {PROJECTION} of the calibration ({error})"
        ) from error
    if len(numbers) != 12:
        raise ParameterError(f"{path}: {PROJECTION} has {len(numbers)} numbers; it needs 12")
    return numbers


def _numbers(value: object) -> list[float]:
    data = value["data"] if isinstance(value, dict) else value
    if not isinstance(data, list):
        raise TypeError("no list of numbers")
    return [float(each) for each in data]


def describe_vehicle(
    source: InstrumentSource | None, camera_frame: str, file: VehicleFile | None = None
) -> VehicleDescription:
    """Put together what a bag and a file say about a vehicle; the file wins.

    Parameters
    ----------
    source : InstrumentSource or None
        Instruments and frames of the bag.
    camera_frame : str
        `frame_id` of the images: the camera's optical frame.
    file : VehicleFile or None
        Description given by the user, which overrides the recording.
    """
    file = file if file is not None else VehicleFile()
    said: dict[str, object] = {}
    notes: list[str] = []
    if source is not None:
        is_vertical = bool(file.values.get("altitude_is_vertical", False))
        said, notes = _from_frames(source, camera_frame, is_vertical=is_vertical)
    said |= file.values
    has_calibration = source is not None and Instrument.CAMERA_INFO in source.found.topics
    is_said = any(name in said for name in MOUNTING_PARAMETERS)
    return VehicleDescription(
        CableVehicleParameters().replaced(said),
        file.calibration,
        tuple(notes),
        frozenset(said),
        is_mounting_unknown=(has_calibration or file.calibration is not None)
        and not (notes or is_said),
    )


def _from_frames(
    source: InstrumentSource, camera_frame: str, *, is_vertical: bool
) -> tuple[dict[str, object], list[str]]:
    values: dict[str, object] = {}
    notes: list[str] = []
    transforms = source.static_transforms()
    if not transforms:
        return values, notes
    odometry = source.first(Instrument.ODOMETRY)
    base = str(odometry.child_frame_id).strip("/") if odometry is not None else ""
    base = base or "base_link"
    camera = pose_in(transforms, camera_frame, base)
    if camera is None:
        notes.append(
            f"/tf_static does not connect {camera_frame} with {base}; the camera counts as mounted"
            " as vehicle.yaml says, or looks straight down at a cable, or ahead at a target"
        )
    else:
        values.update(camera_parameters(*camera))
        values["base_frame"] = base
    altitude = source.first(Instrument.ALTITUDE)
    if altitude is not None and hasattr(altitude, "header"):
        altimeter = pose_in(transforms, str(altitude.header.frame_id), base)
        if altimeter is not None:
            names = ("altimeter_x", "altimeter_y", "altimeter_z")
            values.update(zip(names, altimeter[1].tolist(), strict=True))
            if not is_vertical:
                notes += _note_on_beam(altimeter[0], base)
    imu = source.first(Instrument.IMU)
    if imu is not None:
        pose = pose_in(transforms, str(imu.header.frame_id), base)
        if pose is not None and _angle_of(pose[0]) > TURNED:
            notes.append(
                f"the imu is turned by {math.degrees(_angle_of(pose[0])):.0f} deg against {base},"
                " which is not read; the vehicle counts as level (--imu-topic none)"
            )
            source.leave_out(Instrument.IMU)
    return values, notes


def _note_on_beam(rotation: FloatArray, base: str) -> list[str]:
    """Return a note if an altimeter, whose frame is turned so, does not look straight down."""
    # The beam of a Range is the x axis of its frame. A frame that is not turned at all stands for
    # the position alone: as a beam it would look ahead, and would measure no altitude.
    lean = math.acos(max(-1.0, min(1.0, -float(rotation[2, 0]))))
    if lean <= LEANING or _angle_of(rotation) <= TURNED:
        return []
    return [
        f"the beam of the altimeter (+x of its frame) is {math.degrees(lean):.0f} deg from straight"
        f" down in {base}, which is not read: it counts as looking along -z. If it leans, metres"
        " are too large: give vertical distances and altitude_is_vertical: true in vehicle.yaml, or"
        " leave it out (--altitude-topic none); if it does not, mend /tf_static"
    ]


def _angle_of(rotation: FloatArray) -> float:
    return math.acos(max(-1.0, min(1.0, (float(np.trace(rotation)) - 1.0) / 2)))
