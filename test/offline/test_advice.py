from dataclasses import replace

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.offline.advice import advice
from cable_tracker.sequences.tables.estimates import EstimateRow

PARAMETERS = TrackerParameters()
BY_BORDERS = PARAMETERS.replaced({"looks": "borders"})


def rows(presence=0.3, evidence=-2.0, status="INITIALISING") -> list[EstimateRow]:
    return [
        EstimateRow(index, index * 10**8, status, presence=presence, evidence=evidence)
        for index in range(5)
    ]


def words(*arguments) -> str:
    return "\n".join(advice(*arguments))


def test_there_is_no_advice_where_a_cable_was_claimed():
    claimed = EstimateRow(9, 9, "TRACKING", presence=1.0, evidence=1.0)
    assert advice([*rows(), claimed], [], PARAMETERS) == []
    assert advice([], [], PARAMETERS) == []


def test_advice_names_the_highest_value_and_the_threshold_above_it():
    said = words(rows(), [], PARAMETERS)
    assert "presence: at most 30%, presence_to_track asks for 80%" in said
    assert "evidence: the weaker border reached -2" in said
    assert "evidence_to_find asks for 0.45" in said
    assert "evidence_to_track asks for 1.6" in words(rows(), [], preset("thesis"))
    assert "evidence" not in words(rows(evidence=3.0), [], PARAMETERS)
    assert "presence:" not in words(rows(presence=1.0), [], PARAMETERS)


def test_advice_prints_enough_digits_to_tell_a_value_from_its_threshold():
    thesis = preset("thesis")
    assert "border reached 1.58, evidence_to_track asks for 1.6" in words(
        rows(1.0, 1.58), [], thesis
    )
    assert "border reached 1.59996, " in words(rows(1.0, 1.59996), [], thesis)
    assert "at most 79.6%, presence_to_track asks for 80%" in words(rows(0.796), [], PARAMETERS)
    assert "at most 79.996%, " in words(rows(0.79996), [], PARAMETERS)


def test_frames_that_span_all_but_the_confirmation_do_not_seem_to_span_it():
    confirmed = PARAMETERS.replaced({"confirmation_time": 0.4})
    brief = [replace(row, stamp=index * 99_990_000) for index, row in enumerate(rows(1.0, 3.0))]
    said = words(brief, [], confirmed)
    assert "usable frames span 0.39996 s, a claim takes confirmation_time (0.4 s)" in said


def test_a_thin_cable_is_asked_for_more_evidence():
    assert "evidence_to_find asks for 1.35" in words(rows(), [(32.0, 1280)] * 3, BY_BORDERS)
    assert "evidence_to_find asks for 0.3" in words(rows(), [(100.0, 320)] * 3, BY_BORDERS)


def test_with_the_network_a_thin_cable_needs_no_more_evidence():
    assert "evidence_to_find asks for 0.45" in words(rows(), [(32.0, 1280)] * 3, PARAMETERS)


def test_for_a_thin_cable_thin_width_is_named():
    thin = words(rows(), [(18.0, 1280)] * 3, BY_BORDERS)
    assert "3 times 0.45, for 4.5 px at 320 px is thin: lower thin_width" in thin
    assert "thin_width" not in words(rows(), [(60.0, 320)] * 3, BY_BORDERS)


def test_advice_tells_high_values_that_did_not_last_from_low_ones():
    assert "confirmation_time" in words(rows(1.0, 3.0), [], PARAMETERS)


def test_advice_names_the_reason_why_every_frame_restarts_tracking():
    anew = [replace(row, event="no frame for 10 s") for row in rows(1.0, 3.0)]
    said = words(anew, [], PARAMETERS)
    assert "started anew in 5 of 5 frames, for example: no frame for 10 s" in said
    assert "maximum_gap (5 s)" in said
    assert "shorter" not in said


def test_too_few_usable_frames_are_no_reason_to_shorten_the_confirmation():
    refused = [EstimateRow(k, 0, "REFUSED", event="the stamp is") for k in range(1, 5)]
    said = words([rows(1.0, 3.0)[0], *refused], [], PARAMETERS)
    assert "usable frames span 0 s" in said
    assert "shorter" not in said


def test_advice_gives_a_width_at_its_limit_in_units_of_the_parameters():
    thin = [(4 * PARAMETERS.initial_width_minimum, 1280)] * 5
    wide = [(PARAMETERS.initial_width_maximum, 320)] * 5
    assert "at its lower limit" in words(rows(), thin, PARAMETERS)
    assert "at its upper limit" in words(rows(), wide, PARAMETERS)
    assert "limit" not in words(rows(), [(160.0, 1280)] * 5, PARAMETERS)


def test_refused_frames_alone_lead_to_the_docs():
    refused = [EstimateRow(0, 0, "REFUSED")]
    assert "troubleshooting" in words(refused, [], PARAMETERS)
