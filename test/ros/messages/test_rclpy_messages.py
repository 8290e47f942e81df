from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message

from cable_tracker.cable.model.estimate import CableEstimate, Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.ros.health.diagnostics import (
    FrameStatistics,
    cable_values,
    frame_values,
    make_diagnostics,
)
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages, message_class
from cable_tracker.sequences import messages
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages, typestore
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import CompressedImage
from cable_tracker.sequences.messages import (
    cable,
    frame_report,
    headers,
    images,
    target,
)
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import TrackingStatus

STATE = CableState(12.5, -0.3, 40.25, 0.01, -3.0, 0.2, 1.5, -0.01)
COVARIANCE = np.diag([1.0, 1e-3, 2.0, 1e-4, 5.0, 1e-2, 3.0, 1e-3]) + 1e-5
CLOUD = np.random.default_rng(1).normal(size=(9, 9))
GREY = np.random.default_rng(2).integers(0, 256, (6, 8), dtype=np.uint8)
ESTIMATE = CableEstimate(
    5, TrackingStatus.TRACKING, STATE, COVARIANCE, 123.4, 2.5, (320, 240), "é, because",
    presence=0.98, hypotheses=(Hypothesis(0.91, STATE), Hypothesis(0.08, STATE)),
)  # fmt: skip

TARGET = TargetEstimate(
    5, TrackingStatus.TRACKING, (320, 240), np.array([12.0, -8.0, 0.25, 0.3, 2.0, -1.0]),
    np.diag([4.0, 9.0, 0.01, 0.04, 1.0, 1.0]), box=(150.0, 100.0, 190.5, 140.0),
    outline=np.array([[150.0, 100.0], [190.5, 100.0], [170.0, 140.0]]), area=810.5,
)  # fmt: skip
POSES = Particles.equally_weighted(np.random.default_rng(3).normal(size=(7, 6)))

Make = Callable[[Any, Any], Any]

MESSAGES: dict[str, Make] = {
    "time": lambda f, h: headers.make_time(f, 1_700_000_000_123_456_789),
    "time before 1970": lambda f, h: headers.make_time(f, -1),
    "header": lambda f, h: h,
    "image": lambda f, h: images.make_image(f, raw_from_array(GREY, "mono8"), h),
    "compressed image": lambda f, h: images.make_compressed_image(
        f, CompressedImage("jpeg", memoryview(b"\xff\xd8\x00")), h
    ),
    "state": lambda f, h: cable.make_state(f, h, STATE, (1.0, 0.1, 2.0, 0.2)),
    "state of truth": lambda f, h: cable.make_state(f, h, STATE),
    "no state": lambda f, h: cable.make_state(f, h, None, (1.0, 0.1, 2.0, 0.2)),
    "centreline": lambda f, h: cable.make_centreline(f, h, STATE, COVARIANCE),
    "particles": lambda f, h: cable.make_particles(f, h, CLOUD),
    "no particles": lambda f, h: cable.make_particles(f, h, CLOUD[:0]),
    "markers": lambda f, h: cable.make_markers(f, h, STATE, (320, 240)),
    "no markers": lambda f, h: cable.make_markers(f, h, None, (320, 240)),
    "markers outside": lambda f, h: cable.make_markers(
        f, h, CableState(900.0, 0.1, 20.0), (320, 240)
    ),
    "report": lambda f, h: frame_report.make_report(
        f, h, "TRACKING", cable.report_values(ESTIMATE, 1.25)
    ),
    "refusal": lambda f, h: frame_report.make_report(f, h, "REFUSED", {"event": "too small"}),
    "target": lambda f, h: target.make_target(f, h, TARGET),
    "relative pose": lambda f, h: target.make_relative_pose(f, h, np.arange(3.0), np.eye(3)),
    "state of a target": lambda f, h: target.make_target_state(f, h, TARGET),
    "no state of a target": lambda f, h: target.make_target_state(f, h, None),
    "contour": lambda f, h: target.make_polygon(f, h, TARGET.outline),
    "bearing": lambda f, h: target.make_bearing(f, h, np.array([0.0, 0.6, 0.8])),
    "particles of a target": lambda f, h: target.make_target_particles(f, h, POSES),
    "markers of a target": lambda f, h: target.make_target_markers(f, h, TARGET),
    "diagnostics": lambda f, h: make_diagnostics(
        f,
        h,
        "/a/tracker",
        "STALE INPUT",
        frame_values(FrameStatistics(), 0.0) | cable_values(ESTIMATE),
    ),
}


@pytest.fixture(params=list(MESSAGES))
def make(request: pytest.FixtureRequest) -> Make:
    return MESSAGES[request.param]


def made_by(factory: Any, make: Make) -> Any:
    return make(factory, headers.make_header(factory, 1_700_000_000_040_000_000, "camera"))


def type_name(message: Any) -> str:
    module = type(message).__module__.split(".")
    return f"{module[0]}/msg/{type(message).__name__}"


def rclpy_bytes(make: Make, length: int) -> bytes:
    message = made_by(RclpyMessages(), make)
    # rmw_serialize leaves some bytes at the end that mean nothing, and the gaps of the alignment
    # as they are in memory; rosbags fills these with zeros.
    data = serialize_message(message)[:length]
    content = typestore().deserialize_cdr(data, type_name(message))
    return bytes(typestore().serialize_cdr(content, type_name(message)))


def rosbags_bytes(make: Make) -> bytes:
    message = made_by(RosbagsMessages(), make)
    return bytes(typestore().serialize_cdr(message, message.__msgtype__))


def test_rclpy_and_rosbags_serialise_to_the_same_bytes(make: Make) -> None:
    expected = rosbags_bytes(make)
    assert rclpy_bytes(make, len(expected)) == expected


def test_the_bytes_are_read_back_as_the_same_message(make: Make) -> None:
    message = made_by(RclpyMessages(), make)
    kind = type(message)
    # Colours are float32 once they have been serialised.
    sent = deserialize_message(serialize_message(message), kind)
    assert deserialize_message(rosbags_bytes(make), kind) == sent


def makers() -> dict[str, Any]:
    """Functions that pack messages, by name."""
    modules = [
        import_module(f"{messages.__name__}.{each.name}")
        for each in iter_modules(messages.__path__)
    ]
    return {
        name: value
        for module in modules
        for name, value in vars(module).items()
        if name.startswith("make_")
    }


def test_every_function_that_makes_a_message_is_compared() -> None:
    functions = makers()
    assert "make_state" in functions
    used = {name for make in MESSAGES.values() for name in make.__code__.co_names}
    parts = {name for function in functions.values() for name in function.__code__.co_names}
    assert set(functions) <= used | parts | {"make_header"}


def test_message_classes_are_found_by_name() -> None:
    assert type_name(message_class("sensor_msgs/msg/JointState")()) == "sensor_msgs/msg/JointState"


def test_pixels_are_passed_on_at_once() -> None:
    octets = RclpyMessages().octets(memoryview(GREY.reshape(-1)))
    assert octets.tobytes() == GREY.tobytes()  # type: ignore[attr-defined]
