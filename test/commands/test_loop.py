from __future__ import annotations

import csv
from dataclasses import replace

import pytest

from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.commands import loop as loop_command
from cable_tracker.commands.loop import verdict_on
from cable_tracker.commands.many_runs.loops import follow_several
from cable_tracker.errors import OutputError
from cable_tracker.evaluation.loop_table import (
    METHODS_TABLE,
    RUNS,
    SUMMARY,
    LoopOutcome,
    LoopSummary,
    read_summary,
)

pytest.importorskip("rclpy")

KEPT = LoopSummary(
    seed=1, frames=100, seconds=8.0, way=100.0, reached_end=True, rms=0.06, percentile_95=0.1,
    most=0.3, rms_in_sight=0.04, rms_offset=0.01, rms_heading=1.0, answered=1.0, measured=0.9,
    wrong=0.0, losses=1, longest_loss=12.0, found_again=True, lost_for_good=False,
)  # fmt: skip


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--length", "0", "length: 0.0 is outside 1 .. 100000 m"),
        ("--buried", "200", "buried is 200"),
        ("--size", "large", "is not of the form 320x240"),
        ("--seed", "-1", "seed: -1 is outside 0"),
        ("--seeds", "0", "seeds is 0"),
        ("--method", "magic", "'magic' is none of default"),
    ],
)
def test_bad_options_are_refused(command, tmp_path, option, value, words):
    command("loop", option, value, "--output", str(tmp_path / "loop")).assert_refused(words)


@pytest.mark.parametrize(
    "options",
    [("--workers", "2"), ("--resume",), ("--scheduler", "tcp://host:8786"), ("--dashboard",)],
)
def test_options_for_several_runs_are_refused_for_one(command, tmp_path, options):
    words = f"{options[0]} can only do something for several runs; leave it out"
    command("loop", *options, "--output", str(tmp_path / "loop")).assert_refused(words)


@pytest.mark.parametrize(
    ("rms", "words"),
    [
        (0.0612, "within the goal: RMS 0.061 m, goal 0.15 m."),
        (0.15017, "not within the goal: RMS 0.1502 m, goal 0.15 m."),
        (0.15, "within the goal: RMS 0.150000 m, goal 0.15 m."),
    ],
)
def test_the_verdict_shows_on_which_side_of_the_goal_the_run_is(rms, words):
    assert (
        verdict_on(replace(KEPT, rms=rms)) == f"The cable was not lost for good; the run is {words}"
    )


def test_a_folder_that_is_taken_is_refused(command, tmp_path):
    (tmp_path / "loop").mkdir()
    command("loop", "--output", str(tmp_path / "loop")).assert_refused("exists already")


def test_a_baseline_has_no_detector_of_the_filter_s(command, tmp_path):
    command(
        "loop", "--method", "lsd", "--detector", "none", "--output", str(tmp_path / "loop")
    ).assert_refused("have no effect on lsd")


def test_more_workers_than_domains_are_refused(command, tmp_path):
    command(
        "loop", "--seeds", "2", "--workers", "99", "--output", str(tmp_path / "loop")
    ).assert_refused("workers is 99")


@pytest.mark.slow
def test_several_runs_make_one_table(command, tmp_path):
    result = command(
        "loop", "--length", 1, "--size", "160x120", "--method", "hough", "--method", "lsd",
        "--workers", 2, "--output", tmp_path / "loops",
    )  # fmt: skip
    assert result.code == 0, result.err
    with (tmp_path / "loops" / RUNS).open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["method"], row["seed"], row["failure"]) for row in rows] == [
        ("hough", "0", ""),
        ("lsd", "0", ""),
    ]
    own = read_summary(tmp_path / "loops" / "lsd_0" / SUMMARY)
    assert float(rows[1]["rms"]) == own.rms
    assert not (tmp_path / "loops" / "lsd_0" / "loop.webm").exists()
    with (tmp_path / "loops" / METHODS_TABLE).open(encoding="utf-8") as file:
        assert [row["method"] for row in csv.DictReader(file)] == ["hough", "lsd"]


def test_live_needs_no_folder_and_takes_none(command, tmp_path):
    command("simulate", str(tmp_path / "dive"), "--live").assert_refused(
        "--live publishes and writes nothing"
    )
    command("simulate").assert_refused("name a folder")


def test_each_run_of_several_finds_the_parameter_file_from_any_folder(
    command, monkeypatch, tmp_path
):
    (tmp_path / "mine.yaml").write_text("particle_count: 100\n")
    chosen = []
    monkeypatch.setattr(
        loop_command, "follow_several", lambda tasks, *_, **__: chosen.append(tasks)
    )
    assert command("loop", "--seeds", "2", "--length", "20", "--params", "mine.yaml").code == 0
    assert [(task.method, task.seed) for task in chosen[0]] == [("default", 0), ("default", 1)]
    for task in chosen[0]:
        assert f"--params={tmp_path / 'mine.yaml'}" in task.arguments


def leave_a_run(_tasks, store, *_, **__):
    (store / "default_0").mkdir(parents=True)
    return [LoopOutcome("default", 0, KEPT)]


def test_the_folder_of_several_runs_is_replaced(monkeypatch, tmp_path):
    monkeypatch.setattr("cable_tracker.commands.many_runs.loops.run_loops", leave_a_run)
    for force in (False, True):
        follow_several([], tmp_path / "out", ClusterSettings(), force=force, resume=False)
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {RUNS, METHODS_TABLE, "default_0"}


def test_runs_stay_where_the_tables_cannot_be_written(monkeypatch, tmp_path, full_disk):
    monkeypatch.setattr("cable_tracker.commands.many_runs.loops.run_loops", leave_a_run)
    monkeypatch.setattr("cable_tracker.commands.many_runs.loops.write_runs", full_disk)
    with pytest.raises(OutputError):
        follow_several([], tmp_path / "out", ClusterSettings(), force=False, resume=False)
    assert (tmp_path / "out.tasks" / "default_0").is_dir()


def test_a_table_that_workers_elsewhere_would_not_find_is_refused(command, tmp_path):
    (tmp_path / "mine.yaml").write_text("response_table: table.json\n")
    code, _, error = command(
        "loop", "--seeds", 2, "--params", "mine.yaml", "--scheduler", "tcp://127.0.0.1:9"
    )
    assert code == 2
    assert f"give its whole path, {tmp_path / 'table.json'}" in error
