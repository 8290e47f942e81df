from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterEvent, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, SetParametersAtomically
from rclpy.parameter import Parameter

from cable_tracker.cable.measure.borders.response_table import load_table
from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError
from cable_tracker.node_parameter_tables import (
    TRACKER_NODE_PARAMETERS,
    ReplayRuntimeParameters,
    ReplayStartParameters,
)
from cable_tracker.ros import node_parameters
from cable_tracker.sequences.messages.cable import read_state
from cable_tracker.tracking.parameter_table import parameter_table

ALL = (*PARAMETER_TABLE, *TRACKER_NODE_PARAMETERS)


def values_of(node: Any) -> dict[str, object]:
    return {spec.name: node.get_parameter(spec.name).value for spec in ALL}


def set_one(node: Any, name: str, value: object) -> Any:
    return node.set_parameters([Parameter(name, value=value)])[0]


def set_together(node: Any, **values: object) -> Any:
    return node.set_parameters_atomically(
        [Parameter(name, value=value) for name, value in values.items()]
    )


class TestDescriptors:
    def test_every_parameter_of_the_tables_is_declared_with_meaning_unit_and_range(
        self, world: Any
    ) -> None:
        node = world.tracker()
        for spec in ALL:
            descriptor = node.describe_parameter(spec.name)
            assert spec.meaning in descriptor.description
            assert not spec.unit or f"[{spec.unit}]" in descriptor.description
            ranges = [*descriptor.integer_range, *descriptor.floating_point_range]
            limits = [(limit.from_value, limit.to_value) for limit in ranges]
            bounded = spec.minimum is not None
            assert limits == ([(spec.minimum, spec.maximum)] if bounded else [])
            for choice in spec.choices:
                assert choice in descriptor.additional_constraints

    def test_each_is_announced_once(self, world: Any) -> None:
        events = world.listen(ParameterEvent, "/parameter_events")
        node = world.tracker(width_maximum=120)
        names = {spec.name for spec in ALL}

        def announced() -> list[str]:
            own = [event for event in events if event.node == node.get_fully_qualified_name()]
            return [each.name for event in own for each in event.new_parameters]

        world.spin(lambda: names <= set(announced()))
        world.empty_queues()
        assert sorted(name for name in announced() if name in names) == sorted(names)

    def test_the_defaults_are_those_of_the_tables(self, world: Any) -> None:
        assert values_of(world.untouched_tracker()) == {spec.name: spec.default for spec in ALL}

    def test_descriptors_are_served_over_ros(self, world: Any) -> None:
        world.tracker()
        response = world.call(
            DescribeParameters, "tracker/describe_parameters", names=["distance_variance"]
        )
        assert "px²/frame" in response.descriptors[0].description

    def test_the_replay_declares_its_own(self, world: Any, make_dive: Callable[..., Any]) -> None:
        node = world.replay(source=str(make_dive(1)), paused=True)
        for kind in (ReplayStartParameters, ReplayRuntimeParameters):
            for spec in parameter_table(kind):
                assert spec.meaning in node.describe_parameter(spec.name).description


class TestStart:
    def test_a_whole_number_is_taken_where_a_float_is_meant_and_the_other_way_round(
        self, world: Any
    ) -> None:
        node = world.tracker(width_maximum=120, particle_count=300.0)
        assert set_one(node, "distance_variance", 3).successful
        for name, value in (("width_maximum", 120.0), ("distance_variance", 3.0)):
            assert node.get_parameter(name).value == getattr(node.tracker.parameters, name) == value
            assert node.get_parameter(name).type_ == Parameter.Type.DOUBLE
        assert node.get_parameter("particle_count").type_ == Parameter.Type.INTEGER
        assert node.tracker.parameters.particle_count == 300
        assert set_one(node, "particle_count", 40.0).successful
        assert node.tracker.parameters.particle_count == 40

    @pytest.mark.parametrize(
        ("name", "value"),
        [
            ("particle_count", []),
            ("preset", "theses"),
            ("input_timeout", 0.0),
            ("response_table", "nowhere.json"),
        ],
    )
    def test_a_bad_value_stops_the_start_with_its_name(
        self, world: Any, name: str, value: object
    ) -> None:
        with pytest.raises(ParameterError, match=name.replace("_", "[_ ]")):
            world.tracker(**{name: value})

    def test_contradictory_values_stop_the_start(self, world: Any) -> None:
        with pytest.raises(ParameterError, match="width_minimum = 50 must not exceed"):
            world.tracker(width_minimum=50.0, width_maximum=40.0)

    def test_unknown_parameters_are_reported(
        self, world: Any, capfd: pytest.CaptureFixture[str]
    ) -> None:
        node = world.tracker(partikel_count=3)
        assert node_parameters.unknown_overrides(node) == ["partikel_count"]
        assert "unknown parameter 'partikel_count' is ignored" in capfd.readouterr().err

    def test_overrides_of_quality_of_service_are_reported_as_without_effect(
        self, world: Any, capfd: pytest.CaptureFixture[str]
    ) -> None:
        name = "qos_overrides./image.subscription.reliability"
        world.tracker(**{name: "reliable"})
        told = capfd.readouterr().err
        assert f"parameter '{name}' is ignored" in told
        assert "image_reliability" in told

    @pytest.mark.parametrize("node", ["simulator", "controller"])
    def test_unknown_parameters_are_reported_by_the_nodes_of_the_loop(
        self, world: Any, capfd: pytest.CaptureFixture[str], node: str
    ) -> None:
        getattr(world, node)(sped=3.0)
        assert "unknown parameter 'sped' is ignored" in capfd.readouterr().err

    def test_a_preset_sets_the_defaults_and_what_is_given_prevails(self, world: Any) -> None:
        node = world.tracker(preset="thesis", width_variance=9.0)
        expected = preset("thesis").replaced({"width_variance": 9.0})
        assert node.tracker.parameters == expected
        assert node.get_parameter("sample_spacing").value == 20.0
        assert node.get_parameter("resampling").value == "multinomial"


class TestRuntime:
    def test_a_change_reaches_the_filter(self, world: Any) -> None:
        node = world.tracker()
        assert set_one(node, "distance_variance", 3.5).successful
        assert node.tracker.parameters.distance_variance == 3.5
        assert node.get_parameter("distance_variance").value == 3.5

    @pytest.mark.parametrize(
        ("name", "value", "reason"),
        [
            ("particle_count", "few", "type"),
            ("distance_variance", None, "undeclared"),
            # A whole number where a float is meant.
            ("diagnostics_period", 0, "diagnostics_period.*range"),
            ("width_minimum", 241.0, "width_minimum = 241 must not exceed"),
            ("initial_state", "there", "initial.state: 'there'"),
            ("response_table", "nowhere.json", "response_table: nowhere.json cannot be read"),
        ],
    )
    def test_a_refused_value_changes_nothing_and_the_reason_is_given(
        self, world: Any, name: str, value: object, reason: str
    ) -> None:
        node = world.tracker()
        before, parameters = values_of(node), node.tracker.parameters
        result = set_one(node, name, value)
        assert not result.successful
        assert re.search(reason, result.reason)
        assert values_of(node) == before
        assert node.tracker.parameters is parameters

    def test_a_contradiction_is_solved_by_setting_both_together(self, world: Any) -> None:
        node = world.tracker()
        assert set_together(node, width_minimum=200.0, width_maximum=300.0).successful
        assert node.tracker.parameters.width_minimum == 200.0

    def test_one_parameter_of_a_pair_is_refused_with_advice_that_works(self, world: Any) -> None:
        node = world.tracker()
        pair = [Parameter("width_minimum", value=250.0), Parameter("width_maximum", value=300.0)]
        # The service set_parameters gives them one after the other.
        first, second = node.set_parameters(pair)
        assert not first.successful and second.successful
        assert "set both together with set_parameters_atomically, or the other first" in (
            first.reason
        )
        assert set_one(node, "width_minimum", 250.0).successful

    def test_a_change_leaves_a_line_in_the_log(
        self, world: Any, capfd: pytest.CaptureFixture[str]
    ) -> None:
        node = world.tracker()
        set_one(node, "width_maximum", 150)
        assert "parameters changed: width_maximum 240.0 -> 150.0" in capfd.readouterr().err
        set_one(node, "width_maximum", 150.0)
        set_one(node, "width_maximum", -1.0)
        assert "parameters changed" not in capfd.readouterr().err

    def test_a_search_for_wider_things_than_are_followed_is_warned_of_once(
        self, world: Any, capfd: pytest.CaptureFixture[str]
    ) -> None:
        node = world.tracker(initial_width_maximum=300.0)
        assert "raise width_maximum too" in capfd.readouterr().err
        assert set_one(node, "distance_variance", 5.0).successful
        assert "width_maximum too" not in capfd.readouterr().err
        assert set_one(node, "width_maximum", 150.0).successful
        assert "above width_maximum = 150" in capfd.readouterr().err
        assert set_one(node, "initial_width_maximum", 150.0).successful
        assert "width_maximum too" not in capfd.readouterr().err

    def test_one_bad_value_of_a_set_changes_nothing(self, world: Any) -> None:
        node = world.untouched_tracker()
        before = values_of(node)
        result = set_together(node, distance_variance=5.0, input_timeout=9.0, particle_count=0)
        assert not result.successful and "particle_count" in result.reason
        result = set_together(node, distance_variance=5.0, initial_state="0,0,40", seed=3)
        assert not result.successful and result.reason
        result = set_together(node, distance_variance=5.0, preset="thesis")
        assert not result.successful and "preset" in result.reason
        assert values_of(node) == before
        assert node.tracker.parameters == preset("default")
        assert node._watch.timeout == 1.0

    def test_a_bad_table_among_good_values_changes_nothing(self, world: Any) -> None:
        node = world.tracker()
        before, parameters = values_of(node), node.tracker.parameters
        result = set_together(node, distance_variance=5.0, response_table="nowhere.json")
        assert not result.successful and "nowhere.json cannot be read" in result.reason
        assert values_of(node) == before
        assert node.tracker.parameters is parameters

    def test_another_table_is_taken_and_kept_when_its_file_is_gone(
        self, world: Any, tmp_path: Path, image_message: Callable[..., Any]
    ) -> None:
        from std_srvs.srv import Trigger  # noqa: PLC0415

        path = tmp_path / "own.json"
        load_table("").save(path)
        node = world.tracker()
        world.show(node, image_message())
        assert set_one(node, "response_table", str(path)).successful
        assert node.tracker.parameters.response_table == str(path)
        path.unlink()
        assert set_one(node, "distance_variance", 5.0).successful
        node.on_reset(Trigger.Request(), Trigger.Response())
        world.show(node, image_message(index=1))
        assert node.statistics.tracked == 2
        assert set_one(node, "response_table", "").successful
        assert node.get_parameter("response_table").value == ""

    @pytest.mark.parametrize(
        ("values", "back"),
        [
            ({"detector": "none"}, {"detector": "line_pairs"}),
            ({"filter": "bootstrap"}, {"filter": "multi_hypothesis"}),
            (
                {"filter": "bootstrap", "observation": "responses"},
                {"filter": "multi_hypothesis", "observation": "likelihood_ratio"},
            ),
        ],
    )
    def test_filter_observation_and_detector_change_while_it_runs(
        self,
        world: Any,
        near: str,
        image_message: Callable[..., Any],
        values: dict[str, str],
        back: dict[str, str],
    ) -> None:
        from sensor_msgs.msg import JointState  # noqa: PLC0415

        node = world.tracker(initial_state=near)
        states = world.listen(JointState, "state")
        for index in range(9):
            if index in (3, 6):
                assert set_together(node, **(values if index == 3 else back)).successful
                node.wait_until_warm()
            world.show(node, image_message(index=index))
        world.spin(lambda: len(states) == 9)
        estimates = [read_state(state) for state in states]
        for before, after in pairwise(estimates):
            assert before is not None and after is not None
            assert abs(after.distance - before.distance) < 5.0

    def test_sets_are_accepted_and_refused_over_ros(self, world: Any) -> None:
        node = world.tracker()

        def double(name: str, value: float) -> ParameterMessage:
            content = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
            return ParameterMessage(name=name, value=content)

        service = "tracker/set_parameters_atomically"
        values = [double("width_minimum", 200.0), double("width_maximum", 150.0)]
        result = world.call(SetParametersAtomically, service, parameters=values).result
        assert not result.successful and "must not exceed" in result.reason
        assert node.tracker.parameters == preset("default")
        values = [double("width_minimum", 5.0), double("width_maximum", 150.0)]
        result = world.call(SetParametersAtomically, service, parameters=values).result
        assert result.successful
        assert node.tracker.parameters.width_maximum == 150.0

    @pytest.mark.parametrize(
        ("name", "value"),
        [
            ("preset", "thesis"),
            ("image_transport", "compressed"),
            ("image_reliability", "reliable"),
        ],
    )
    def test_parameters_read_at_the_start_cannot_be_changed(
        self, world: Any, name: str, value: str
    ) -> None:
        node = world.tracker()
        result = set_one(node, name, value)
        assert not result.successful and name in result.reason
        assert node.get_parameter(name).value != value

    @pytest.mark.parametrize(
        ("name", "values"),
        [
            ("particle_count", (900, 200)),
            pytest.param("particle_count", (150, 500), marks=pytest.mark.slow),
            pytest.param("filter_sigma", (2.5, 1.0), marks=pytest.mark.slow),
            pytest.param("working_width", (200, 320), marks=pytest.mark.slow),
        ],
    )
    def test_a_change_of_number_filter_or_size_keeps_the_estimate(
        self,
        world: Any,
        near: str,
        image_message: Callable[..., Any],
        name: str,
        values: tuple[object, object],
    ) -> None:
        from sensor_msgs.msg import JointState  # noqa: PLC0415

        node = world.tracker(initial_state=near)
        states = world.listen(JointState, "state")
        for index in range(12):
            if index in (6, 9):
                assert set_one(node, name, values[index == 9]).successful
                assert getattr(node.tracker.parameters, name) == values[index == 9]
            world.show(node, image_message(index=index))
            assert node.status == "TRACKING"
            assert node.tracker.particles.count == node.tracker.parameters.particle_count
        world.spin(lambda: len(states) == 12)
        estimates = [read_state(state) for state in states]
        for before, after in pairwise(estimates[4:]):
            assert before is not None and after is not None
            assert abs(after.distance - before.distance) < 2.0

    def test_the_initial_state_takes_effect_at_the_next_reset(
        self, world: Any, image_message: Callable[..., Any]
    ) -> None:
        from std_srvs.srv import Trigger  # noqa: PLC0415

        node = world.tracker()
        world.show(node, image_message())
        assert set_one(node, "initial_state", "-60,0.1,30,0").successful
        world.show(node, image_message(index=1))
        assert node.tracker.particles.states[:, 0].std() > 10.0
        node.on_reset(Trigger.Request(), Trigger.Response())
        world.show(node, image_message(index=2))
        particles = node.tracker.particles
        mean = float(particles.weights @ particles.states[:, 0])
        assert mean == pytest.approx(-60.0, abs=1.0)

    def test_the_timeouts_take_effect_at_once(self, world: Any) -> None:
        node = world.tracker(input_timeout=3600.0)
        world.pass_time(0.15)
        assert node.status == "INITIALISING"
        assert set_one(node, "input_timeout", 0.1).successful
        world.spin(lambda: node.status == "STALE INPUT")
