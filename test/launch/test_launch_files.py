"""What the launch files start, as Jazzy's `ros2 launch` would."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME
from cable_tracker.example_controller.controller import ControllerSettings
from cable_tracker.node_parameter_tables import (
    TARGET_NODE_PARAMETERS,
    TRACKER_NODE_PARAMETERS,
    GuidanceNodeParameters,
    ReplayRuntimeParameters,
    ReplayStartParameters,
    SimulatorNodeParameters,
)
from cable_tracker.simulation.live_world import LiveSettings
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterSpec, parameter_table

ROOT = Path(__file__).resolve().parents[2]
LAUNCH = ROOT / "launch"


def specs_of(*kinds: type[ParameterSet]) -> dict[str, ParameterSpec]:
    return {spec.name: spec for kind in kinds for spec in parameter_table(kind)}


SPECS: dict[str, dict[str, ParameterSpec]] = {
    "tracker": dict(PARAMETERS_BY_NAME) | {spec.name: spec for spec in TRACKER_NODE_PARAMETERS},
    "target_tracker": specs_of(TargetParameters)
    | {spec.name: spec for spec in TARGET_NODE_PARAMETERS},
    "replay": specs_of(ReplayStartParameters, ReplayRuntimeParameters),
    "simulator": specs_of(LiveSettings, SimulatorNodeParameters),
    "controller": specs_of(ControllerSettings, GuidanceNodeParameters),
}
NEEDED = {"replay.launch.py": {"source": "/data/dive"}}
OF_ROS = {"use_sim_time"}

Play = Callable[..., Any]


@pytest.fixture
def play(jazzy: Any) -> Play:
    def played(file: str, **arguments: str) -> Any:
        shares = {"cable_tracker": ROOT}
        return jazzy.run(LAUNCH / file, shares, **(NEEDED.get(file, {}) | arguments))

    return played


@pytest.fixture
def start(play: Play) -> Play:
    """Play a launch file, and return its nodes by the names of their executables."""

    def started(file: str, **arguments: str) -> dict[str, Any]:
        return {node.executable: node for node in play(file, **arguments).started}

    return started


FILES = sorted(path.name for path in LAUNCH.glob("*.launch.py"))


def test_each_tracker_a_replay_and_the_loop_have_a_launch_file() -> None:
    wanted = {"loop", "replay", "target", "tracker"}
    assert {f"{name}.launch.py" for name in wanted} <= set(FILES)


@pytest.mark.parametrize("file", FILES)
def test_every_node_is_an_executable_of_this_package(play: Play, file: str) -> None:
    setup = (ROOT / "setup.py").read_text(encoding="utf-8")
    executables = set(re.findall(r'"(\w+) = cable_tracker\.ros\.entry:\w+"', setup))
    context = play(file)
    assert context.started
    for node in context.started:
        assert node.package == "cable_tracker"
        assert node.executable in executables


@pytest.mark.parametrize("file", FILES)
def test_every_value_is_one_that_the_node_takes(play: Play, file: str) -> None:
    for node in play(file).started:
        specs = SPECS[node.executable]
        for name, value in node.values().items():
            assert name in specs or name in OF_ROS
            if name in specs:
                specs[name].coerce(value)


@pytest.mark.parametrize("file", FILES)
def test_every_argument_is_described_and_used(play: Play, file: str) -> None:
    context = play(file)
    assert all(argument.description for argument in context.declared)
    assert {argument.name for argument in context.declared} == context.read


@pytest.mark.parametrize("file", ["replay.launch.py", "loop.launch.py"])
def test_all_nodes_are_shut_down_when_one_of_them_ends(play: Play, file: str) -> None:
    (handler,) = play(file).handlers
    assert [type(action).__name__ for action in handler.on_exit] == ["EmitEvent"]
    assert type(handler.on_exit[0].event).__name__ == "Shutdown"


class TestTracker:
    def test_the_defaults_are_relative_names_and_the_default_preset(self, start: Play) -> None:
        tracker = start("tracker.launch.py")["tracker"]
        assert set(tracker.files()) == {ROOT / "config" / "default.yaml"}
        assert tracker.values()["preset"] == "default"
        assert tracker.values()["use_sim_time"] is False
        assert all(target == source for source, target in tracker.remappings.items())
        assert tracker.namespace == ""

    @pytest.mark.parametrize("name", ["image", "camera_info", "altitude", "imu", "odometry"])
    def test_every_input_can_be_given_another_topic(self, start: Play, name: str) -> None:
        tracker = start("tracker.launch.py", **{name: "/auv/down"})["tracker"]
        assert tracker.remappings[name] == "/auv/down"

    def test_a_camera_also_renames_its_compressed_topic(self, start: Play) -> None:
        tracker = start("tracker.launch.py", image="/cam/raw", image_transport="compressed")
        assert tracker["tracker"].remappings["image/compressed"] == "/cam/raw/compressed"
        assert tracker["tracker"].values()["image_transport"] == "compressed"

    def test_preset_namespace_time_and_log_level_reach_the_node(self, start: Play) -> None:
        tracker = start(
            "tracker.launch.py",
            preset="thesis", namespace="auv", use_sim_time="true", log_level="debug",
        )["tracker"]  # fmt: skip
        assert tracker.values()["preset"] == "thesis"
        assert set(tracker.files()) == {ROOT / "config" / "thesis.yaml"}
        assert tracker.namespace == "auv"
        assert tracker.values()["use_sim_time"] is True
        assert tracker.ros_arguments == ("--log-level", "debug")

    def test_a_user_file_replaces_that_of_the_preset(self, start: Play, tmp_path: Path) -> None:
        own = tmp_path / "own.yaml"
        own.write_text("/**: {ros__parameters: {particle_count: 70}}")
        tracker = start("tracker.launch.py", params_file=str(own), preset="thesis")["tracker"]
        assert tracker.parameters[-1] == own
        assert tracker.values()["preset"] == "thesis"

    def test_a_word_out_of_place_is_refused(self, play: Play) -> None:
        with pytest.raises(RuntimeError, match="image_transport"):
            play("tracker.launch.py", image_transport="jpeg")


class TestTarget:
    @pytest.mark.parametrize("preset", ["default", "thesis", "docking", "diver"])
    def test_every_preset_has_its_file(self, start: Play, preset: str) -> None:
        node = start("target.launch.py", preset=preset)["target_tracker"]
        assert node.values()["preset"] == preset
        assert node.files() == [ROOT / "config" / f"target_{preset}.yaml"]

    def test_start_size_and_count_reach_the_node(self, start: Play) -> None:
        node = start(
            "target.launch.py",
            initial_target="10,20,60,80", target_size="0.5", target_count="2", namespace="auv",
        )["target_tracker"]  # fmt: skip
        assert node.values()["initial_target"] == "10,20,60,80"
        assert node.values()["target_size"] == 0.5
        assert node.values()["target_count"] == 2
        assert node.namespace == "auv"

    @pytest.mark.parametrize("name", ["image", "camera_info", "imu", "odometry"])
    def test_every_input_can_be_given_another_topic(self, start: Play, name: str) -> None:
        node = start("target.launch.py", **{name: "/auv/front"})["target_tracker"]
        assert node.remappings[name] == "/auv/front"

    def test_how_instruments_are_read_reaches_the_node(self, start: Play) -> None:
        given = {"instrument_reliability": "reliable", "instrument_wait": "0.1"}
        values = start("target.launch.py", **given)["target_tracker"].values()
        assert values["instrument_reliability"] == "reliable"
        assert values["instrument_wait"] == 0.1

    def test_marks_can_be_given_another_topic(self, start: Play) -> None:
        node = start("target.launch.py", initial_target_topic="/mark")["target_tracker"]
        assert node.remappings["initial_target"] == "/mark"


class TestReplay:
    def test_a_source_must_be_given(self, jazzy: Any) -> None:
        with pytest.raises(RuntimeError, match="'source' was not provided"):
            jazzy.run(LAUNCH / "replay.launch.py", {"cable_tracker": ROOT})

    def test_replay_and_tracker_share_namespace_and_image_topic(self, start: Play) -> None:
        nodes = start("replay.launch.py", namespace="auv", image="/cam", preset="thesis")
        assert {node.namespace for node in nodes.values()} == {"auv"}
        for topic in ("image", "image/compressed"):
            assert len({node.remappings[topic] for node in nodes.values()}) == 1
        assert nodes["tracker"].values()["preset"] == "thesis"
        assert set(nodes["tracker"].files()) == {ROOT / "config" / "thesis.yaml"}

    def test_replay_and_tracker_get_the_vehicle_file(self, start: Play, tmp_path: Path) -> None:
        file = tmp_path / "vehicle.yaml"
        file.write_text("/**:\n  ros__parameters:\n    camera_pitch: 70.0\n")
        nodes = start("replay.launch.py", vehicle=str(file))
        assert nodes["replay"].values()["vehicle"] == str(file)
        assert nodes["tracker"].files()[-1] == file
        assert start("replay.launch.py")["replay"].values()["vehicle"] == ""

    def test_a_number_for_a_name_stays_a_name(self, start: Play) -> None:
        assert start("replay.launch.py", source="2024")["replay"].values()["source"] == "2024"

    def test_whole_numbers_are_taken_for_the_speed(self, start: Play) -> None:
        assert start("replay.launch.py", rate="2")["replay"].values()["rate"] == 2.0

    @pytest.mark.parametrize(("lockstep", "reliability"), [("true", "reliable"), ("false", None)])
    def test_in_lockstep_the_tracker_loses_no_frame(
        self, start: Play, lockstep: str, reliability: str | None
    ) -> None:
        nodes = start("replay.launch.py", lockstep=lockstep)
        values = nodes["tracker"].values()
        assert values["image_reliability"] == (reliability or "best_effort")
        assert values["instrument_reliability"] == (reliability or "best_effort")
        assert values["instrument_wait"] == (1.0 if reliability else 0.0)

    def test_simulated_time_has_a_clock(self, start: Play) -> None:
        nodes = start("replay.launch.py", use_sim_time="true")
        assert nodes["replay"].values()["publish_clock"] is True
        assert nodes["tracker"].values()["use_sim_time"] is True


class TestLoop:
    def test_the_loop_starts_simulator_tracker_and_controller(self, start: Play) -> None:
        nodes = start("loop.launch.py", namespace="auv", seed="3", length="20")
        assert set(nodes) == {"simulator", "tracker", "controller"}
        assert {node.namespace for node in nodes.values()} == {"auv"}
        assert nodes["simulator"].values()["seed"] == 3
        assert nodes["simulator"].values()["length"] == 20.0

    def test_a_user_file_wins_over_the_arguments(self, start: Play) -> None:
        simulator = start("loop.launch.py")["simulator"]
        assert simulator.parameters[-1] == ROOT / "config" / "loop.yaml"

    def test_all_nodes_of_the_loop_read_its_valid_parameter_file(self, start: Play) -> None:
        file = ROOT / "config" / "loop.yaml"
        for node in start("loop.launch.py").values():
            assert set(node.files()) == {file}
        content = yaml.safe_load(file.read_text(encoding="utf-8"))
        for key, section in content.items():
            specs = SPECS[key.removeprefix("/**/")]
            for name, value in section["ros__parameters"].items():
                specs[name].coerce(value)


def test_a_share_folder_has_everything_that_is_named(play: Play) -> None:
    setup = (ROOT / "setup.py").read_text(encoding="utf-8")
    assert 'files("launch", "*.launch.py")' in setup
    assert 'files("config", "*")' in setup
    assert 'share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]' in setup
    assert (ROOT / "resource" / "cable_tracker").is_file()
    assert "install_scripts=$base/lib/cable_tracker" in (ROOT / "setup.cfg").read_text()
