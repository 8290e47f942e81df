"""`cable-tracker chase`: what is asked for, and what is told of it."""

from functools import partial
from types import SimpleNamespace

import pytest

from cable_tracker.commands import chase
from cable_tracker.errors import RosError
from cable_tracker.evaluation.targets.chase_table import ChaseSummary

SUMMARY = ChaseSummary(
    seconds=20.0, frames=250, mean_distance=2.61, worst_distance=3.02, kept=0.875,
    claimed_in_view=0.994, claimed_while_absent=0.016, times_hidden=3, times_found_again=2,
    range_error=0.037, within_two_sigmas=0.95,
)  # fmt: skip


@pytest.fixture
def asked(monkeypatch):
    """Return what runs were asked for; nothing is really run."""
    runs = []

    def run_chase(request, output, *, overwrite, advance):
        runs.append((request, output, overwrite))
        advance()
        return SUMMARY

    rig = SimpleNamespace(
        ChaseRequest=SimpleNamespace,
        run_chase=run_chase,
        file_names=lambda: ("chase.csv",),
    )
    monkeypatch.setattr(chase, "need_ros", lambda _name: rig)
    return runs


@pytest.fixture
def run(command):
    return partial(command, "chase")


def test_options_become_the_world_that_is_run(run, asked, tmp_path):
    words = ("--duration", 20, "--distance", 4, "--hidden-for", 2, "--seed", 7)
    result = run(*words, "--preset", "docking", "--output", tmp_path / "c", "--force")
    assert result.code == 0, result.err
    ((request, output, overwrite),) = asked
    world = request.world
    assert (world.duration, world.hidden_for, world.seed) == (20.0, 2.0, 7)
    assert (request.distance, request.preset) == (4.0, "docking")
    assert (output, overwrite) == (tmp_path / "c", True)


def test_shares_are_printed_in_percent_and_lengths_in_metres(run, asked, tmp_path):
    result = run("--output", tmp_path / "c")
    assert "87.5%" in result.out
    assert "2.61" in result.out
    assert str(tmp_path / "c" / "chase.csv") in result.out.replace("\n", "")
    assert asked[0][0].preset == "default"


@pytest.mark.parametrize(
    "words", [("--duration", 1), ("--distance", 0), ("--seed", -1), ("--preset", "whale")]
)
def test_bad_options_are_refused_before_a_run(run, asked, words):
    assert run(*words).code == 2
    assert asked == []


def test_without_ros_the_missing_package_is_named(run, monkeypatch, tmp_path):
    def missing(_name):
        raise RosError("ROS 2 is not installed")

    monkeypatch.setattr(chase, "need_ros", missing)
    run("--output", tmp_path / "c").assert_refused("ROS 2 is not installed")
