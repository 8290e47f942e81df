from __future__ import annotations

import numpy as np
import pytest
from message_parts import FACTORY

from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.line_markers import (
    AMBER,
    GREY,
    Lines,
    make_line_markers,
    sides_of_polygon,
)


def test_earlier_lines_are_deleted_and_new_ones_numbered(sent):
    drawn = [
        Lines("frame", np.array([[0.0, 0.0], [100.0, -50.0]]), GREY),
        Lines("none", np.empty((0, 2)), AMBER),
    ]
    header = make_header(FACTORY, 5, "camera")
    clear, frame, none = sent(make_line_markers(FACTORY, header, drawn)).markers
    assert clear.action == 3
    assert [(m.id, m.ns, m.type, m.action) for m in (frame, none)] == [
        (0, "frame", 5, 0), (1, "none", 5, 0),
    ]  # fmt: skip
    assert [(p.x, p.y) for p in frame.points] == [(0.0, 0.0), pytest.approx((1.0, -0.5))]
    assert none.points == []


def test_a_polygon_is_closed():
    sides = sides_of_polygon(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    assert sides.tolist() == [[0, 0], [1, 0], [1, 0], [0, 1], [0, 1], [0, 0]]
