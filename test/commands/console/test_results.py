from pathlib import Path

from cable_tracker.cable.model.state import CableState
from cable_tracker.commands.console.results import event_notes, folder_beside, metres_note
from cable_tracker.sequences.tables.estimates import EstimateRow, RowMetres

STATE, METRES = CableState(1.0, 0.1, 20.0, 0.0), RowMetres(0.1, 0.0, 0.01, 0.01)
KNOWN = EstimateRow(0, 0, "TRACKING", state=STATE, metres=METRES)
NO_ALTITUDE = EstimateRow(
    0, 0, "TRACKING", state=STATE, no_metres="no altitude: none has come; fixed_altitude: 0"
)
STALE = EstimateRow(0, 0, "TRACKING", state=STATE, no_metres="stale altitude: of 2 s ago")
LOST = EstimateRow(0, 0, "LOST", no_metres="no cable is claimed: LOST")


def test_each_reason_for_refused_frames_is_printed_once():
    refused = [EstimateRow(k, 0, "REFUSED", event=f"reason {k}") for k in (3, 4)]
    assert event_notes([LOST, *refused]) == ["2 of 3 frames refused; the first, frame 3: reason 3"]
    assert event_notes([LOST, KNOWN]) == []


def test_the_first_of_many_restarts_are_listed():
    starts = [EstimateRow(k, 0, "LOST", event="no frame for 8.000 s") for k in range(8)]
    notes = event_notes(starts)
    assert notes[0] == "frame 0: no frame for 8.000 s"
    assert notes[5:] == ["and so 3 frames more"]


def test_claims_in_metres_are_counted():
    assert metres_note([LOST, KNOWN, KNOWN]) == "metres for 2 of 2 claims"


def test_the_reason_for_missing_metres_is_printed():
    assert metres_note([LOST, NO_ALTITUDE, NO_ALTITUDE]) == "no metres: no altitude (2 claims)"


def test_each_reason_for_missing_metres_is_counted():
    assert metres_note([KNOWN, STALE, NO_ALTITUDE, NO_ALTITUDE]) == (
        "metres for 1 of 4 claims; no metres: no altitude (2), stale altitude (1)"
    )


def test_without_a_claim_there_is_no_note_on_metres():
    assert metres_note([LOST]) == ""


def test_results_of_a_bag_folder_are_named_after_it(tmp_path):
    folder = tmp_path / "dive"
    folder.mkdir()
    assert folder_beside(Path("dives/third.mcap"), "tracked") == Path("third_tracked")
    assert folder_beside(folder, "tracked") == Path("dive_tracked")
    assert folder_beside(folder / "metadata.yaml", "tracked") == Path("dive_tracked")
