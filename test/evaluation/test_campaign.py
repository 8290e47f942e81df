import dataclasses

import numpy as np
import pytest

from cable_tracker.cable.parameters.presets import preset
from cable_tracker.campaigns.settings import CampaignSettings, ClusterSettings
from cable_tracker.errors import ParameterError, RecordingError
from cable_tracker.evaluation.campaign import Campaign, evaluate_methods
from cable_tracker.evaluation.evaluation_sequences import (
    RecordingSequence,
    ScenarioSequence,
    WorldSequence,
)
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.evaluation.runs import Start
from cable_tracker.simulation.worlds.ground import FOLDER_VARIABLE

pytestmark = pytest.mark.slow


def numbers(result):
    trace = result.trace
    return (
        result.method,
        result.sequence,
        result.seed,
        trace.statuses,
        trace.estimates.tobytes(),
        trace.covariances.tobytes(),
        trace.truths.tobytes(),
        result.sheet,
    )


def test_results_come_by_sequence_seed_and_method(results):
    keys = [(result.sequence, result.seed, result.method) for result in results]
    other = "<other> & more"
    assert keys == [
        (sequence, seed, method)
        for sequence in ("stripe", other)
        for seed in (0, 1)
        for method in ("default", "thesis")
    ]


def test_only_the_first_seed_gets_contact_sheets(results):
    assert all(bool(result.sheet) == (result.seed == 0) for result in results)


def test_the_number_of_workers_does_not_change_the_results(run_apart):
    sequences = (ScenarioSequence("S6", 3),)
    campaign = Campaign(("thesis", "lsd"), sequences, (0, 1), Start.RANDOM, with_sheets=True)
    told = []
    alone = run_apart(campaign)
    together = evaluate_methods(campaign, CampaignSettings(ClusterSettings(2)), advance=told.append)
    assert [numbers(result) for result in alone] == [numbers(result) for result in together]
    assert sum(told) == campaign.frame_count() == 6


def test_what_is_kept_of_a_run_counts_in_a_campaign_that_begins_with_it(stripe, tmp_path):
    settings = CampaignSettings(ClusterSettings(), tmp_path / "store", resume=True)
    evaluate_methods(Campaign(("thesis",), (stripe,), (0, 1)), settings)
    told = []
    evaluate_methods(Campaign(("thesis",), (stripe,), (1,)), settings, advance=told.append)
    assert not told


def test_another_seed_is_another_run(results):
    first, second = (r for r in results if r.sequence == "stripe" and r.method == "default")
    assert not np.array_equal(first.trace.estimates, second.trace.estimates)


def test_filters_of_ones_own_are_run_after_the_methods(stripe):
    own = ConfiguredFilter("small", preset("thesis").replaced({"particle_count": 50}))
    same = ConfiguredFilter("same", preset("thesis"))
    named, small, again = evaluate_methods(
        Campaign(("thesis",), (stripe,), (1,), filters=(own, same))
    )
    assert [result.method for result in (named, small, again)] == ["thesis", "small", "same"]
    assert np.array_equal(named.trace.estimates, again.trace.estimates)
    assert not np.array_equal(named.trace.estimates, small.trace.estimates)


def test_what_else_lies_in_the_folder_does_not_make_another_run(stripe, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own = ConfiguredFilter("mine", preset("thesis"))
    task = Campaign((), (stripe,), (0,), filters=(own,))
    before = task.fingerprint()
    (tmp_path / "notes.txt").write_text("another file")
    assert task.fingerprint() == before


def test_a_sequence_file_is_another_one_when_a_picture_of_it_has_changed(tmp_path):
    picture, labels = tmp_path / "a.png", tmp_path / "dive.txt"
    picture.write_bytes(b"one")
    labels.write_text("1 0 30 0 # a.png\n")
    sequence = RecordingSequence(labels)
    task = Campaign(("thesis",), (sequence,), (0,))
    before = task.fingerprint()
    picture.write_bytes(b"another")
    assert task.fingerprint() != before


def test_a_world_is_another_one_on_other_photographs(monkeypatch, tmp_path):
    sequence = WorldSequence("report_inspection")
    task = Campaign(("thesis",), (sequence,), (0,))
    found = set()
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        for number in range(5):
            (tmp_path / name / f"{number}.png").write_text(name)
        monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / name))
        found.add(task.fingerprint())
    assert len(found) == 2


def test_an_error_in_a_worker_reaches_the_caller(tmp_path):
    missing = tuple(RecordingSequence(tmp_path / name) for name in "ab")
    campaign = Campaign(("thesis",), missing, (0,))
    with pytest.raises(RecordingError, match="no such file"):
        evaluate_methods(campaign, CampaignSettings(ClusterSettings(2)))


def test_an_unknown_method_is_named_with_what_there_is(stripe):
    with pytest.raises(ParameterError, match=r"'magic' is none of default \| thesis"):
        Campaign(("magic",), (stripe,), (0,))


@pytest.mark.parametrize("empty", ["methods", "sequences", "seeds"])
def test_there_must_be_something_to_run(stripe, empty):
    with pytest.raises(ParameterError, match="at least one"):
        dataclasses.replace(Campaign(("thesis",), (stripe,), (0,)), **{empty: ()})
