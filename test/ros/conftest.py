"""Real nodes, each test in a namespace, and each worker in a context and a domain of its own."""

from __future__ import annotations

import gc
import importlib.util
import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.cable.model.state import CableState
from cable_tracker.ros.process.environment import (
    PROFILE_VARIABLE,
    RANGE_VARIABLE,
    local_environment,
)
from cable_tracker.sequences.bags.bag_writer import StorageFormat
from cable_tracker.sequences.bags.convert import ImageFormat, write_bag
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings, write_survey_bag
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate

HAS_ROS = importlib.util.find_spec("rclpy") is not None
MISSING_ROS = (
    "ROS 2 IS MISSING: no node is tested; run `pip install cable_tracker[ros]` or source"
    " /opt/ros/jazzy/setup.bash"
)
FIRST_DOMAIN = 40

FIRST = 1_700_000_000_000_000_000
STEP = 40_000_000
TRUTH = CableState(12.0, 0.12, 40.0)
NEAR = "9.0,0.08,36.0,0.0"
USUAL_FRAMES = 15
"""Few tests want a longer dive."""

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"

EXAMPLE_PATIENCE = 60.0
"""An example that a signal has not ended by then does not end [s]."""

PATIENCE = 300.0
"""What should come at once gets this long on a busy machine [s]."""

TURNS = 100
"""So many turns leave nothing in the queues: each takes one message, of which tests send few."""

IDLE_TURNS = 5
"""So many of them without a message, one after the other, leave nothing either."""

NO_WATCH = {"input_timeout": 3600.0}
"""How long a frame stays away says how busy the machine is; what is about silence says so."""

if HAS_ROS:
    with warnings.catch_warnings():
        # rclpy imports this when first needed; its parser library uses a deprecated module.
        warnings.simplefilter("ignore", DeprecationWarning)
        import rosidl_generator_py  # noqa: F401

    import rclpy
    from rclpy.context import Context
    from rclpy.executors import ShutdownException, SingleThreadedExecutor, TimeoutException
    from rclpy.node import Node
    from rclpy.parameter import Parameter
    from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
    from rclpy.serialization import serialize_message
    from rclpy.signals import SignalHandlerOptions

    from cable_tracker.ros.nodes.controller_node import ControllerNode
    from cable_tracker.ros.nodes.follower_node import FollowerNode
    from cable_tracker.ros.nodes.replay_node import ReplayNode
    from cable_tracker.ros.nodes.simulator_node import SimulatorNode
    from cable_tracker.ros.nodes.target_simulator_node import TargetSimulatorNode
    from cable_tracker.ros.nodes.target_tracker_node import TargetTrackerNode
    from cable_tracker.ros.nodes.tracker_node import TrackerNode
    from cable_tracker.ros.rigs.baseline_node import BaselineNode


class ModuleWithoutRos(pytest.Module):
    """Stands for a test module that cannot be imported without ROS."""

    def collect(self) -> Any:
        pytest.skip(MISSING_ROS, allow_module_level=True)


def pytest_pycollect_makemodule(module_path: Path, parent: Any) -> pytest.Module | None:
    return None if HAS_ROS else ModuleWithoutRos.from_parent(parent, path=module_path)


@pytest.fixture(scope="session")
def domain() -> int:
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    number = FIRST_DOMAIN + int(worker)
    assert number <= 101, "domain ids above 101 collide with ephemeral ports"
    return number


@pytest.fixture(scope="session", autouse=True)
def ros_environment(
    domain: int, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[pytest.MonkeyPatch]:
    """Keep all traffic on this machine, in the domain of this worker, also of child processes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        for name in (PROFILE_VARIABLE, RANGE_VARIABLE):
            patch.delenv(name, raising=False)
        for name, value in local_environment().items():
            patch.setenv(name, value)
        patch.setenv("ROS_LOG_DIR", str(tmp_path_factory.mktemp("ros_log")))
        root = str(Path(__file__).resolve().parents[2])
        inherited = os.environ.get("PYTHONPATH")
        patch.setenv("PYTHONPATH", os.pathsep.join(filter(None, (root, inherited))))
        yield patch


NUMBERS = count()


@pytest.fixture
def namespace() -> str:
    """A namespace in which no other nodes live."""
    return f"/test_{os.getpid()}_{next(NUMBERS)}"


def quiet_node(name: str, context: Any, namespace: str) -> Any:
    """Make a node that offers no services: it is asked for nothing."""
    return Node(
        name,
        context=context,
        namespace=namespace,
        start_parameter_services=False,
        enable_rosout=False,
        parameter_overrides=[Parameter("start_type_description_service", value=False)],
    )


@pytest.fixture(scope="session")
def context(domain: int, ros_environment: pytest.MonkeyPatch) -> Iterator[Any]:
    """The context of all tests of a worker, in which one node lives throughout.

    A participant of DDS ends with the last node of its context, and to make another takes longer
    than most tests.
    """
    context = Context()
    rclpy.init(
        args=[], context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
    )
    keeper = quiet_node("keeper", context, f"/kept_{os.getpid()}")
    yield context
    keeper.destroy_node()
    rclpy.try_shutdown(context=context)


class World:
    """Nodes that are spun together in this thread, and a listener."""

    def __init__(self, context: Any, namespace: str) -> None:
        self.context = context
        self.namespace = namespace
        self.executor = SingleThreadedExecutor(context=context)
        self.nodes: list[Any] = []
        self._refused_any = False
        self.me = self.add(quiet_node("me", context, namespace))

    def add(self, node: Any) -> Any:
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def remove(self, node: Any) -> None:
        """End a node before the others."""
        self.nodes.remove(node)
        node.destroy_node()

    def ends_with(self, node: Any, error: type[Exception], match: str) -> None:
        with pytest.raises(error, match=match):
            self.spin(lambda: node.finished)
        self.remove(node)

    def _arguments(self, parameters: dict[str, Any]) -> dict[str, Any]:
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        return {
            "context": self.context,
            "namespace": self.namespace,
            "parameter_overrides": overrides,
        }

    def _made(self, kind: Callable[..., Any], parameters: dict[str, Any]) -> Any:
        try:
            node = kind(**self._arguments(parameters))
        except Exception:
            self._refused_any = True
            raise
        return self.add(node)

    def tracker(self, **parameters: Any) -> Any:
        node = self.cold_tracker(**parameters)
        node.wait_until_warm()
        return node

    def cold_tracker(self, **parameters: Any) -> Any:
        """Make a tracker that may still be compiling."""
        return self._made(TrackerNode, {**NO_WATCH, **parameters})

    def untouched_tracker(self) -> Any:
        """Make a tracker with no parameter given."""
        node = self._made(TrackerNode, {})
        node.wait_until_warm()
        return node

    def target_tracker(self, **parameters: Any) -> Any:
        node = self._made(TargetTrackerNode, {**NO_WATCH, **parameters})
        node.wait_until_warm()
        return node

    def baseline(self, **parameters: Any) -> Any:
        """Make a stand-in for the tracker."""
        node = self._made(BaselineNode, {**NO_WATCH, **parameters})
        node.wait_until_warm()
        return node

    def replay(self, **parameters: Any) -> Any:
        """Make a replay that plays at once, also without a subscriber."""
        given = {"wait_for_tracker": False, **parameters}
        return self._made(ReplayNode, given)

    def simulator(self, **parameters: Any) -> Any:
        return self._made(SimulatorNode, parameters)

    def target_simulator(self, **parameters: Any) -> Any:
        return self._made(TargetSimulatorNode, parameters)

    def follower(self, **parameters: Any) -> Any:
        return self._made(FollowerNode, parameters)

    def controller(self, **parameters: Any) -> Any:
        return self._made(ControllerNode, parameters)

    def listen(self, kind: Any, topic: str) -> list[Any]:
        """Return a list that grows with every message on a topic."""
        heard: list[Any] = []
        profile = QoSProfile(
            history=HistoryPolicy.KEEP_ALL, depth=0, reliability=ReliabilityPolicy.RELIABLE
        )
        self.me.create_subscription(kind, topic, heard.append, profile)
        return heard

    @staticmethod
    def show(node: Any, message: Any) -> None:
        """Hand an image to a node as the middleware does: serialised."""
        node.on_image(serialize_message(message), {})

    def spin(self, condition: Callable[[], Any], patience: float = PATIENCE) -> None:
        """Run callbacks and the nodes' own work until a condition holds."""
        deadline = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < deadline, f"nothing happened for {patience} s"
            self.turn()

    def turn(self, seconds: float = 0.005) -> bool:
        """Run one callback if there is one, and the nodes' own work; say whether there was one."""
        try:
            handler, _, _ = self.executor.wait_for_ready_callbacks(timeout_sec=seconds)
        except (TimeoutException, ShutdownException):
            called = False
        else:
            called = True
            handler()
            handler.result()  # Raises what the callback raised.
        for node in self.nodes:
            if hasattr(node, "work"):
                node.work()
        return called

    def pass_time(self, seconds: float) -> None:
        """Spin for some time, to see that something does not happen."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.turn()
        self.empty_queues()

    def empty_queues(self) -> None:
        """Take all that these nodes have sent each other.

        Within one process a message has come when it has been sent; time would say nothing on a
        busy machine, on which the time for many turns may be over after one.
        """
        idle = 0
        for _ in range(TURNS):
            idle = 0 if self.turn(0.0) else idle + 1
            if idle == IDLE_TURNS:
                break

    def call(self, kind: Any, service: str, **fields: Any) -> Any:
        """Call a service and return its response."""
        client = self.me.create_client(kind, service)
        self.spin(client.service_is_ready)
        future = client.call_async(kind.Request(**fields))
        self.spin(future.done)
        self.me.destroy_client(client)
        return future.result()

    def close(self) -> None:
        if self._refused_any:
            # A node that is refused while it is made leaves its participant of Fast DDS, and of
            # several in one process one may never end (eProsima/Fast-DDS issue 6193).
            gc.collect()
        self.executor.shutdown()
        for node in self.nodes:
            node.destroy_node()


@pytest.fixture
def world(context: Any, namespace: str) -> Iterator[World]:
    world = World(context, namespace)
    yield world
    world.close()


@pytest.fixture
def load_example() -> Callable[[str], Any]:
    """Load an example of docs/examples by the name of its file."""

    def load(name: str) -> Any:
        spec = importlib.util.spec_from_file_location(Path(name).stem, EXAMPLES / name)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return load


@pytest.fixture
def complaints_after_signal(world: World, tmp_path: Path) -> Callable[..., str]:
    """What an example that runs as a process writes to stderr until a signal has ended it."""

    def run(name: str, number: signal.Signals, wait: Callable[[Any], None]) -> str:
        words = tmp_path / "stderr"
        command = [sys.executable, EXAMPLES / name, "--ros-args", "-r", f"__ns:={world.namespace}"]
        with (
            words.open("w") as file,
            subprocess.Popen(command, stdout=subprocess.PIPE, stderr=file, text=True) as process,
        ):
            try:
                wait(process)
                process.send_signal(number)
                process.wait(EXAMPLE_PATIENCE)
            finally:
                process.kill()
        return words.read_text()

    return run


class NodeProcess:
    """A node in a process of its own, as its executable runs it; its words go to a file."""

    def __init__(self, node: str, arguments: list[str], log: Path, **environment: str) -> None:
        self._log = log
        self._file = log.open("w")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "cable_tracker.ros.entry", node, "--ros-args", *arguments],
            stdin=subprocess.DEVNULL,
            stdout=self._file,
            stderr=subprocess.STDOUT,
            env={**os.environ, **environment},
        )

    @property
    def words(self) -> str:
        return self._log.read_text()

    def wait_until(self, condition: Callable[[], bool], pause: float = 0.02) -> None:
        """Ask again after each pause [s]; it is true before long, and before the process ends."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline and self.process.poll() is None, self.words
            time.sleep(pause)

    def end(self, signal_number: int | None = None) -> int:
        """Send a signal; return the exit code, which comes before long."""
        if signal_number is not None:
            self.process.send_signal(signal_number)
        return self.process.wait(PATIENCE)

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self._file.close()


@pytest.fixture
def start_process(tmp_path: Path, namespace: str) -> Iterator[Callable[..., NodeProcess]]:
    """Start a node by its name and parameters; it has ended after the test."""
    processes: list[NodeProcess] = []

    def start(
        node: str,
        *parameters: str,
        ns: str = namespace,
        image: str = "image",
        **environment: str,
    ) -> NodeProcess:
        given = [word for parameter in parameters for word in ("-p", parameter)]
        arguments = ["-r", f"__ns:={ns}", "-r", f"image:={image}", *given]
        log = tmp_path / f"{len(processes)}_{node}.log"
        processes.append(NodeProcess(node, arguments, log, **environment))
        return processes[-1]

    yield start
    for process in processes:
        process.close()


def draw_strip(state: CableState = TRUTH, size: tuple[int, int] = (320, 240)) -> Image:
    """Draw a bright strip on a noisy ground, uint8."""
    return drawn_strip(state, size).copy()


@cache
def drawn_strip(state: CableState, size: tuple[int, int]) -> Image:
    width, height = size
    x = np.arange(width) - (width - 1) / 2
    y = (height - 1) / 2 - np.arange(height)
    along_normal = x[None, :] * np.cos(state.angle) + y[:, None] * np.sin(state.angle)
    inside = np.clip(state.width / 2 - np.abs(along_normal - state.distance) + 0.5, 0.0, 1.0)
    noise = np.random.default_rng(5).normal(0.0, 3.0, (height, width))
    return np.clip(np.rint(70.0 + 100.0 * inside + noise), 0, 255).astype(np.uint8)


@pytest.fixture(scope="session")
def strip() -> Callable[..., Image]:
    return draw_strip


@pytest.fixture
def truth() -> CableState:
    """Where the strip of `strip` runs."""
    return TRUTH


@pytest.fixture(scope="session")
def near() -> str:
    """An initial state near the strip of `strip`."""
    return NEAR


@pytest.fixture(scope="session")
def stamp_of_index() -> Callable[[int], int]:
    return lambda index: FIRST + index * STEP


def packed(pixels: Image, padding: int, bigendian: bool) -> bytes:
    rows = pixels.astype(pixels.dtype.newbyteorder(">" if bigendian else "<"))
    return b"".join(row.tobytes() + b"\xab" * padding for row in rows)


def header_of(index: int) -> Any:
    from builtin_interfaces.msg import Time  # noqa: PLC0415
    from std_msgs.msg import Header  # noqa: PLC0415

    sec, nanosec = divmod(FIRST + index * STEP, 1_000_000_000)
    return Header(stamp=Time(sec=sec, nanosec=nanosec), frame_id="eye")


@pytest.fixture
def header() -> Callable[[int], Any]:
    """Make the header of the frame of an index."""
    return header_of


@pytest.fixture
def image_message() -> Callable[..., Any]:
    """Make a sensor_msgs/Image of pixels in the form that the encoding asks for."""
    from sensor_msgs.msg import Image as ImageMessage  # noqa: PLC0415

    def make(
        pixels: Image | None = None,
        encoding: str = "mono8",
        *,
        index: int = 0,
        padding: int = 0,
        bigendian: bool = False,
        **changes: Any,
    ) -> Any:
        pixels = draw_strip() if pixels is None else pixels
        height, width = pixels.shape[:2]
        fields: dict[str, Any] = {
            "header": header_of(index),
            "height": height,
            "width": width,
            "encoding": encoding,
            "is_bigendian": int(bigendian),
            "step": pixels[0].nbytes + padding,
            "data": packed(pixels, padding, bigendian),
        }
        return ImageMessage(**{**fields, **changes})

    return make


@pytest.fixture
def compressed_message() -> Callable[..., Any]:
    """Make a sensor_msgs/CompressedImage."""
    from sensor_msgs.msg import CompressedImage  # noqa: PLC0415

    def make(suffix: str = "jpeg", *, index: int = 0, length: int | None = None) -> Any:
        data = cv2.imencode(f".{suffix}", draw_strip())[1].tobytes()
        return CompressedImage(header=header_of(index), format=suffix, data=data[:length])

    return make


@pytest.fixture
def diagnostics(world: World) -> Callable[..., list[Any]]:
    """Listen to the diagnostics of a node: pairs of status message and values by key."""
    from diagnostic_msgs.msg import DiagnosticArray  # noqa: PLC0415

    heard = world.listen(DiagnosticArray, "/diagnostics")

    def of(node: Any) -> list[Any]:
        name = node.get_fully_qualified_name()
        own = [status for array in heard for status in array.status if status.hardware_id == name]
        return [
            (status.message, {pair.key: pair.value for pair in status.values}) for status in own
        ]

    return of


@pytest.fixture
def said(world: World, diagnostics: Callable[..., list[Any]]) -> Callable[..., str]:
    """What the diagnostics of a node say now under a key."""

    def saying(node: Any, key: str) -> str:
        world.empty_queues()
        before = len(diagnostics(node))
        node.publish_diagnostics()
        world.spin(lambda: len(diagnostics(node)) > before)
        return str(diagnostics(node)[-1][1][key])

    return saying


@cache
def whole_dive(frames: int, size: tuple[int, int]) -> tuple[Frame, ...]:
    settings = SimulationSettings(frame_count=frames, image_size=size, clutter=0.0, seed=3)
    return tuple(simulate(settings))


def dive(frames: int, size: tuple[int, int] = (160, 120)) -> Iterator[Frame]:
    """The first frames of a dive that is worked out once, for most tests want it."""
    return iter(whole_dive(max(frames, USUAL_FRAMES), size)[:frames])


@pytest.fixture(scope="session")
def vehicle_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short simulated dive with all instruments, to be read only."""
    path = tmp_path_factory.mktemp("dives") / "vehicle"
    write_survey_bag(path, SurveyDiveSettings(length=1.0, rate=5.0, image_size=(64, 48)))
    return path


@pytest.fixture(scope="session")
def dive_frames() -> Callable[..., Iterator[Frame]]:
    return dive


@pytest.fixture
def make_dive(tmp_path: Path) -> Callable[..., Path]:
    """Write a simulated dive as a bag, with ground truth, and return its path."""

    def make(
        frames: int = 8,
        *,
        storage: str = "mcap",
        jpeg: bool = False,
        size: tuple[int, int] = (160, 120),
        name: str = "dive",
    ) -> Path:
        image_format = ImageFormat.JPEG if jpeg else ImageFormat.AS_IS
        path = tmp_path / name
        write_bag(
            path, dive(frames, size), storage=StorageFormat(storage), image_format=image_format
        )
        return path

    return make


@pytest.fixture
def damaged_dive(make_dive: Callable[..., Path]) -> Path:
    """Write a dive of 12 frames as a bag, spoil its middle, and return its path."""
    path = make_dive(12)
    storage = next(path.glob("*.mcap"))
    content = bytearray(storage.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 40_000] = b"\x55" * 40_000
    storage.write_bytes(bytes(content))
    return path


@pytest.fixture
def colour_bag(tmp_path: Path) -> Callable[[int, tuple[int, int]], Path]:
    """Write frames of a strip that moves, in bgr8, and return the path of the bag."""

    def make(frames: int, size: tuple[int, int]) -> Path:
        def frame(index: int) -> Frame:
            grey = draw_strip(CableState(10.0 + 5.0 * index, 0.1, 0.1 * size[0]), size)
            image = raw_from_array(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), "bgr8")
            return Frame(index, FIRST + index * STEP, image)

        path = tmp_path / "colour"
        write_bag(path, (frame(index) for index in range(frames)))
        return path

    return make
