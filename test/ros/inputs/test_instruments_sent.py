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


def sent(**heard: int) -> InstrumentsSent:
    made = InstrumentsSent((node_topics.IMU, node_topics.ODOMETRY))
    for name, number in heard.items():
        made.hear(name, number)
    return made


def test_all_has_come_when_as_much_was_heard_as_was_sent() -> None:
    own = sent()
    own.take(told(2, imu=2.0, odometry=1.0))
    assert own.tells_of(2_000_000_000)
    assert not own.tells_of(1_000_000_000)
    assert not own.has_come()
    for name in ("imu", "odometry"):
        own.hear(name, None)
        assert not own.has_come()
    own.hear("imu", None)
    assert own.has_come()


def test_what_the_node_does_not_listen_to_does_not_count() -> None:
    own = sent(imu=1)
    own.take(told(2, imu=1.0, altitude=5.0))
    assert own.has_come()


def test_messages_from_before_the_node_listened_need_not_come() -> None:
    own = sent(imu=101)
    own.take(told(2, imu=101.0))
    assert own.has_come()


def test_those_of_another_replay_must_come_themselves() -> None:
    own = sent(imu=100)
    own.take(told(2, imu=100.0))
    own.take(told(1, imu=1.0))
    assert not own.has_come()
    own.hear("imu", 1)
    assert own.has_come()
