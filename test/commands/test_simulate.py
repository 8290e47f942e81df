"""`cable-tracker simulate`."""

import dataclasses
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader

from cable_tracker.sequences.labels.sequence_file import read_labels
from cable_tracker.sequences.labels.target_labels import read_boxes
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation import scenarios
from cable_tracker.simulation.scenario_dive import (
    SimulationSettings,
    simulate,
    simulate_scenario,
)
from cable_tracker.simulation.scenarios import SCENARIOS
from cable_tracker.simulation.targets.sequence import simulate_target


def test_a_dive_is_simulated_as_a_bag_or_a_sequence(command):
    settings = SimulationSettings(frame_count=3, image_size=(48, 36), seed=5, clutter=0.2)
    options = ("--frames", 3, "--size", "48x36", "--seed", 5, "--clutter", 0.2)
    expected = [bytes(frame.image.data) for frame in simulate(settings)]
    assert command("simulate", "bag", *options).out == "3 frames: bag\n"
    assert command("simulate", "pictures", "--format", "sequence", *options).code == 0
    with open_source(Path("bag")) as bag:
        assert [bytes(frame.image.data) for frame in bag.frames()] == expected
    with open_source(Path("pictures/sequence.txt")) as sequence:
        assert len(list(sequence.frames())) == 3
        assert sequence.has_truth


def test_a_lens_bends_the_pictures_and_the_bag_holds_its_calibration(command):
    options = ("--frames", 1, "--size", "64x48", "--clutter", 0)
    command("simulate", "straight", *options)
    command("simulate", "bent", *options, "--distortion", "-0.15,0.02,0.001,0,0")
    pictures = []
    for name in ("straight", "bent"):
        with open_source(Path(name)) as bag:
            pictures += [bytes(frame.image.data) for frame in bag.frames()]
    assert pictures[0] != pictures[1]
    with AnyReader([Path("bent")]) as reader:
        infos = [each for each in reader.connections if each.msgtype.endswith("/CameraInfo")]
        _, _, raw = next(reader.messages(infos))
        assert list(reader.deserialize(raw, infos[0].msgtype).d) == [-0.15, 0.02, 0.001, 0.0, 0.0]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--size", "320"), "'320' is not of the form 320x240"),
        (("--size", "-1x5"), "is not of the form"),
        (("--size", "8x8"), "8x8"),
        (("--frames", "0"), "at least 1 frame"),
        (("--clutter", "2"), "clutter is 2.0"),
        (("--rate", "nan"), "rate is nan"),
        (("--distortion", "0.1,0.2"), "'0.1,0.2' is not of the form K1,K2,P1,P2,K3"),
        (("--distortion", "nan,0,0,0,0"), "distortion is nan, 0, 0, 0, 0"),
        (("--distortion", "-2,0,0,0,0"), "does not show the whole picture"),
        (("--survey", "50", "--distortion", "0,0,0,0,0"), "--distortion can do nothing with"),
        (("--seed", "-3"), "seed is -3"),
        (("--survey", "50", "--scenario", "S1"), "--survey and --scenario"),
        (("--survey", "50", "--photographs", "p"), "--photographs covers the bottom of a scenario"),
        (("--survey", "50", "--format", "bag"), "--format can do nothing with --survey"),
        (
            ("--format", "sequence", "--storage", "mcap"),
            "--storage can do nothing with --format sequence",
        ),
        (
            ("--live", "--storage", "sqlite3", "--force"),
            "--storage and --force can do nothing with --live",
        ),
        (("--live", "--target", "buoy"), "--live and --target"),
        (
            ("--scenario", "S1", "--frames", "9", "--rate", "5"),
            "--frames and --rate can do nothing",
        ),
        (("--scenario", "S1", "--clutter", "0"), "--clutter can do nothing with --scenario"),
        (("--target", "buoy", "--clutter", "0.5"), "--clutter can do nothing with --target"),
        (("--survey", "50", "--frames", "300"), "--frames can do nothing with --survey"),
        (("--survey", "50", "--clutter", "0.1"), "--clutter can do nothing with --survey"),
        (("--live", "--frames", "300"), "--frames can do nothing with --live; leave it out"),
        (("--live", "--clutter", "0.1"), "--clutter can do nothing with --live"),
        (("--cable-seed", "0"), "--cable-seed can do nothing without --survey"),
        (("--scenario", "S1", "--cable-seed", "2"), "--cable-seed can do nothing with --scenario"),
    ],
)
def test_a_dive_that_cannot_be_simulated_is_refused(command, options, words):
    command("simulate", "out", *options).assert_refused(words)
    assert list(Path().iterdir()) == []


def test_a_scenario_of_the_evaluation_is_simulated_to_its_end(command, monkeypatch):
    short = dataclasses.replace(SCENARIOS["S6"], frame_count=4)
    monkeypatch.setattr(scenarios, "SCENARIOS", SCENARIOS | {"S6": short})
    outcome = command("simulate", "night", "--scenario", "S6", "--size", "64x48", "--seed", 2)
    assert outcome == (0, "4 frames: night\n", "")
    with open_source(Path("night")) as night:
        found = [bytes(frame.image.data) for frame in night.frames()]
    expected = [each.frame.image.data for each in simulate_scenario(short, 2, (64, 48))]
    assert found == [bytes(data) for data in expected]


def test_an_unknown_scenario_is_refused_with_the_known_ones(command):
    command("simulate", "out", "--scenario", "S9").assert_refused("'S9' is none of S1 | S2 | S3")


def test_photographs_need_a_scenario(command, tmp_path):
    command("simulate", "out", "--photographs", tmp_path).assert_refused("--scenario")


def test_a_world_is_written_with_its_labels(command):
    options = ("--scenario", "report_clear", "--size", "64x48", "--format", "sequence")
    assert command("simulate", "world", *options).code == 0
    assert len(read_labels(Path("world/sequence.txt"))) == 250


def test_a_world_has_its_own_bottom(command, tmp_path):
    options = ("--scenario", "report_clear", "--photographs", tmp_path)
    command("simulate", "world", *options).assert_refused("has its own bottom")


def test_a_target_is_written_with_its_boxes(command):
    options = ("--target", "vanishing", "--frames", 12, "--seed", 3, "--format", "sequence")
    assert command("simulate", "dive", *options).code == 0
    boxes = list(read_boxes(Path("dive/boxes.txt")).values())
    assert boxes == [frame.box for frame in simulate_target("vanishing", 3, 12)]
    assert None in boxes
    assert boxes[0] is not None


def test_a_target_goes_without_a_cable(command):
    command("simulate", "dive", "--target", "buoy", "--scenario", "S1").assert_refused("--target")


def test_an_unknown_target_is_refused(command):
    command("simulate", "dive", "--target", "whale").assert_refused("none of")
    assert not Path("dive").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("--target", "buoy", "--seed", -1),
        ("--target", "buoy", "--frames", 0),
        ("--target", "buoy", "--frames", 2, "--rate", "1e12"),
        ("--target", "buoy", "--frames", 2, "--rate", "inf"),
        ("--target", "buoy", "--frames", 2, "--rate", "nan"),
        ("--scenario", "tune_clear", "--seed", -1),
        ("--scenario", "tune_clear", "--size", "1x1"),
        ("--survey", 100, "--cable-seed", -1),
        ("--survey", "nan"),
        ("--survey", "inf"),
    ],
)
def test_values_that_cannot_be_are_refused_in_words(command, words):
    command("simulate", "dive", *words).assert_refused(" is ")
    assert not Path("dive").exists()
