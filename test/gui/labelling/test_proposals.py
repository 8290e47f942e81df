import numpy as np
import pytest

from cable_tracker.cable.parameters.presets import preset
from cable_tracker.gui.labelling.labels import WITHOUT_CABLE, FrameLabel
from cable_tracker.gui.labelling.proposals import (
    MOST_FRAMES,
    MOST_FRAMES_IN_DOUBT,
    LabelProposal,
    Proposer,
)
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.frame_access import FrameAccess
from cable_tracker.sequences.source import open_source

from .conftest import COUNT, true_state

MUD = np.full((240, 320), 80, np.uint8)


@pytest.fixture
def proposer(folder):
    return Proposer(FrameAccess(open_source(folder)).frame, preset("default"))


def assert_is_the_cable(state, frame):
    truth = true_state(frame)
    assert state.distance == pytest.approx(truth.distance, abs=3.0)
    assert state.angle == pytest.approx(truth.angle, abs=0.05)
    assert state.width == pytest.approx(truth.width, abs=6.0)


def test_without_labels_a_detector_looks_at_the_frame(proposer):
    found = proposer.propose(4, {})
    assert found.message == "detected in this frame"
    assert_is_the_cable(found.state, 4)


def test_the_tracker_starts_at_the_last_label_before(proposer):
    labels = {0: FrameLabel(true_state(0)), 2: FrameLabel(true_state(2)), 9: WITHOUT_CABLE}
    found = proposer.propose(6, labels)
    assert found.message == "tracked from frame 2"
    assert_is_the_cable(found.state, 6)


def test_it_knows_from_two_labels_how_the_cable_moves(proposer):
    labels = {frame: FrameLabel(true_state(frame)) for frame in range(COUNT - 1)}
    assert_is_the_cable(proposer.propose(COUNT - 1, labels).state, COUNT - 1)


@pytest.mark.parametrize("labels", [{1: WITHOUT_CABLE}, {9: FrameLabel(true_state(9))}])
def test_where_no_cable_is_labelled_before_a_detector_looks(proposer, labels):
    assert proposer.propose(3, labels).message == "detected in this frame"


def test_a_proposal_is_at_rest(proposer):
    state = proposer.propose(3, {2: FrameLabel(true_state(2))}).state
    assert not state.to_array()[4:].any()


def test_the_same_labels_give_the_same_proposal(proposer):
    labels = {0: FrameLabel(true_state(0))}
    assert proposer.propose(5, labels) == proposer.propose(5, labels)


def test_a_proposal_that_is_not_waited_for_is_given_up(proposer):
    answers = iter([False, False, False, True])
    found = proposer.propose(5, {0: FrameLabel(true_state(0))}, lambda: next(answers))
    assert found.message == "stopped"


def mud(number):
    """A frame that shows nothing."""
    return Frame(number, 40_000_000 * (number + 1), raw_from_array(MUD, "mono8"))


def test_shortly_behind_a_label_an_unclaimed_cable_is_proposed_in_doubt():
    found = Proposer(mud, preset("default")).propose(1, {0: FrameLabel(true_state(0))})
    assert found.message == "tracked from frame 0, in doubt"
    assert found.state is not None


def test_far_behind_a_label_an_unclaimed_cable_is_lost():
    labels = {0: FrameLabel(true_state(0))}
    found = Proposer(mud, preset("default")).propose(MOST_FRAMES_IN_DOUBT + 1, labels)
    assert found == LabelProposal(
        MOST_FRAMES_IN_DOUBT + 1, None, "the tracker has lost the cable since frame 0"
    )


def test_where_nothing_is_seen_nothing_is_proposed():
    found = Proposer(mud, preset("default")).propose(0, {})
    assert found == LabelProposal(0, None, "no cable was detected")


def test_the_tracker_is_not_sent_too_far(proposer):
    with pytest.raises(IndexError):
        proposer.propose(MOST_FRAMES + 1, {0: FrameLabel(true_state(0))})
