from __future__ import annotations

import math
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, Quaternion
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo, Imu, JointState, Range
from std_srvs.srv import SetBool

from cable_tracker.cable.model.state import CableState
from cable_tracker.ros.inputs import frame_hold
from cable_tracker.ros.nodes.cable_inputs import MOUNTING_NOT_GIVEN, ODOMETRY_ADVICE
from cable_tracker.ros.qos import LATCHED, RESULTS
from cable_tracker.sequences.bags.instruments import Instrument

ALTITUDE, FOCAL = 1.4, 280.0
K = [FOCAL, 0.0, 159.5, 0.0, FOCAL, 119.5, 0.0, 0.0, 1.0]


class Vehicle:
    """Publishes what its instruments measure, and shows frames to a tracker."""

    def __init__(self, world: Any, node: Any, image_message: Callable[..., Any]) -> None:
        self._world, self._node, self._image = world, node, image_message
        self._publishers = {
            topic: world.me.create_publisher(kind, topic, 10)
            for kind, topic in (
                (CameraInfo, "camera_info"),
                (Range, "altitude"),
                (Imu, "imu"),
                (Odometry, "odometry"),
            )
        }
        self._index = 0
        self._states = world.listen(JointState, "state")
        self.foot = world.listen(PoseWithCovarianceStamped, "cross_track")
        self.ahead = world.listen(PoseWithCovarianceStamped, "cross_track_ahead")
        world.spin(lambda: all(each.get_subscription_count() for each in self._publishers.values()))

    def sends(self, topic: str, message: Any) -> None:
        message.header = self._image(index=self._index).header
        heard = self._node._instruments._sent._heard
        before = heard.get(topic, 0)
        self._publishers[topic].publish(message)
        self._world.spin(lambda: heard.get(topic, 0) > before)

    def is_calibrated(self, **fields: Any) -> None:
        given = {"width": 320, "height": 240, "distortion_model": "plumb_bob", "k": K}
        self.sends("camera_info", CameraInfo(**{**given, **fields}))

    def measures(self, altitude: float) -> None:
        self.sends("altitude", Range(range=altitude, min_range=0.1, max_range=30.0))

    def rolls(self, roll: float) -> None:
        orientation = Quaternion(x=math.sin(roll / 2), w=math.cos(roll / 2))
        self.sends("imu", Imu(orientation=orientation))

    def sways(self, velocity: float) -> None:
        message = Odometry()
        message.twist.twist.linear.y = velocity
        self.sends("odometry", message)

    def sees(self, count: int = 1) -> None:
        """Show frames of the strip, and wait for the answers."""
        wanted = len(self._states) + count
        for _ in range(count):
            self._world.show(self._node, self._image(index=self._index))
            self._index += 1
        self._world.spin(lambda: len(self._states) >= wanted)
        # What a frame gives in metres is sent before its state.
        self._world.empty_queues()


@pytest.fixture
def start(world: Any, near: str, image_message: Callable[..., Any]) -> Callable[..., Any]:
    def make(**parameters: Any) -> tuple[Any, Vehicle]:
        node = world.tracker(initial_state=near, **parameters)
        return node, Vehicle(world, node, image_message)

    return make


def yaw_of(message: PoseWithCovarianceStamped) -> float:
    orientation = message.pose.pose.orientation
    return 2 * math.atan2(orientation.z, orientation.w)


def test_a_calibrated_camera_and_an_altitude_give_metres(
    start: Callable[..., Any], truth: CableState
) -> None:
    _, vehicle = start(look_ahead=2.0)
    vehicle.is_calibrated()
    vehicle.measures(ALTITUDE)
    vehicle.sees(3)
    foot, ahead = vehicle.foot[-1], vehicle.ahead[-1]
    offset = -truth.distance / math.cos(truth.angle) * ALTITUDE / FOCAL
    assert foot.header.frame_id == "base_link"
    assert foot.pose.pose.position.y == pytest.approx(offset, abs=0.01)
    assert yaw_of(foot) == pytest.approx(truth.angle, abs=0.03)
    assert (foot.pose.pose.position.x, ahead.pose.pose.position.x) == (0.0, 2.0)
    assert ahead.pose.pose.position.y == pytest.approx(
        foot.pose.pose.position.y + 2.0 * math.tan(yaw_of(foot)), abs=0.01
    )
    assert 0.0 < foot.pose.covariance[7] < ahead.pose.covariance[7] < 1.0


@pytest.mark.parametrize(
    ("parameters", "is_told"),
    [({}, True), ({"camera_z": -0.1}, False), ({"camera_pitch": 90.0}, False)],
)
def test_a_missing_mounting_is_reported_once_with_the_first_metres(
    start: Callable[..., Any],
    capfd: pytest.CaptureFixture[str],
    parameters: dict[str, float],
    is_told: bool,
) -> None:
    _, vehicle = start(**parameters)
    vehicle.is_calibrated()
    vehicle.sees(3)
    assert MOUNTING_NOT_GIVEN not in capfd.readouterr().err
    vehicle.measures(ALTITUDE)
    vehicle.sees(3)
    assert vehicle.foot
    said = capfd.readouterr().err
    assert said.count(MOUNTING_NOT_GIVEN) == is_told
    assert ("[WARN]" in said) == is_told


def test_without_calibration_there_are_no_metres_and_diagnostics_say_why(
    start: Callable[..., Any], said: Callable[..., str]
) -> None:
    node, vehicle = start(diagnostics_period=0.05)
    vehicle.measures(ALTITUDE)
    vehicle.sees(3)
    assert vehicle.foot == [] == vehicle.ahead
    assert "no camera calibration" in said(node, "no metres")


@pytest.mark.parametrize(
    ("altitude", "info", "parameters", "words"),
    [
        (math.nan, {}, {}, "unusable altitude"),
        (ALTITUDE, {"width": 640, "height": 360}, {}, "calibration of another image size"),
        (ALTITUDE, {"k": [0.0] * 9}, {}, "unusable camera calibration"),
        (ALTITUDE, {}, {"camera_pitch": 0.0}, "camera does not look down"),
        (ALTITUDE, {}, {"camera_z": -2.0}, "camera not above the cable"),
    ],
)
def test_bad_input_gives_no_metres_and_the_diagnostics_name_it(
    start: Callable[..., Any],
    said: Callable[..., str],
    world: Any,
    altitude: float,
    info: dict[str, Any],
    parameters: dict[str, Any],
    words: str,
) -> None:
    node, vehicle = start(**parameters)
    vehicle.is_calibrated(**info)
    vehicle.measures(altitude)
    vehicle.sees(3)
    assert vehicle.foot == [] == vehicle.ahead
    assert said(node, "no metres").startswith(words)


def test_an_altimeter_that_a_fixed_altitude_replaces_is_reported(
    start: Callable[..., Any], said: Callable[..., str]
) -> None:
    node, vehicle = start(fixed_altitude=ALTITUDE, instrument_timeout=0.01)
    vehicle.is_calibrated()
    vehicle.measures(2.0 * ALTITUDE)
    vehicle.sees()
    assert said(node, "no altimeter") == ""
    vehicle.sees(2)
    assert vehicle.foot[-1].pose.pose.position.z == pytest.approx(-ALTITUDE, rel=0.01)
    assert said(node, "no altimeter").startswith("fixed_altitude stands in")


def test_the_roll_of_the_imu_is_corrected(start: Callable[..., Any]) -> None:
    _, vehicle = start(fixed_altitude=ALTITUDE)
    vehicle.is_calibrated()
    vehicle.sees(3)
    level = vehicle.foot[-1].pose.pose.position.y
    vehicle.rolls(0.1)
    vehicle.sees()
    rolled = vehicle.foot[-1].pose.pose.position.y
    assert rolled - level == pytest.approx(ALTITUDE * math.tan(0.1), rel=0.1)


def test_the_mounting_can_be_set_while_it_runs(start: Callable[..., Any]) -> None:
    node, vehicle = start(fixed_altitude=ALTITUDE)
    vehicle.is_calibrated()
    vehicle.sees(3)
    before = vehicle.foot[-1].pose.pose.position.y
    results = node.set_parameters(
        [Parameter("camera_y", value=0.5), Parameter("base_frame", value="rov")]
    )
    assert all(result.successful for result in results)
    vehicle.sees()
    assert vehicle.foot[-1].pose.pose.position.y - before == pytest.approx(0.5, abs=0.01)
    assert vehicle.foot[-1].header.frame_id == "rov"


def test_a_mounting_out_of_range_is_refused(start: Callable[..., Any]) -> None:
    node, _ = start()
    result = node.set_parameters([Parameter("camera_pitch", value=400.0)])[0]
    assert not result.successful


def test_odometry_reaches_the_filter(start: Callable[..., Any], said: Callable[..., str]) -> None:
    node, vehicle = start(fixed_altitude=ALTITUDE)
    vehicle.is_calibrated()
    vehicle.sees(2)
    assert said(node, "no motion aid") == "no odometry has come"
    for index in range(30):
        vehicle.sways(1e-4 * (-1) ** index)
        vehicle.sees()
    assert said(node, "no motion aid") == ""


def test_odometry_that_disagrees_is_reported(
    start: Callable[..., Any],
    said: Callable[..., str],
    world: Any,
    capfd: pytest.CaptureFixture[str],
) -> None:
    node, vehicle = start(fixed_altitude=ALTITUDE)
    vehicle.is_calibrated()
    for index in range(12):
        vehicle.sways(1.5 + 0.001 * index)
        vehicle.sees()
    assert "disagrees" in said(node, "no motion aid")
    told = capfd.readouterr().err
    assert "goes on without odometry" in told and ODOMETRY_ADVICE in told


def test_the_aid_can_be_switched_off(start: Callable[..., Any], said: Callable[..., str]) -> None:
    node, vehicle = start(fixed_altitude=ALTITUDE, motion_aid=False)
    vehicle.sees()
    assert said(node, "no motion aid") == "the parameter motion_aid is false"


class Instruments:
    """Speaks for the time of one frame."""

    def __init__(self, world: Any, node: Any, image_message: Callable[..., Any]) -> None:
        self.world, self.node, self.image = world, node, image_message
        self.states = world.listen(JointState, "state")

    def show(self, index: int) -> None:
        self.world.show(self.node, self.image(index=index))

    def speak(self, index: int) -> None:
        header = self.image(index=index).header
        take = self.node._instruments.take_message
        take(
            Instrument.CAMERA_INFO,
            CameraInfo(header=header, width=320, height=240, distortion_model="plumb_bob", k=K),
        )
        take(Instrument.IMU, Imu(header=header, orientation=Quaternion(w=1.0)))
        take(Instrument.ODOMETRY, Odometry(header=header))
        take(Instrument.ALTITUDE, Range(header=header, range=1.4, max_range=30.0))

    def has_answers(self, count: int) -> None:
        self.world.spin(lambda: len(self.states) >= count)

    def has_no_more_than(self, count: int) -> None:
        self.world.pass_time(0.4)
        assert len(self.states) == count


@pytest.fixture
def instruments(world: Any, near: str, image_message: Callable[..., Any]) -> Callable[..., Any]:
    def make(**parameters: Any) -> Instruments:
        node = world.tracker(initial_state=near, **parameters)
        made = Instruments(world, node, image_message)
        world.spin(node._outputs._states[0].get_subscription_count)
        return made

    return make


def test_a_frame_waits_for_the_instruments_of_its_time(instruments: Callable[..., Any]) -> None:
    vehicle = instruments(instrument_wait=60.0)
    vehicle.speak(0)
    vehicle.show(1)
    vehicle.has_no_more_than(0)
    vehicle.speak(1)
    vehicle.has_answers(1)
    vehicle.show(2)
    vehicle.has_no_more_than(1)


def test_a_frame_waits_no_longer_than_it_may(
    instruments: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle = instruments(instrument_wait=60.0)
    # Not until the watchdog comes, which may be later by its period.
    monkeypatch.setattr(vehicle.node, "on_watchdog", lambda: None)
    before = time.perf_counter()
    vehicle.show(0)
    after = time.perf_counter()
    clock = SimpleNamespace(perf_counter=lambda: before + 59.9)
    monkeypatch.setattr(frame_hold, "time", clock)
    assert vehicle.node.seconds_until_due() > 0.0
    vehicle.has_no_more_than(0)
    clock.perf_counter = lambda: after + 60.1
    assert vehicle.node.seconds_until_due() < 0.0
    vehicle.has_answers(1)


def is_disabled(vehicle: Instruments) -> None:
    vehicle.node.on_enable(SetBool.Request(data=False), SetBool.Response())
    vehicle.show(1)


def waits_no_more(vehicle: Instruments) -> None:
    vehicle.node.set_parameters([Parameter("instrument_wait", value=0.0)])
    vehicle.show(1)


def is_shown_a_frame_without_time(vehicle: Instruments) -> None:
    message = vehicle.image(index=1)
    message.header.stamp.sec = message.header.stamp.nanosec = 0
    vehicle.world.show(vehicle.node, message)


@pytest.mark.parametrize("goes_on", [is_disabled, waits_no_more, is_shown_a_frame_without_time])
def test_a_frame_that_need_not_wait_does_not_overtake_one_that_waits(
    instruments: Callable[..., Any], goes_on: Callable[[Instruments], None]
) -> None:
    vehicle = instruments(instrument_wait=60.0)
    vehicle.show(0)
    goes_on(vehicle)
    vehicle.has_answers(1)
    assert vehicle.states[0].header.stamp == vehicle.image(index=0).header.stamp
    vehicle.has_answers(2)


@pytest.mark.parametrize("reliability", ["best_effort", "reliable"])
def test_the_reliability_of_instruments_is_that_of_the_parameter(
    world: Any, reliability: str
) -> None:
    policies = {
        subscription.topic_name.rpartition("/")[2]: subscription.qos_profile.reliability.name
        for subscription in world.tracker(instrument_reliability=reliability).subscriptions
    }
    for topic in ("camera_info", "altitude", "imu", "odometry"):
        assert policies[topic] == reliability.upper()


@pytest.mark.parametrize(("profile", "is_heard"), [(LATCHED, True), (RESULTS, False)])
def test_a_calibration_sent_once_before_is_heard_where_it_is_kept(world, profile, is_heard):
    driver = world.me.create_publisher(CameraInfo, "camera_info", profile)
    driver.publish(CameraInfo(width=320, height=240, distortion_model="plumb_bob", k=K))
    node = world.tracker()
    world.spin(driver.get_subscription_count)
    world.pass_time(1.5)
    assert node._instruments._sent.has_heard("camera_info") == is_heard
    assert driver.get_subscription_count() == (2 if is_heard else 1)
