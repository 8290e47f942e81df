from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from rclpy.parameter import Parameter

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.baselines.detectors import DETECTORS
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS, PairLimits
from cable_tracker.errors import ParameterError
from cable_tracker.node_parameter_tables import TRACKER_RUNTIME_PARAMETERS
from cable_tracker.ros.nodes.initial_search import InitialSearch

BLANK = np.full((240, 320), 90, np.uint8)


def test_the_parameter_names_every_detector() -> None:
    specs = {spec.name: spec for spec in TRACKER_RUNTIME_PARAMETERS}
    assert all(f"`{name}`" in specs["initial_state"].meaning for name in DETECTORS)


def test_a_state_is_the_prior_of_every_start() -> None:
    search = InitialSearch("9.0,0.08,36.0,0.0")
    for _ in range(2):
        prior = search.restart()
        assert prior is not None
        assert prior.state == CableState(9.0, 0.08, 36.0, 0.0)
    assert not search.is_seeking


def test_random_gives_none() -> None:
    search = InitialSearch("random")
    assert search.restart() is None
    assert not search.is_seeking


def test_other_words_are_refused_with_what_there_is() -> None:
    with pytest.raises(ParameterError, match=r"'huff' is neither .* nor a detector .*hough"):
        InitialSearch("huff")


@pytest.mark.parametrize("name", DETECTORS)
def test_a_detector_is_asked_until_it_sees_a_cable(
    name: str, strip: Callable[..., Any], truth: CableState
) -> None:
    search = InitialSearch(name)
    assert search.restart() is None
    assert search.detect(BLANK) is None
    prior = search.detect(strip())
    assert prior is not None
    assert prior.state.distance == pytest.approx(truth.distance, abs=6.0)
    assert prior.state.angle == pytest.approx(truth.angle, abs=0.1)
    # Once is enough, until the next start.
    assert not search.is_seeking
    search.restart()
    assert search.is_seeking
    assert search.detect(strip()) is not None


@pytest.mark.parametrize("name", DETECTORS)
def test_a_detector_looks_for_the_widths_that_it_is_limited_to(
    name: str, strip: Callable[..., Any], truth: CableState
) -> None:
    narrow, wide = PairLimits(4.0, truth.width / 2, 0.2), PairLimits(4.0, 2 * truth.width, 0.2)
    search = InitialSearch(name, narrow)
    search.restart()
    found = search.detect(strip())
    assert found is None or found.state.width <= truth.width / 2
    search.limit(wide)
    search.restart()
    assert search.detect(strip()).state.width == pytest.approx(truth.width, abs=6.0)


def test_a_stopped_search_seeks_no_more() -> None:
    search = InitialSearch("hough")
    search.restart()
    assert search.is_seeking
    search.stop()
    assert not search.is_seeking


def test_the_same_text_leaves_a_search_alone() -> None:
    search = InitialSearch("lsd")
    search.restart()
    assert search.changed_to(" lsd ", DEFAULT_LIMITS) is search


@pytest.mark.parametrize(
    ("text", "is_seeking"), [("hough", True), ("random", False), ("9.0,0.08,36.0,0.0", False)]
)
def test_another_detector_goes_on_seeking(text: str, is_seeking: bool) -> None:
    search = InitialSearch("lsd")
    search.restart()
    assert search.changed_to(text, DEFAULT_LIMITS).is_seeking is is_seeking


@pytest.mark.parametrize("text", ["lsd", "random"])
def test_after_a_search_another_detector_seeks_from_the_next_start_on(text: str) -> None:
    search = InitialSearch(text)
    search.restart()
    search.stop()
    changed = search.changed_to("hough", DEFAULT_LIMITS)
    assert not changed.is_seeking
    changed.restart()
    assert changed.is_seeking


@pytest.mark.parametrize("name", ["lsd", "hough"])
def test_a_node_goes_on_looking_when_its_start_is_set_meanwhile(
    world: Any, truth: CableState, image_message: Callable[..., Any], name: str
) -> None:
    node = world.tracker(initial_state="lsd", filter="bootstrap")
    world.show(node, image_message(BLANK))
    result = node.set_parameters([Parameter("initial_state", value=name)])
    assert result[0].successful
    world.show(node, image_message(index=1))
    states = node.tracker.particles.states
    assert states[:, 0].mean() == pytest.approx(truth.distance, abs=6.0)
    assert states[:, 0].std() < 10.0


def test_a_node_starts_where_the_detector_sees_the_cable(
    world: Any, truth: CableState, image_message: Callable[..., Any]
) -> None:
    node = world.tracker(initial_state="hough", filter="bootstrap")
    world.show(node, image_message(BLANK))
    assert node.tracker.particles.states[:, 0].std() > 20.0
    world.show(node, image_message(index=1))
    states = node.tracker.particles.states
    assert states[:, 0].mean() == pytest.approx(truth.distance, abs=6.0)
    assert states[:, 0].std() < 10.0
