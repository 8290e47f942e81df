from __future__ import annotations

import pytest
from message_parts import FACTORY, HEADER

from cable_tracker.cable.model.state import CableState
from cable_tracker.sequences.messages.cable_markers import make_markers

SIZE = (320, 240)


def test_markers_show_borders_and_centreline_in_metres(sent):
    markers = sent(make_markers(FACTORY, HEADER, CableState(20.0, 0.0, 40.0), SIZE)).markers
    clear, image, borders, centreline = markers
    assert clear.action == 3
    assert [m.ns for m in (image, borders, centreline)] == ["image", "borders", "centreline"]
    assert len(image.points) == 8
    assert [p.x for p in centreline.points] == pytest.approx([0.2, 0.2])
    assert [p.y for p in centreline.points] == pytest.approx([-1.195, 1.195])
    assert [p.x for p in borders.points] == pytest.approx([0.0, 0.0, 0.4, 0.4])


def test_without_a_cable_the_markers_of_before_are_deleted():
    markers = make_markers(FACTORY, HEADER, None, SIZE).markers
    assert [m.ns for m in markers] == ["", "image"]


def test_a_cable_outside_the_image_has_markers_without_points(sent):
    markers = sent(make_markers(FACTORY, HEADER, CableState(500.0, 0.0, 40.0), SIZE)).markers
    assert [len(m.points) for m in markers[2:]] == [0, 0]
