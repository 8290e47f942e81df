from __future__ import annotations

from typing import Any

import pytest
from builtin_interfaces.msg import Time
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Imu, JointState
from std_msgs.msg import Header

from cable_tracker.node_parameter_tables import TargetVehicleParameters
from cable_tracker.ros.inputs.instrument_inputs import InstrumentInputs, InstrumentsSent
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.instruments import Instrument

SECOND = 1_000_000_000
INSTRUMENTS = (Instrument.CAMERA_INFO, Instrument.IMU, Instrument.ODOMETRY)


class NotedFusion:
    """Notes what it is given."""

    def __init__(self, parameters: TargetVehicleParameters) -> None:
        self.parameters = parameters
        self.taken: list[tuple[Instrument, int]] = []

    def configure(self, parameters: TargetVehicleParameters) -> None:
        self.parameters = parameters

    def take_message(self, instrument: Instrument, stamp: int, _message: Any) -> None:
        self.taken.append((instrument, stamp))


@pytest.fixture
def make(world: Any) -> Any:
    def made(required: Any = ()) -> tuple[InstrumentInputs[Any, Any], NotedFusion]:
        inputs = InstrumentInputs(
            world.me, TargetVehicleParameters(), NotedFusion, INSTRUMENTS, required
        )
        return inputs, inputs.fusion

    return made


def test_messages_are_handed_on_with_their_stamps(make: Any) -> None:
    inputs, fusion = make()
    inputs.take_message(Instrument.IMU, Imu(header=Header(stamp=Time(sec=2))))
    assert fusion.taken == [(Instrument.IMU, 2 * SECOND)]


def test_a_message_without_a_stamp_counts_as_of_now(make: Any, world: Any) -> None:
    inputs, fusion = make()
    before = world.me.get_clock().now().nanoseconds
    inputs.take_message(Instrument.IMU, Imu())
    assert before <= fusion.taken[0][1] <= world.me.get_clock().now().nanoseconds


def test_each_instrument_has_a_topic_of_its_name(make: Any, world: Any) -> None:
    inputs, fusion = make()
    news: list[int] = []
    inputs.subscribe("reliable", lambda: news.append(len(fusion.taken)))
    for index, (topic, kind) in enumerate(
        (("camera_info", CameraInfo), ("imu", Imu), ("odometry", Odometry))
    ):
        publisher = world.me.create_publisher(kind, topic, 10)
        world.spin(publisher.get_subscription_count)
        publisher.publish(kind(header=Header(stamp=Time(sec=1))))
        world.spin(lambda count=index + 1: len(news) == count)
    assert fusion.taken == [(each, SECOND) for each in INSTRUMENTS]
    assert news == [1, 2, 3]


def test_messages_are_counted_as_their_sender_counts_them(make: Any, world: Any) -> None:
    inputs, fusion = make()
    publisher = world.me.create_publisher(Imu, "imu", 10)
    for _ in range(4):
        publisher.publish(Imu(header=Header(stamp=Time(sec=1))))
    inputs.subscribe("reliable", lambda: None)
    world.spin(publisher.get_subscription_count)
    publisher.publish(Imu(header=Header(stamp=Time(sec=2))))
    world.spin(lambda: fusion.taken)
    assert inputs._sent._heard == {"imu": 5}


def test_an_instrument_once_heard_is_awaited_up_to_the_stamp_of_the_frame(make: Any) -> None:
    inputs, _ = make()
    inputs.take_message(Instrument.IMU, Imu(header=Header(stamp=Time(sec=2))))
    assert not inputs.has_all_of(2 * SECOND)
    inputs.take_message(Instrument.CAMERA_INFO, CameraInfo(header=Header(stamp=Time(sec=1))))
    assert inputs.has_all_of(2 * SECOND)
    inputs.take_message(Instrument.ODOMETRY, Odometry(header=Header(stamp=Time(sec=1))))
    assert not inputs.has_all_of(2 * SECOND)


def test_a_calibration_alone_is_not_all(make: Any) -> None:
    inputs, _ = make()
    inputs.take_message(Instrument.CAMERA_INFO, CameraInfo(header=Header(stamp=Time(sec=1))))
    assert not inputs.has_all_of(0)


def test_a_required_instrument_is_awaited_before_its_first_message(make: Any) -> None:
    inputs, _ = make({Instrument.ODOMETRY})
    inputs.take_message(Instrument.CAMERA_INFO, CameraInfo(header=Header(stamp=Time(sec=1))))
    inputs.take_message(Instrument.IMU, Imu(header=Header(stamp=Time(sec=2))))
    assert not inputs.has_all_of(2 * SECOND)
    inputs.take_message(Instrument.ODOMETRY, Odometry(header=Header(stamp=Time(sec=2))))
    assert inputs.has_all_of(2 * SECOND)


def test_messages_that_a_replay_has_counted_are_awaited(make: Any) -> None:
    inputs, _ = make()
    inputs._sent.take(JointState(header=Header(stamp=Time(sec=2)), name=["imu"], position=[1.0]))
    assert not inputs.has_all_of(2 * SECOND)
    inputs.take_message(Instrument.IMU, Imu(header=Header(stamp=Time(sec=1))))
    assert inputs.has_all_of(2 * SECOND)


def test_parameters_of_the_fusion_reach_it_and_others_do_not(make: Any) -> None:
    inputs, fusion = make()
    before = fusion.parameters
    inputs.apply({"particle_count": 3})
    assert fusion.parameters == before == TargetVehicleParameters()
    inputs.apply({"camera_x": 0.5, "instrument_wait": 2.0, "base_frame": "rov", "other": 1})
    assert fusion.parameters == TargetVehicleParameters(
        camera_x=0.5, instrument_wait=2.0, base_frame="rov"
    )


def told(sec: int, **counts: float) -> JointState:
    header = Header()
    header.stamp.sec = sec
    return JointState(header=header, name=list(counts), position=list(counts.values()))


def test_nothing_was_sent_at_first() -> None:
    assert not InstrumentsSent((node_topics.IMU,)).tells_of(0)


def sent(**heard: int) -> InstrumentsSent:
    made = InstrumentsSent((node_topics.IMU, node_topics.ODOMETRY))
    for name, number in heard.items():
        made.hear(name, number)
    return made


def test_all_messages_have_come_when_as_many_were_heard_as_sent() -> None:
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


def test_instruments_that_the_node_does_not_read_are_not_awaited() -> None:
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
