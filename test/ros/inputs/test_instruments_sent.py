from __future__ import annotations

from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from cable_tracker.ros.inputs.instruments_sent import InstrumentsSent
from cable_tracker.sequences import node_topics


def told(sec: int, **counts: float) -> JointState:
    header = Header()
    header.stamp.sec = sec
    return JointState(header=header, name=list(counts), position=list(counts.values()))


def test_nothing_is_told_at_first() -> None:
    assert not InstrumentsSent((node_topics.IMU,)).tells_of(0)


def test_all_has_come_when_as_much_was_heard_as_was_sent() -> None:
    sent = InstrumentsSent((node_topics.IMU, node_topics.ODOMETRY))
    sent.take(told(2, imu=2.0, odometry=1.0))
    assert sent.tells_of(2_000_000_000)
    assert not sent.tells_of(1_000_000_000)
    assert not sent.has_come({})
    assert not sent.has_come({"imu": 1, "odometry": 1})
    assert sent.has_come({"imu": 2, "odometry": 1})


def test_what_the_node_does_not_listen_to_does_not_count() -> None:
    sent = InstrumentsSent((node_topics.IMU,))
    sent.take(told(2, imu=1.0, altitude=5.0))
    assert sent.has_come({"imu": 1})
