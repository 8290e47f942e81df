"""Nodes started with the arguments that the launch files give them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from rcl_interfaces.srv import GetParameters

from cable_tracker.ros.process.child_process import NodeProcess
from cable_tracker.ros.process.environment import local_environment

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def values(world: Any, node: str, *names: str) -> list[Any]:
    client = world.me.create_client(GetParameters, f"{node}/get_parameters")
    world.spin(client.service_is_ready)
    future = client.call_async(GetParameters.Request(names=names))
    world.spin(future.done)
    world.me.destroy_client(client)
    return list(future.result().values)


def test_a_tracker_takes_arguments_and_file_and_the_file_prevails(
    world: Any, jazzy: Any, namespace: str, tmp_path: Path, stack: ExitStack
) -> None:
    own = tmp_path / "own.yaml"
    own.write_text(
        "/**/tracker: {ros__parameters: {width_maximum: 150, image_reliability: reliable}}"
    )
    context = jazzy.run(
        ROOT / "launch" / "tracker.launch.py", {"cable_tracker": ROOT},
        namespace=namespace, preset="thesis", image="/some/eye", params_file=str(own),
        image_transport="compressed", log_level="warn",
    )  # fmt: skip
    (node,) = context.started
    stack.enter_context(NodeProcess(node.executable, node.arguments(tmp_path), local_environment()))
    names = ("preset", "width_maximum", "image_reliability", "image_transport", "use_sim_time")
    preset, width, reliability, transport, simulated = values(world, f"{namespace}/tracker", *names)
    assert preset.string_value == "thesis"
    assert width.double_value == 150.0
    assert reliability.string_value == "reliable"
    assert transport.string_value == "compressed"
    assert simulated.bool_value is False


@pytest.mark.slow
def test_the_nodes_of_the_loop_read_their_parts_of_one_file(
    world: Any, jazzy: Any, namespace: str, tmp_path: Path, stack: ExitStack
) -> None:
    context = jazzy.run(
        ROOT / "launch" / "loop.launch.py", {"cable_tracker": ROOT},
        namespace=namespace, seed="3", length="20",
    )  # fmt: skip
    nodes = {node.executable: node for node in context.started}
    for name in ("simulator", "controller"):
        arguments = nodes[name].arguments(tmp_path)
        stack.enter_context(NodeProcess(name, arguments, local_environment()))
    seed, length, readers = values(
        world, f"{namespace}/simulator", "seed", "length", "odometry_readers"
    )
    assert seed.integer_value == 3
    assert length.double_value == 20.0
    assert readers.integer_value == 2
    (speed,) = values(world, f"{namespace}/controller", "speed")
    assert speed.double_value == 0.5
