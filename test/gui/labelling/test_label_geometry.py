"""The browser's geometry against that of the filter, in the real browser."""

import numpy as np
import pytest

from cable_tracker.cable.model.geometry import (
    Borders,
    project_borders,
    segment_inside,
    states_from_borders,
    wrap_states,
)

SIZE = (320, 240)
IN_BROWSER = """async (states) => {
    const { labelGeometry: geometry } = await import("cable-tracker-browser");
    const rectangle = [-159.5, -119.5, 159.5, 119.5];
    return states.map((state) => {
        const lines = geometry.linesOf(state);
        return {
            wrapped: geometry.wrapState(state),
            left: lines.left,
            right: lines.right,
            back: geometry.stateOfBorders(lines.left, lines.right),
            seen: geometry.clipLine(lines.centre, rectangle),
            handles: geometry.handlesOf(state, rectangle),
        };
    });
}"""


@pytest.fixture(scope="module")
def states():
    rng = np.random.default_rng(8)
    states = np.zeros((500, 8))
    states[:, 0] = rng.uniform(-250, 250, 500)
    states[:, 1] = rng.uniform(-7, 7, 500)
    states[:, 2] = rng.uniform(1, 200, 500)
    states[:, 3] = rng.uniform(-0.7, 0.7, 500)
    # Upright, lying, at the wrap.
    states[:4, 1] = 0.0, np.pi / 2, -np.pi / 2, np.pi
    return states


@pytest.fixture(scope="module")
def answers(window, chromium, states):
    page = chromium.new_page()
    page.goto(window.url)
    page.wait_for_selector(".label-editor")
    answers = page.evaluate(IN_BROWSER, states[:, :4].tolist())
    page.close()
    return answers


def column(answers, name):
    return np.array([answer[name] for answer in answers])


def test_states_are_wrapped_alike(states, answers):
    assert column(answers, "wrapped") == pytest.approx(wrap_states(states)[:, :4], abs=1e-9)


def test_borders_are_alike(states, answers):
    borders = project_borders(states)
    for side, name in enumerate(("left", "right")):
        expected = np.stack((borders.angles[:, side], borders.offsets[:, side]), axis=1)
        assert column(answers, name) == pytest.approx(expected, abs=1e-9)


def test_states_of_borders_are_alike(states, answers):
    borders = project_borders(states)
    expected = states_from_borders(Borders(borders.angles, borders.offsets))
    assert column(answers, "back") == pytest.approx(expected, abs=1e-9)


def test_lines_are_clipped_alike(states, answers):
    seen = [segment_inside(state[1], state[0], SIZE) for state in states]
    outside = [segment is None for segment in seen]
    assert [answer["seen"] is None for answer in answers] == outside
    assert 0 < sum(outside) < len(states)
    for segment, answer in zip(seen, answers, strict=True):
        if segment is not None:
            assert np.array(answer["seen"]) == pytest.approx(np.array(segment), abs=1e-6)


def test_handles_lie_on_their_lines(states, answers):
    borders = project_borders(states)
    for number, answer in enumerate(answers):
        for handle in answer["handles"]["points"]:
            side = {-1: 0, 1: 1}.get(handle.get("side"))
            angle = states[number, 1] if side is None else borders.angles[number, side]
            offset = states[number, 0] if side is None else borders.offsets[number, side]
            x, y = handle["at"]
            assert x * np.cos(angle) + y * np.sin(angle) == pytest.approx(offset, abs=1e-6)
