from __future__ import annotations

import pytest

pytest.importorskip("nicegui", reason="the windows need the extra `gui`")


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("--seed", 7), "--seed"),
        (("--preset", "pipeline"), "--preset"),
        (("--params", "mine.yaml"), "--params"),
        (("--init", "truth"), "--init"),
        (("--topic", "/cam"), "--topic"),
        (("--rate", 5), "--rate"),
        (("--skip-bad-frames",), "--skip-bad-frames"),
        (("--odometry-topic", "/odom"), "--odometry-topic"),
    ],
)
def test_options_that_would_not_reach_a_live_node_are_refused(command, arguments, name):
    code, _, told = command("gui", "--ros", "/", *arguments)
    assert code == 2
    assert f"{name} would not reach the node" in told


def test_an_altitude_is_refused_for_a_target(command):
    code, _, told = command("gui", "--target", "--altitude-topic", "/altitude")
    assert code == 2
    assert "--altitude-topic can do nothing with --target" in told
