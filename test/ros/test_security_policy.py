"""The SROS2 policy allows what the nodes do, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from cable_tracker.resources import resource

SECURITY_POLICY = Path("config") / "sros2" / "cable_tracker_policy.xml"


def rules(node: str, kind: str, right: str) -> set[str]:
    """Full names that the policy allows a node in the root namespace."""
    profile = ElementTree.parse(resource(SECURITY_POLICY)).find(
        f"./enclaves/enclave[@path='/cable_tracker/{node}']/profiles/profile[@node='{node}']"
    )
    assert profile is not None and profile.get("ns") == "/"
    names = [
        str(rule.text) for group in profile.findall(f"{kind}s[@{right}='ALLOW']") for rule in group
    ]
    assert len(names) == len(set(names))
    return {full(name, node) for name in names}


def full(name: str, node: str) -> str:
    if name.startswith("~/"):
        return f"/{node}/{name[2:]}"
    return name if name.startswith("/") else f"/{name}"


def used(node: Any, namespace: str) -> tuple[set[str], set[str], set[str]]:
    """What a node publishes, reads and serves, without its namespace."""
    me = (node.get_name(), namespace)
    return tuple(  # type: ignore[return-value]
        {name.removeprefix(namespace) for name, _ in found(*me)}
        for found in (
            node.get_publisher_names_and_types_by_node,
            node.get_subscriber_names_and_types_by_node,
            node.get_service_names_and_types_by_node,
        )
    )


def union(sets: list[tuple[set[str], ...]]) -> list[set[str]]:
    return [set().union(*each) for each in zip(*sets, strict=True)]


def test_the_policy_allows_exactly_the_topics_and_services_of_the_tracker(world: Any) -> None:
    seen = []
    for transport, reliability in (("raw", "reliable"), ("compressed", "best_effort")):
        node = world.tracker(
            image_transport=transport, instrument_reliability=reliability, use_sim_time=True
        )
        seen.append(used(node, world.namespace))
        world.remove(node)
    published, read, served = union(seen)
    assert published == rules("tracker", "topic", "publish")
    assert read == rules("tracker", "topic", "subscribe")
    assert served == rules("tracker", "service", "reply")


@pytest.mark.parametrize("clock", [True, False])
def test_the_policy_allows_exactly_the_topics_and_services_of_the_replay(
    world: Any, make_dive: Callable[..., Path], vehicle_bag: Path, clock: bool
) -> None:
    seen = []
    for path in (make_dive(2, jpeg=True), vehicle_bag):
        node = world.replay(
            source=str(path), paused=True, publish_clock=clock, use_sim_time=not clock
        )
        seen.append(used(node, world.namespace))
        world.remove(node)
    published, read, served = union(seen)
    # Frames of the vehicle are sent where their messages are installed.
    assert published | {"/clock", "/tf_static"} == rules("replay", "topic", "publish")
    assert read | {"/clock"} == rules("replay", "topic", "subscribe")
    assert served == rules("replay", "service", "reply")
