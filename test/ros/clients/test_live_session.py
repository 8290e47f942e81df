import math
import threading
from contextlib import suppress

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.node import Node
from sensor_msgs.msg import Image

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError, RosError
from cable_tracker.ros.clients import live_session
from cable_tracker.ros.clients.live_session import LiveSession


@pytest.fixture
def session(ros_environment, namespace, monkeypatch):
    monkeypatch.setattr(live_session, "ANSWER_TIMEOUT", 300.0)
    session = LiveSession(namespace)
    yield session
    session.close()


class Asked:
    """Asks from another thread, as the page does, while the nodes are spun in this one."""

    def __init__(self, world, question):
        self.error = self.answer = None
        thread = threading.Thread(target=self._ask, args=(question,))
        thread.start()
        world.spin(lambda: not thread.is_alive())

    def _ask(self, question):
        try:
            self.answer = question()
        except (ParameterError, RosError) as error:
            self.error = error


@pytest.fixture
def found(world, session, near):
    """A tracker that the session has found."""
    tracker = world.tracker(particle_count=50, initial_state=near, input_timeout=1.0)
    world.spin(lambda: not session.trouble.startswith("no node"))
    return tracker


@pytest.fixture
def camera(world, found, image_message):
    """Return a function that sends frames until a condition holds."""
    publisher = world.me.create_publisher(Image, "image", 10)
    sent = iter(range(100_000))

    def film(condition):
        def frame_and_look():
            if condition():
                return True
            publisher.publish(image_message(index=next(sent)))
            for _ in range(10):
                world.turn()
            return False

        world.spin(frame_and_look)

    return film


def test_a_node_that_is_not_there_is_named(session, namespace):
    assert f"no node {namespace}/tracker" in session.trouble
    with pytest.raises(RosError, match="no node"):
        session.parameters()
    with pytest.raises(RosError, match="no node"):
        session.reset()


def test_a_tracker_elsewhere_is_mentioned(world, session, ros_environment):
    world.tracker()
    other = LiveSession("/nowhere")
    try:
        world.spin(lambda: world.namespace in other.trouble)
    finally:
        other.close()


def test_pictures_come_with_all_that_belongs_to_them(session, camera, truth):
    seen = None

    def is_whole():
        # On a busy machine a picture may be shown without what comes late.
        nonlocal seen
        seen = session.latest
        if seen is None or seen.row.status != "TRACKING":
            return False
        return seen.cloud is not None and seen.row.presence is not None

    camera(is_whole)
    assert seen.image.shape == (240, 320)
    assert seen.cloud.shape == (50, 9)
    assert math.isclose(seen.cloud[:, 8].sum(), 1.0, rel_tol=1e-4)
    assert abs(seen.row.state.distance - truth.distance) < 3.0
    assert len(seen.row.sigma) == 4
    assert 0.0 <= seen.row.presence <= 1.0
    assert seen.row.n_eff > 0.0
    assert seen.row.ms > 0.0


def test_listeners_hear_of_each_picture_once_and_in_order(session, camera):
    heard = []
    end = session.listen(lambda snapshot: heard.append(snapshot.number))
    camera(lambda: len(heard) >= 5)
    end()
    last = session.latest.number
    # When the next is there, what was being told when it ended has been told.
    camera(lambda: session.latest.number > last)
    assert heard == sorted(set(heard))
    count, last = len(heard), session.latest.number
    camera(lambda: session.latest.number > last)
    assert len(heard) == count


def test_parameters_are_read_and_changed(world, session, found):
    values = Asked(world, session.parameters).answer
    assert values["particle_count"] == 50
    assert values.keys() == {spec.name for spec in session.table}
    assert Asked(world, lambda: session.change({"particle_count": 77})).error is None
    assert found.tracker.parameters.particle_count == 77


def test_a_refusal_has_its_reason_and_changes_nothing(world, session, found):
    asked = Asked(world, lambda: session.change({"width_minimum": 150.0, "width_maximum": 100.0}))
    assert isinstance(asked.error, ParameterError)
    assert "width_minimum" in str(asked.error)
    assert found.tracker.parameters.width_maximum == 240.0
    asked = Asked(world, lambda: session.change({"preset": "thesis"}))
    assert "no such parameter at runtime" in str(asked.error)


def test_reset_and_enable_reach_the_node(world, session, found, camera):
    camera(lambda: session.latest is not None and session.latest.row.status == "TRACKING")
    assert Asked(world, lambda: session.enable(False)).error is None
    camera(lambda: session.latest.row.status == "DISABLED")
    world.spin(lambda: not session.is_enabled)
    assert Asked(world, lambda: session.enable(True)).error is None
    assert Asked(world, session.reset).error is None
    camera(lambda: session.latest.row.status == "TRACKING")


def test_the_users_guess_reaches_the_node_as_an_initial_state(world, session, found):
    heard = world.listen(PoseWithCovarianceStamped, "initial_state")
    world.spin(lambda: world.me.count_publishers(f"{world.namespace}/initial_state"))
    prior = GivenState.around(CableState(20.0, 0.3, 40.0))

    def guessed():
        if not heard:
            # Until all of the node's topics have been discovered it may be too early.
            with suppress(RosError):
                session.initialise(prior)
            world.pass_time(0.1)
        return heard

    world.spin(guessed)
    place = heard[0].pose.pose.position
    assert (place.x, place.y) == pytest.approx((20.0 * math.cos(0.3), 20.0 * math.sin(0.3)))
    assert np.isfinite(heard[0].pose.covariance).all()


def test_a_node_that_goes_and_comes_again_is_found_again(world, session, found, camera):
    camera(lambda: session.latest is not None)
    before = session.latest.number
    world.executor.remove_node(found)
    world.remove(found)
    world.spin(lambda: "no node" in session.trouble)
    world.tracker(particle_count=30)

    def has_thirty_particles():
        seen = session.latest
        return seen.number > before and seen.cloud is not None and len(seen.cloud) == 30

    camera(has_thirty_particles)
    camera(lambda: not session.trouble)


def test_a_name_without_topics_is_what_is_left_of_a_node(world, session):
    world.add(Node("tracker", context=world.context, namespace=world.namespace))
    watcher = world.me
    world.spin(lambda: ("tracker", world.namespace) in watcher.get_node_names_and_namespaces())
    world.pass_time(2.0 * live_session.UPDATE_PERIOD)
    assert f"no node {world.namespace}/tracker" in session.trouble


def test_a_listener_that_fails_ends_nothing(session, camera):
    def fail(snapshot):
        raise RuntimeError(f"picture {snapshot.number} is not drawn")

    session.listen(fail)
    camera(lambda: session.latest is not None and session.latest.number >= 3)


def test_a_silent_node_is_reported_with_its_diagnostics(world, session, found, camera):
    camera(lambda: session.latest is not None)
    world.spin(lambda: "STALE INPUT" in session.trouble)


def test_a_dead_node_is_reported_as_silent(world, session, found, camera):
    camera(lambda: session.latest is not None)
    # It is still on the graph, and neither spun nor heard: as after a SIGKILL.
    world.executor.remove_node(found)
    world.spin(lambda: "says nothing" in session.trouble)


@pytest.mark.parametrize("namespace", ["auv-1", "1auv", "a b", "/auv//x"])
def test_a_bad_namespace_is_refused(ros_environment, namespace):
    with pytest.raises(RosError, match="is no namespace of ROS"):
        LiveSession(namespace)
