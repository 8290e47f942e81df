from __future__ import annotations

from cable_tracker.ros.process.node_group import NodeGroup


def test_nodes_stand_in_the_namespace_under_the_names_that_are_given(namespace, world):
    with NodeGroup(namespace, {"cmd_vel": "thrust"}) as group:
        group.start("controller", {"speed": 0.3}, {"state": "seen"})
        infos = (
            lambda: world.me.get_publishers_info_by_topic(f"{namespace}/thrust"),
            lambda: world.me.get_publishers_info_by_topic(f"{namespace}/diagnostics"),
            lambda: world.me.get_subscriptions_info_by_topic(f"{namespace}/seen"),
        )
        world.spin(lambda: all(info() for info in infos) or group.what_has_died())
        assert group.what_has_died() == ""


def test_a_node_that_ends_with_an_error_has_died(namespace, stand_in):
    stand_in("import sys; sys.exit('error: there is no such file')\n")
    with NodeGroup(namespace) as group:
        process = group.start("replay", {"source": "/nowhere"}, may_end=True)
        assert process.wait(300.0)
        words = "the replay node has died: error: there is no such file"
        assert group.what_has_died() == words


def test_a_process_ends_with_the_group(namespace):
    with NodeGroup(namespace) as group:
        process = group.start("follower", {})
        assert process.running
    assert not process.running
