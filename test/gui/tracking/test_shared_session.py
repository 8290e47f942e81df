import math
from pathlib import Path

import pytest

pytest.importorskip("nicegui", reason="NICEGUI IS NOT INSTALLED: the pages are not tested")

from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import FrameError, GuiError, RecordingError
from cable_tracker.gui.session.recording_session import RecordingRequest
from cable_tracker.gui.tracking.commands import COMMANDS, SPEEDS, command_player, speed_label
from cable_tracker.gui.tracking.shared_session import SharedSession, drawn_state, start_at

SIZE = (320, 240)


@pytest.fixture
def shared():
    shared = SharedSession(RecordingRequest(Path()), TrackerParameters())
    yield shared
    shared.close()


def test_a_line_drawn_upwards_through_the_middle_is_the_cable_at_rest():
    assert drawn_state((160, 200), (160, 40), 30.0, SIZE) == CableState(0.0, 0.0, 30.0)


def test_right_of_the_middle_d_is_positive_whichever_way_it_is_drawn():
    up, down = (drawn_state((200, y), (200, 240 - y), 30.0, SIZE) for y in (200, 40))
    assert up.distance == pytest.approx(40.0)
    assert (down.distance, down.angle) == pytest.approx((up.distance, up.angle))


def test_a_cable_whose_top_leans_left_has_a_positive_angle():
    drawn = drawn_state((160, 220), (60, 120), 30.0, SIZE)
    assert drawn.angle == pytest.approx(math.pi / 4)


def test_without_a_recording_there_is_nothing_to_command(shared):
    with pytest.raises(GuiError, match="open one first"):
        shared.need_session()
    assert shared.player is None


def test_another_recording_takes_the_place_of_the_first_with_its_parameters(shared, dive):
    shared.open(RecordingRequest(dive))
    first = shared.need_session()
    first.change({"particle_count": 99})
    version = shared.version
    shared.open(RecordingRequest(dive))
    assert shared.version != version
    assert shared.need_session() is not first
    assert shared.need_session().parameters()["particle_count"] == 99


def test_what_cannot_be_opened_leaves_all_as_it_is(shared, dive, tmp_path):
    shared.open(RecordingRequest(dive))
    before = shared.need_session()
    with pytest.raises(RecordingError):
        shared.open(RecordingRequest(tmp_path / "none.bag"))
    assert shared.need_session() is before
    before.change({"particle_count": 98})


def test_speeds_go_up_and_down_and_stay_in_their_range(shared, dive):
    shared.open(RecordingRequest(dive))
    player = shared.player
    for _ in range(2 * len(SPEEDS)):
        command_player(player, "faster")
    assert player.speed == math.inf
    for _ in range(2 * len(SPEEDS)):
        command_player(player, "slower")
    assert speed_label(player.speed) == "0.1"
    command_player(player, "speed", "2")
    assert player.speed == 2.0
    command_player(player, "dance")
    assert player.speed == 2.0


def test_a_cable_without_a_width_is_no_start(shared, dive):
    shared.open(RecordingRequest(dive))
    with pytest.raises(FrameError, match="no width of a cable"):
        start_at(shared.need_session(), CableState(0.0, 0.0, 0.0))


def test_every_key_does_one_thing():
    keys = [key for command in COMMANDS for key in command.keys]
    assert len(keys) == len(set(keys))
