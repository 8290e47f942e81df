import math
from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.errors import ParameterError
from cable_tracker.metric.frames import OPTICAL_IN_BODY, rotation_of
from cable_tracker.metric.vehicle_description import describe_vehicle, read_vehicle_file
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.messages.static_transforms import StaticTransform

CALIBRATION = """
image_width: 320
image_height: 240
camera_name: eye
distortion_model: plumb_bob
camera_matrix: {rows: 3, cols: 3, data: [280, 0, 159.5, 0, 281, 119.5, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}
"""


def written(tmp_path, text):
    path = tmp_path / "vehicle.yaml"
    path.write_text(text)
    return path


def test_a_vehicle_file_gives_mounting_and_calibration(tmp_path):
    file = read_vehicle_file(
        written(tmp_path, "camera_pitch: 70\naltimeter_z: -0.2\n" + CALIBRATION)
    )
    assert file.values == {"camera_pitch": 70.0, "altimeter_z": -0.2}
    assert file.calibration.focal == (280.0, 281.0)
    assert file.calibration.coefficients[0] == 0.1


def test_what_the_file_does_not_say_is_as_always(tmp_path):
    vehicle = describe_vehicle(
        None, "", read_vehicle_file(written(tmp_path, "cable_height: 0.1\n"))
    )
    assert vehicle.parameters.cable_height == 0.1
    assert vehicle.parameters.camera_pitch == 90.0


def test_rectified_images_are_calibrated_by_the_projection(tmp_path):
    projection = "projection_matrix: {data: [250, 0, 160, 0, 0, 251, 120, 0, 0, 0, 1, 0]}\n"
    text = f"image_is_rectified: true\n{CALIBRATION}{projection}"
    calibration = read_vehicle_file(written(tmp_path, text)).calibration
    assert (calibration.focal, calibration.centre) == ((250.0, 251.0), (160.0, 120.0))
    assert calibration.coefficients == ()


def test_a_calibration_of_rectified_images_without_distortion_is_its_own_projection(tmp_path):
    text = f"image_is_rectified: true\n{CALIBRATION.replace('[0.1,', '[0,')}"
    assert read_vehicle_file(written(tmp_path, text)).calibration.focal == (280.0, 281.0)


def test_a_mounting_that_is_not_known_is_noted_where_there_are_metres(tmp_path):
    plain = read_vehicle_file(written(tmp_path, CALIBRATION))
    told = read_vehicle_file(written(tmp_path, f"camera_pitch: 90\n{CALIBRATION}"))
    assert "mounting of the camera is not known" in describe_vehicle(None, "", plain).notes[0]
    assert describe_vehicle(None, "", told).notes == describe_vehicle(None, "").notes == ()


def test_raw_images_need_no_projection(tmp_path):
    text = f"image_is_rectified: false\n{CALIBRATION}projection_matrix: none\n"
    assert read_vehicle_file(written(tmp_path, text)).calibration.focal == (280.0, 281.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("camera_pich: 70\n", "camera_pich: no such parameter"),
        ("camera_pitch: 900\n", "camera_pitch"),
        ("camera_pitch: steep\n", "camera_pitch"),
        ("image_width: 320\n", "calibration is not complete"),
        (CALIBRATION.replace("0, 0, 1]", "0]"), "camera_matrix has 7 numbers"),
        (f"image_is_rectified: true\n{CALIBRATION}", "needs the projection_matrix"),
        (
            f"image_is_rectified: true\n{CALIBRATION}projection_matrix: [1.0, 2.0]\n",
            "projection_matrix has 2 numbers",
        ),
    ],
)
def test_a_wrong_file_is_refused_with_the_reason(tmp_path, text, words):
    with pytest.raises(ParameterError, match=words):
        read_vehicle_file(written(tmp_path, text))


class FramesOfABag:
    """A bag of which only `/tf_static` and the frame of the altimeter are known.

    Its camera looks straight down, and its altimeter's beam is lowered by an angle [deg].
    """

    found = SimpleNamespace(topics={Instrument.ALTITUDE: "altitude"})

    def __init__(self, lowered, yaw=0.3):
        eye = rotation_of(np.array([0.0, math.pi / 2, 0.0])) @ OPTICAL_IN_BODY
        beam = rotation_of(np.array([0.0, math.radians(lowered), yaw]))
        self._transforms = (
            StaticTransform("base_link", "eye", eye, np.zeros(3)),
            StaticTransform("base_link", "sounder", beam, np.array([0.2, 0.0, 0.0])),
        )

    def static_transforms(self):
        return self._transforms

    def first(self, instrument):
        if instrument is not Instrument.ALTITUDE:
            return None
        return SimpleNamespace(header=SimpleNamespace(frame_id="sounder"))


@pytest.mark.parametrize("lowered", [90.0, 86.0, 94.0])
def test_an_altimeter_that_looks_down_needs_no_note(lowered):
    vehicle = describe_vehicle(FramesOfABag(lowered), "eye")
    assert vehicle.notes == ()
    assert vehicle.parameters.altimeter_x == 0.2


@pytest.mark.parametrize(("lowered", "degrees"), [(60.0, 30), (83.0, 7), (0.0, 90), (-90.0, 180)])
def test_an_altimeter_that_does_not_look_down_is_noted(lowered, degrees):
    (note,) = describe_vehicle(FramesOfABag(lowered), "eye").notes
    assert f"{degrees} deg from straight down" in note
    assert "altitude_is_vertical" in note


def test_a_frame_of_the_altimeter_that_is_not_turned_says_nothing_of_its_beam():
    assert describe_vehicle(FramesOfABag(0.0, yaw=0.0), "eye").notes == ()


def test_a_vertical_altitude_has_no_beam(tmp_path):
    file = read_vehicle_file(written(tmp_path, "altitude_is_vertical: true\n"))
    assert describe_vehicle(FramesOfABag(0.0), "eye", file).notes == ()
