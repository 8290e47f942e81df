from __future__ import annotations

import pytest

from cable_tracker.tracking.status import StatusMachine, TrackingStatus

TIMES = {"confirmation_time": 0.12, "loss_time": 0.4}
TO_TRACK, TO_LOSE = 2.0, 1.0
GOOD, MIDDLING, BAD = 3.0, 1.5, 0.5
TRACKING, LOST, INITIALISING = (
    TrackingStatus.TRACKING,
    TrackingStatus.LOST,
    TrackingStatus.INITIALISING,
)


def after(machine, evidence, dt=0.05) -> StatusMachine:
    return machine.after(
        supports_claim=evidence >= TO_TRACK,
        supports_keeping=evidence >= TO_LOSE,
        dt=dt,
        **TIMES,
    )


def run(machine, evidences, dt=0.05) -> list[TrackingStatus]:
    statuses = []
    for evidence in evidences:
        machine = after(machine, evidence, dt)
        statuses.append(machine.status)
    return statuses


def test_a_claim_is_confirmed_as_soon_as_the_confirmation_time_is_reached():
    assert run(StatusMachine(), [GOOD], dt=TIMES["confirmation_time"]) == [TRACKING]


def test_evidence_must_hold_for_the_confirmation_time():
    assert run(StatusMachine(), [GOOD] * 4) == [INITIALISING, INITIALISING, TRACKING, TRACKING]


def test_one_bad_frame_restarts_the_confirmation():
    evidences = [GOOD, GOOD, MIDDLING, GOOD, GOOD, GOOD]
    assert run(StatusMachine(), evidences) == [INITIALISING] * 5 + [TRACKING]


def test_a_claim_is_confirmed_by_time_not_by_frames():
    assert run(StatusMachine(), [GOOD], dt=0.2) == [TRACKING]
    assert run(StatusMachine(), [GOOD] * 11, dt=0.01) == [INITIALISING] * 11


@pytest.mark.parametrize(("keeping", "status"), [(False, LOST), (True, TRACKING)])
def test_a_contradicted_claim_is_lost_at_once(keeping, status):
    machine = StatusMachine(TRACKING).after(
        supports_claim=False,
        supports_keeping=keeping,
        dt=0.01,
        **TIMES,
        contradicts_claim=True,
    )
    assert machine.status is status


@pytest.mark.parametrize("dt", [0.2, 1.0, 5.0])
def test_one_frame_does_not_lose_a_cable_however_slow_the_camera(dt):
    assert run(StatusMachine(TRACKING), [BAD] * 2, dt=dt) == [TRACKING, LOST]
    assert run(StatusMachine(TRACKING), [BAD, MIDDLING, BAD], dt=dt) == [TRACKING] * 3


def test_middling_evidence_claims_nothing():
    assert run(StatusMachine(), [MIDDLING] * 10) == [INITIALISING] * 10


def test_a_cable_is_kept_on_middling_evidence():
    assert run(StatusMachine(TRACKING), [MIDDLING] * 20) == [TRACKING] * 20


def test_a_cable_is_given_up_after_the_loss_time():
    assert run(StatusMachine(TRACKING), [BAD] * 8, dt=0.0625) == [TRACKING] * 6 + [LOST, LOST]


def test_a_good_frame_in_between_keeps_the_cable():
    assert run(StatusMachine(TRACKING), [BAD] * 7 + [MIDDLING] + [BAD] * 7) == [TRACKING] * 15


def test_a_lost_cable_can_be_found_again():
    assert run(StatusMachine(LOST), [MIDDLING, GOOD, GOOD, GOOD]) == [LOST, LOST, LOST, TRACKING]


def test_a_given_cable_is_confirmed_by_its_first_frame_alone():
    assert run(StatusMachine().confirm_with_next_frame(), [GOOD]) == [TRACKING]
    assert run(StatusMachine().confirm_with_next_frame(), [MIDDLING, GOOD]) == [
        INITIALISING,
        INITIALISING,
    ]


def test_the_time_without_a_claim_adds_up_until_a_search_begins():
    machine = StatusMachine()
    for _ in range(4):
        machine = after(machine, BAD, 0.25)
    assert machine.unclaimed_time == pytest.approx(1.0)
    assert machine.searched().unclaimed_time == 0.0
    assert machine.searched().status is INITIALISING


SEARCH_TIME = 1.0


def unclaimed_for(seconds, status=LOST) -> StatusMachine:
    return StatusMachine(status, unclaimed_time=seconds)


def test_a_search_is_due_once_nothing_was_claimed_for_the_search_time():
    assert unclaimed_for(SEARCH_TIME).is_search_due(SEARCH_TIME)
    assert not unclaimed_for(0.9 * SEARCH_TIME).is_search_due(SEARCH_TIME)


def test_no_search_is_due_while_a_cable_is_claimed():
    assert not unclaimed_for(2.0 * SEARCH_TIME, TRACKING).is_search_due(SEARCH_TIME)


def test_no_search_is_due_while_a_cable_is_being_confirmed():
    assert not after(unclaimed_for(2.0 * SEARCH_TIME), GOOD).is_search_due(SEARCH_TIME)


def test_a_cable_that_is_being_confirmed_is_known_as_such():
    assert not StatusMachine().is_confirming
    assert after(StatusMachine(), GOOD).is_confirming
    assert not after(StatusMachine(), BAD).is_confirming
    assert not after(StatusMachine(TRACKING), BAD).is_confirming


def test_a_claim_is_of_something_new_until_there_was_one():
    assert StatusMachine().is_first_claim(4.0)
    assert not after(StatusMachine(TRACKING), BAD).is_first_claim(4.0)
    assert not StatusMachine(LOST).is_first_claim(4.0)


def test_a_cable_not_seen_for_long_is_forgotten():
    machine = StatusMachine(LOST)
    for _ in range(5):
        machine = after(machine, BAD, 1.0)
    assert machine.is_first_claim(4.0)
    assert not machine.is_first_claim(5.0)
