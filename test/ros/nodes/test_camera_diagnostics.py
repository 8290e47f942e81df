from __future__ import annotations

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image

from cable_tracker.ros.nodes import camera_diagnostics
from cable_tracker.ros.nodes.camera_diagnostics import remark_on


def test_diagnostics_come_with_their_period_and_hold_the_figures(
    world: Any, image_message: Callable[..., Any], diagnostics: Callable[..., list[Any]]
) -> None:
    node = world.tracker(diagnostics_period=0.1, frozen_timeout=0.0)
    sent = iter(range(100_000))

    def tells_a_rate() -> bool:
        world.show(node, image_message(index=next(sent)))
        node.publish_diagnostics()
        return any(float(values["frame rate [1/s]"]) > 0.0 for _, values in diagnostics(node))

    world.spin(tells_a_rate)
    shown = str(next(sent))
    # They come by themselves, too.
    world.spin(lambda: diagnostics(node)[-1][1]["frames tracked"] == shown)
    count = len(diagnostics(node))
    world.spin(lambda: len(diagnostics(node)) >= count + 4)
    values = diagnostics(node)[-1][1]
    assert float(values["latency median [ms]"]) > 0.0
    assert float(values["N_eff"]) >= 1.0
    assert values["frames tracked"] == shown
    assert values["frames dropped"] == "0"


def test_two_cameras_on_one_topic_are_named(
    world: Any, diagnostics: Callable[..., list[Any]], capfd: pytest.CaptureFixture[str]
) -> None:
    node = world.tracker(diagnostics_period=0.1)
    cameras = [
        world.add(Node(name, context=world.context, namespace=world.namespace))
        for name in ("port", "starboard")
    ]
    cameras[0].create_publisher(Image, "image", 1)
    world.spin(lambda: world.me.count_publishers(f"{world.namespace}/image") == 1)
    node.publish_diagnostics()
    world.spin(lambda: diagnostics(node))
    assert diagnostics(node)[-1][1]["several cameras"] == ""
    cameras[1].create_publisher(Image, "image", 1)
    names = f"{world.namespace}/port, {world.namespace}/starboard"
    world.spin(lambda: diagnostics(node)[-1][1]["several cameras"] == names)
    assert f"2 nodes publish {world.namespace}/image: {names}" in capfd.readouterr().err


def test_images_of_the_other_type_are_reported_and_are_no_second_camera(
    world: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = world.tracker(diagnostics_period=3600.0)
    # One process cannot have both types under one name.
    publishers = [endpoint("CompressedImage")]
    monkeypatch.setattr(node, "get_publishers_info_by_topic", lambda _: publishers)
    assert node._input.describe_silence(2.0) == (
        f"no usable image on {world.namespace}/image for 2 s; 1 publishers there of type"
        " sensor_msgs/msg/CompressedImage, and it is read as sensor_msgs/msg/Image; set"
        " image_transport to compressed and remap `image/compressed` to it"
    )
    publishers.append(endpoint("Image"))
    assert "image_transport" not in node._input.describe_silence(2.0)
    assert node._input.several_cameras() == ""


def endpoint(kind: str) -> SimpleNamespace:
    return SimpleNamespace(
        node_name=f"sends_{kind}", node_namespace="/", topic_type=f"sensor_msgs/msg/{kind}"
    )


def test_a_restarted_camera_counts_as_one(world: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    node = world.tracker(diagnostics_period=3600.0)
    for _ in range(2):
        camera = world.add(Node("camera", context=world.context, namespace=world.namespace))
        camera.create_publisher(Image, "image", 1)
    world.spin(lambda: node.count_publishers(f"{world.namespace}/image") == 2)
    assert node._input.several_cameras() == ""
    monkeypatch.setattr("cable_tracker.ros.inputs.image_input.LEASE", 0.0)
    assert node._input.several_cameras() == ", ".join([f"{world.namespace}/camera"] * 2)


def test_a_shorter_period_counts_at_once(world: Any, diagnostics: Callable[..., list[Any]]) -> None:
    node = world.tracker(diagnostics_period=3600.0)
    node.publish_diagnostics()
    world.spin(lambda: diagnostics(node))
    count = len(diagnostics(node))
    assert node.set_parameters([Parameter("diagnostics_period", value=0.1)])[0].successful
    world.spin(lambda: len(diagnostics(node)) > count + 1)


def test_a_changed_time_out_leaves_the_other(world: Any) -> None:
    node = world.tracker(input_timeout=7.0, diagnostics_period=3600.0)
    assert node.set_parameters([Parameter("frozen_timeout", value=9.0)])[0].successful
    assert (node._watch.timeout, node._diagnostics.period) == (7.0, 3600.0)


def test_that_the_watchdog_comes_late_does_not_lengthen_the_period(
    world: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    diagnostics = world.tracker(diagnostics_period=3600.0)._diagnostics
    diagnostics.period = 1.0
    clock = SimpleNamespace()
    monkeypatch.setattr(camera_diagnostics, "time", clock)
    start = time.monotonic() + 3600.0
    sent = []
    for now in start + 0.26 * np.arange(103):
        clock.monotonic = lambda now=now: now
        if diagnostics.is_due(now):
            diagnostics.publish("TRACKING", {})
            sent.append(now)
        elif len(sent) == 10:
            # As where the status changes.
            diagnostics.publish("LOST", {})
    assert len(sent) == 27
    assert np.diff(sent).max() < 1.26


def with_a_corner(ground: int, corner: int) -> np.ndarray:
    picture = np.full((40, 60), ground, np.uint8)
    picture[:4, :4] = corner
    return picture


@pytest.mark.parametrize(
    ("picture", "words"),
    [
        (np.zeros((40, 60), np.uint8), "all pixels are the same (0 of 255)"),
        (np.full((40, 60), 255, np.uint8), "all pixels are the same (255 of 255)"),
        (with_a_corner(0, 200), "black: 99 % of the pixels"),
        (with_a_corner(255, 10), "saturated: 99 % of the pixels are white"),
        (with_a_corner(90, 120), ""),
        (np.linspace(0.1, 0.9, 40 * 60, dtype=np.float32).reshape(40, 60), ""),
        (None, ""),
    ],
)
def test_diagnostics_remark_on_odd_pictures(picture: np.ndarray | None, words: str) -> None:
    assert remark_on(picture) == words
