import pytest
import rclpy
from rclpy.context import Context
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from cable_tracker.ros.clients.live_topics import find_topics
from cable_tracker.ros.nodes.target_tracker_node import TargetTrackerNode
from cable_tracker.ros.nodes.tracker_node import TrackerNode
from cable_tracker.sequences.node_topics import (
    CABLE_TOPICS,
    CONTOUR,
    FRAME_REPORT,
    GROUND_TRUTH,
    IMAGE,
    INITIAL_STATE,
    PARTICLES,
    STATE,
    TARGET_TOPICS,
)


def test_remapped_topics_are_found_by_what_they_carry(world, near):
    remapped = {"image": "eye/picture", "state": "elsewhere/state", "initial_state": "guess"}
    rules = [word for name, other in remapped.items() for word in ("-r", f"{name}:={other}")]
    tracker = world.add(
        TrackerNode(
            context=world.context,
            namespace=world.namespace,
            parameter_overrides=[Parameter("initial_state", value=near)],
            cli_args=["--ros-args", *rules],
        )
    )
    tracker.wait_until_warm()

    def found():
        return find_topics(world.me, tracker.get_fully_qualified_name(), CABLE_TOPICS)

    place = world.namespace
    expected = {
        IMAGE: f"{place}/eye/picture",
        INITIAL_STATE: f"{place}/guess",
        PARTICLES: f"{place}/particles",
        STATE: f"{place}/elsewhere/state",
        FRAME_REPORT: f"{place}/tracker/frame_report",
    }
    world.spin(lambda: found() == expected)


@pytest.mark.parametrize(
    ("remapped", "contour"), [("contour", "elsewhere"), ("box", "contour"), ("", "contour")]
)
def test_the_contour_is_told_from_the_box_also_where_one_is_remapped(world, remapped, contour):
    rules = ["-r", f"{remapped}:=elsewhere"] if remapped else []
    tracker = world.add(
        TargetTrackerNode(
            context=world.context,
            namespace=world.namespace,
            cli_args=["--ros-args", *rules],
        )
    )

    def found():
        return find_topics(world.me, tracker.get_fully_qualified_name(), TARGET_TOPICS)

    world.spin(lambda: CONTOUR in found())
    assert found()[CONTOUR] == f"{world.namespace}/{contour}"


def test_ground_truth_is_listened_to_first(world):
    """A frame is shown once all that the node says of it has come: its truth must be there."""
    tracker = world.tracker()
    world.me.create_publisher(JointState, f"{world.namespace}/ground_truth", 1)

    def found():
        return list(find_topics(world.me, tracker.get_fully_qualified_name(), CABLE_TOPICS))

    world.spin(lambda: GROUND_TRUTH in found())
    assert found()[0] is GROUND_TRUTH


def test_a_node_that_is_gone_has_no_topics(world):
    assert find_topics(world.me, f"{world.namespace}/tracker", CABLE_TOPICS) == {}


@pytest.fixture
def bare_name(ros_environment, domain, namespace):
    """Return a function that leaves the name of a tracker on the graph, as a gone process may."""
    nodes = []

    def leave():
        context = Context()
        rclpy.init(context=context, domain_id=domain)
        nodes.append(rclpy.create_node("tracker", context=context, namespace=namespace))

    yield leave
    for node in nodes:
        rclpy.try_shutdown(context=node.context)
        node.destroy_node()


@pytest.fixture
def elder_name(bare_name):
    bare_name()


def test_a_node_is_found_beside_what_is_left_of_one_that_is_gone(elder_name, bare_name, world):
    # The graph answers a question by name with what it lists first: a name may stand on each side.
    bare_name()
    name = f"{world.namespace}/tracker"
    graph = world.me.get_node_names_and_namespaces
    world.spin(lambda: graph().count(("tracker", world.namespace)) == 2)
    assert find_topics(world.me, name, CABLE_TOPICS) == {}
    world.tracker().wait_until_warm()
    world.spin(lambda: IMAGE in find_topics(world.me, name, CABLE_TOPICS))
