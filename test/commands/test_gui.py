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
    ],
)
def test_what_a_live_node_would_not_hear_of_is_refused(command, arguments, name):
    code, _, told = command("gui", "--ros", "/", *arguments)
    assert code == 2
    assert f"{name} would not reach the node" in told


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("--ros", "/", "--odometry-topic", "/odom"), "topics of instruments"),
        (("--target", "--altitude-topic", "/altitude"), "--altitude-topic"),
    ],
)
def test_instruments_that_would_not_count_are_refused(command, arguments, name):
    code, _, told = command("gui", *arguments)
    assert code == 2
    assert name in told
