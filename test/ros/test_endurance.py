"""What clients, signals and crashes may do to the processes, and what these open."""

from __future__ import annotations

import os
import re
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image, JointState
from std_srvs.srv import SetBool, Trigger

from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE, TrackerParameters
from cable_tracker.node_parameter_tables import TRACKER_RUNTIME_PARAMETERS
from cable_tracker.ros.process.environment import PROFILE_VARIABLE, RANGE_VARIABLE
from cable_tracker.ros.process.shared_memory import remove_dead_segments
from cable_tracker.tracking.parameter_table import ParameterSpec

pytestmark = pytest.mark.slow

SHARED_MEMORY = Path("/dev/shm")
LOOPBACK = {"127.0.0.1", "::1"}
Make = Callable[..., Any]


class Random:
    """Draws parameter values, most of them good."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        numeric = [spec for spec in PARAMETER_TABLE if spec.name != "response_table"]
        # A frame may be held back for a minute, and the test waits for the answers.
        own = [spec for spec in TRACKER_RUNTIME_PARAMETERS if spec.name != "instrument_wait"]
        self._specs = [*numeric, *own]

    def value(self, spec: ParameterSpec) -> object:
        if self._rng.random() < 0.05:
            return [float("nan"), "nonsense", -1e300, 10**12, True][self._rng.integers(5)]
        if spec.choices:
            return str(self._rng.choice(spec.choices))
        if spec.kind is bool:
            return bool(self._rng.integers(2))
        if spec.minimum is None or spec.maximum is None:
            return str(self._rng.choice(["random", "3,0.1,30,0", "here"]))
        high = min(spec.maximum, 400.0) if spec.kind is int else spec.maximum
        share = self._rng.random() ** 4
        value = spec.minimum + share * (max(high, spec.minimum) - spec.minimum)
        return round(value) if spec.kind is int else float(value)

    def parameters(self) -> list[Parameter]:
        number = int(self._rng.integers(1, 6))
        chosen = self._rng.choice(len(self._specs), number, replace=False)
        return [Parameter(self._specs[k].name, value=self.value(self._specs[k])) for k in chosen]


class TestParameters:
    def test_a_thousand_random_sets_while_frames_run_leave_whole_sets_and_no_nan(
        self, world: Any, near: str, strip: Make, image_message: Make
    ) -> None:
        """Two clients, a frame for every tenth set: what is in force is what is told."""
        node = world.tracker(initial_state=near, input_timeout=3600.0)
        states = world.listen(JointState, "state")
        lines = world.listen(PoseWithCovarianceStamped, "centreline")
        draws = [Random(1), Random(2)]
        for number in range(1000):
            parameters = draws[number % 2].parameters()
            before = node.tracker.parameters
            if number % 3:
                node.set_parameters(parameters)
            else:
                result = node.set_parameters_atomically(parameters)
                assert result.successful or node.tracker.parameters == before
            told = {spec.name: node.get_parameter(spec.name).value for spec in PARAMETER_TABLE}
            assert node.tracker.parameters == TrackerParameters(**told)
            if number % 10 == 0:
                node.wait_until_warm()
                pixels = strip()
                pixels[0, 0] = number % 251
                world.show(node, image_message(pixels, index=number))
                world.turn()
        world.spin(lambda: len(states) == 100)
        numbers = [x for state in states for x in (*state.position, *state.velocity, *state.effort)]
        numbers += [x for line in lines for x in line.pose.covariance]
        assert np.all(np.isfinite(numbers))
        assert node.statistics.tracked == 100

    def test_clients_over_the_wire_at_the_same_time(
        self, world: Any, near: str, image_message: Make
    ) -> None:
        node = world.tracker(initial_state=near)
        clients = [
            world.me.create_client(kind, f"tracker/{name}")
            for kind, name in (
                (SetParameters, "set_parameters"),
                (SetParametersAtomically, "set_parameters_atomically"),
            )
        ]
        for client in clients:
            world.spin(client.service_is_ready)
        futures = []
        for number in range(40):
            client = clients[number % 2]
            low = 5.0 + number % 7
            pair = [
                Parameter("width_minimum", value=low).to_parameter_msg(),
                Parameter("width_maximum", value=low + 90.0).to_parameter_msg(),
            ]
            futures.append(client.call_async(client.srv_type.Request(parameters=pair)))
            world.show(node, image_message(index=number))
        world.spin(lambda: all(future.done() for future in futures))
        parameters = node.tracker.parameters
        assert parameters.width_maximum - parameters.width_minimum == 90.0


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc and /dev/shm")
class TestProcesses:
    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
    def test_a_signal_while_it_compiles_ends_it_with_0(
        self, start_process: Make, tmp_path: Path, number: int
    ) -> None:
        # An empty cache: everything is compiled, as at first use on a machine.
        tracker = start_process("tracker", NUMBA_CACHE_DIR=str(tmp_path / "cache"))
        tracker.wait_until(lambda: "warming up" in tracker.words)
        assert tracker.end(number) == 0
        assert "Traceback" not in tracker.words

    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
    def test_a_signal_between_services_and_frames_ends_it_with_0(
        self, start_process: Make, world: Any, image_message: Make, number: int
    ) -> None:
        tracker = start_process("tracker")
        camera = world.me.create_publisher(Image, "image", 5)
        reset = world.me.create_client(Trigger, "tracker/reset")
        enable = world.me.create_client(SetBool, "tracker/enable")
        world.spin(camera.get_subscription_count)
        world.spin(reset.service_is_ready)
        for index in range(20):
            reset.call_async(Trigger.Request())
            enable.call_async(SetBool.Request(data=index % 2 == 0))
            camera.publish(image_message(index=index))
            world.turn()
        assert tracker.end(number) == 0
        assert "Traceback" not in tracker.words

    def test_a_killed_tracker_is_replaced_and_a_killed_replay_too(
        self, start_process: Make, world: Any, make_dive: Make
    ) -> None:
        states = world.listen(JointState, "state")
        parameters = (f"source:={make_dive(50)}", "loop:=true")
        first = [start_process("tracker"), start_process("replay", *parameters)]
        world.spin(lambda: len(states) > 3)
        for node, arguments, old in (
            ("tracker", (), first[0]),
            ("replay", parameters, first[1]),
        ):
            old.process.kill()
            assert old.process.wait() == -signal.SIGKILL
            new = start_process(node, *arguments)
            heard = len(states)
            world.spin(lambda heard=heard: len(states) > heard + 3)
            assert new.process.poll() is None

    def test_two_trackers_at_one_camera_by_namespace(
        self, world: Any, start_process: Make, namespace: str, image_message: Make
    ) -> None:
        """One is there before the camera, the other comes after it."""
        topic = f"{namespace}/eye"
        names = [f"{namespace}/{side}" for side in ("port", "starboard")]
        heard = [world.listen(JointState, f"{name}/state") for name in names]
        first = start_process("tracker", ns=names[0], image=topic)
        world.spin(lambda: world.me.count_subscribers(topic) == 1)
        camera = world.me.create_publisher(Image, topic, 5)
        second = start_process("tracker", ns=names[1], image=topic)
        world.spin(lambda: camera.get_subscription_count() == 2)
        indices = count()

        def both_answer() -> bool:
            camera.publish(image_message(index=next(indices)))
            world.pass_time(0.05)
            return all(len(states) >= 3 for states in heard)

        world.spin(both_answer)
        assert (first.end(signal.SIGINT), second.end(signal.SIGTERM)) == (0, 0)

    def test_an_orderly_end_leaves_no_shared_memory(self, start_process: Make, world: Any) -> None:
        before = set(SHARED_MEMORY.iterdir())
        tracker = start_process("tracker")
        world.spin(lambda: world.me.count_subscribers("image") == 1)
        mine = segments_of(tracker.process.pid) - before
        assert mine
        assert tracker.end(signal.SIGINT) == 0
        assert not [path for path in mine if path.exists()]

    def test_only_the_shared_memory_of_a_killed_tracker_is_removed(
        self, start_process: Make, world: Any
    ) -> None:
        before = set(SHARED_MEMORY.iterdir())
        killed, living = start_process("tracker"), start_process("tracker")
        world.spin(lambda: world.me.count_subscribers("image") == 2)
        new = [segments_of(each.process.pid) - before for each in (killed, living)]
        killed.process.kill()
        killed.process.wait()
        # Only these are old enough: those of others, who may be about to lock theirs, are left.
        long_ago = time.time() - 3600.0
        for segment in set.union(*new):
            os.utime(f"{segment}_el", (long_ago, long_ago))
        remove_dead_segments()
        # A node that starts elsewhere on this machine may have been quicker.
        assert len([segment for segment in set.union(*new) if not segment.exists()]) == 1
        assert living.end(signal.SIGINT) == 0
        assert "Traceback" not in living.words

    def test_a_missing_profile_is_one_line_and_exit_code_2(
        self, start_process: Make, tmp_path: Path
    ) -> None:
        tracker = start_process("tracker", **{PROFILE_VARIABLE: str(tmp_path / "gone.xml")})
        assert tracker.end() == 2
        assert len(tracker.words.splitlines()) == 1
        assert tracker.words.startswith("error: the Fast DDS profile")


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
class TestNetwork:
    def test_with_the_shipped_profile_it_listens_on_loopback_alone(
        self, start_process: Make, world: Any
    ) -> None:
        tracker = start_process("tracker")
        world.spin(lambda: world.me.count_subscribers("image") == 1)
        addresses = listening(tracker.process.pid)
        assert addresses
        assert {address for _, address in addresses} <= LOOPBACK
        assert {kind for kind, _ in addresses} == {"udp"}

    def test_without_a_profile_a_node_listens_on_all_interfaces_as_documented(
        self, start_process: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.delenv(PROFILE_VARIABLE)
        monkeypatch.delenv(RANGE_VARIABLE)
        tracker = start_process("tracker")
        tracker.wait_until(lambda: "waiting for images" in tracker.words)
        addresses = {address for _, address in listening(tracker.process.pid)}
        assert "0.0.0.0" in addresses
        page = Path(__file__).resolve().parents[2] / "docs" / "security.md"
        assert "0.0.0.0" in page.read_text(encoding="utf-8")


def segments_of(pid: int) -> set[Path]:
    """Shared-memory segments that a process has mapped: its own and those of its partners."""
    maps = Path(f"/proc/{pid}/maps").read_text()
    names = re.findall(rf"{SHARED_MEMORY}/(fastrtps_[0-9a-f]{{16}})", maps)
    return {SHARED_MEMORY / name for name in names}


def listening(pid: int) -> set[tuple[str, str]]:
    """Protocol and address of the sockets on which a process takes what comes from elsewhere."""
    inodes = set()
    for descriptor in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(OSError):
            match = re.fullmatch(r"socket:\[(\d+)\]", str(descriptor.readlink()))
            if match:
                inodes.add(match[1])
    found = set()
    for kind in ("udp", "tcp", "udp6", "tcp6"):
        for line in Path(f"/proc/{pid}/net/{kind}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in inodes:
                found.add((kind, readable(fields[1].split(":")[0])))
    return found


def readable(address: str) -> str:
    """Turn the kernel's hexadecimal form of an address into the usual one."""
    if len(address) == 8:
        return ".".join(str(octet) for octet in reversed(bytes.fromhex(address)))
    return "::1" if address.endswith("01000000") else "::"
