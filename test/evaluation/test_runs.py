import dataclasses

import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.campaigns.settings import CampaignSettings, ClusterSettings
from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.evaluation.evaluation_sequences import (
    RecordingSequence,
    ScenarioSequence,
    WorldSequence,
)
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.evaluation.runs import Campaign, MethodRun, Start, evaluate_methods, run_together
from cable_tracker.simulation.worlds.ground import FOLDER_VARIABLE

pytestmark = pytest.mark.slow


class Recorder:
    """Says what it was told, and remembers what it was asked."""

    def __init__(self, outcome, seed):
        self.outcome, self.seed = outcome, seed
        self.told, self.seen = [], []

    def initialise(self, given):
        self.told.append(given.state)

    def process(self, image, stamp):
        self.seen.append(image)
        return self.outcome(len(self.seen)).estimate


@pytest.fixture
def made():
    return []


@pytest.fixture
def make(outcome, made):
    def make_one(seed):
        made.append(Recorder(outcome, seed))
        return made[-1]

    return make_one


def test_the_truth_is_told_once_and_without_rates(make, made, stripe):
    run_together([MethodRun("m", make, 3, Start.TRUTH)], stripe.frames(0), "stripe")
    (method,) = made
    first = next(stripe.frames(0)).truth
    assert method.told == [CableState(first.distance, first.angle, first.width, first.skew)]
    assert method.seed == 3


def test_nothing_is_told_at_a_random_start(make, made, stripe):
    run_together([MethodRun("m", make, 0, Start.RANDOM)], stripe.frames(0), "stripe")
    assert made[0].told == []


def test_a_restart_makes_another_method_with_another_seed(make, made, stripe):
    run = MethodRun("m", make, 7, Start.RANDOM, restart_every=5)
    run_together([run], stripe.frames(0), "stripe")
    assert [len(method.seen) for method in made] == [5, 5, 2]
    assert len({method.seed for method in made}) == 3


def test_all_methods_see_the_same_frames_once(make, made, stripe):
    runs = [MethodRun(name, make, 0, Start.TRUTH) for name in "ab"]
    results = run_together(runs, stripe.frames(0), "stripe")
    first, second = (method.seen for method in made)
    assert all(a is b for a, b in zip(first, second, strict=True))
    assert [(result.method, result.sequence, len(result.trace)) for result in results] == [
        ("a", "stripe", 12),
        ("b", "stripe", 12),
    ]


def test_the_progress_is_told_after_each_frame(make, stripe):
    calls = []
    run_together(
        [MethodRun("m", make, 0, Start.TRUTH)],
        stripe.frames(0),
        "stripe",
        calls.append,
    )
    assert len(calls) == 12


def test_a_frame_that_is_refused_is_one_without_a_claim(outcome, stripe):
    class Refusing(Recorder):
        def process(self, image, stamp):
            estimate = super().process(image, stamp)
            if len(self.seen) in {4, 7}:
                raise FrameError("it has the time of the frame before")
            return estimate

    run = MethodRun("m", lambda seed: Refusing(outcome, seed), 0, Start.RANDOM, with_sheet=True)
    (result,) = run_together([run], stripe.frames(0), "stripe")
    assert (result.refused, result.refusal) == (2, "frame 3: it has the time of the frame before")
    assert len(result.trace) == 12
    assert np.flatnonzero(~result.trace.claimed).tolist() == [3, 6]
    assert np.isnan(result.trace.estimates).all(axis=1).nonzero()[0].tolist() == [3, 6]
    assert np.isfinite(
        [result.metrics[f"rmse_{axis}"] for axis in ("d", "alpha", "w", "beta")]
    ).all()


def test_a_sheet_is_a_jpeg_picture_and_only_there_if_asked_for(make, stripe):
    runs = [MethodRun("m", make, 0, Start.TRUTH, with_sheet=flag) for flag in (True, False)]
    with_sheet, without = run_together(runs, stripe.frames(0), "stripe")
    picture = cv2.imdecode(np.frombuffer(with_sheet.sheet, np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape[1] > 200
    assert without.sheet == b""


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
