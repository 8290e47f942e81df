from __future__ import annotations

import dataclasses
import io
import os
import signal
import subprocess
import sys
import time
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

import cv2
import numpy as np
import pytest
from estimate_reader import read_estimates
from rich.console import Console
from rosbags.highlevel import AnyReader

from cable_tracker import __version__, cli
from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME
from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands import dev, parameters
from cable_tracker.commands.console.results import folder_beside
from cable_tracker.commands.options.common import parse_size
from cable_tracker.commands.options.parameters import chosen_parameters
from cable_tracker.errors import OutputError, ParameterError
from cable_tracker.followed_kinds import CABLE
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_image
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation.scenarios import catalogue as scenarios
from cable_tracker.simulation.scenarios.catalogue import SCENARIOS
from cable_tracker.simulation.scenarios.scenario_dive import (
    SimulationSettings,
    simulate,
    simulate_scenario,
)
from cable_tracker.tracking.parameter_files import read_parameter_file

TABLE_ALONE = ("--no-video", "--no-bag", "--no-pictures")
"""What a test looks at that looks at estimates."""

OLD_TYPER = tuple(map(int, version("typer").split(".")[:2])) < (0, 15)
"""It imports Rich at once, and gives no advice."""


@cache
def small_dive(frames: int, clutter: float) -> tuple[Frame, ...]:
    """What `simulate` writes; worked out once, for most tests want it."""
    return tuple(simulate(SimulationSettings(frames, image_size=(64, 48), clutter=clutter)))


@pytest.fixture
def bag(command) -> Path:
    """A small simulated bag with truth."""
    write_bag(Path("dive"), small_dive(8, 0.1))
    return Path("dive")


@pytest.fixture
def unlabelled(bag, command) -> Path:
    """The same dive as pictures without labels."""
    write_sequence(Path("pictures"), small_dive(3, 0.5))
    Path("pictures/sequence.txt").unlink()
    return Path("pictures")


def test_a_bag_is_tracked_into_a_folder(command, bag):
    outcome = command("track", bag, "--init", "truth", "--seed", 1)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith("8 frames: 8 TRACKING\n")
    assert "8 of 8 labelled frames claimed; 0.0% of those off" in outcome.out
    assert "alpha" in outcome.out
    rows = read_estimates(Path("dive_tracked/estimates.csv"))
    assert [row.status for row in rows] == ["TRACKING"] * 8
    for line in outcome.out.splitlines()[-5:]:
        assert Path(line.strip()).exists()


def test_with_a_vehicle_file_it_is_told_why_there_are_no_metres(command, bag):
    Path("vehicle.yaml").write_text("fixed_altitude: 2.0\n")
    outcome = command("track", bag, "--init", "truth", "--vehicle", "vehicle.yaml")
    assert "\nno metres: no camera calibration (8 claims)\n" in outcome.out
    rows = read_estimates(Path("dive_tracked/estimates.csv"))
    assert all(row.no_metres.startswith("no camera calibration: ") for row in rows)


def test_the_same_seed_gives_the_same_table_and_another_one_does_not(command, bag):
    tables = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        options = ("--init", "truth", "--seed", seed, "--output", name, "--no-timing")
        assert command("track", bag, *options, *TABLE_ALONE).code == 0
        tables.append(Path(name, "estimates.csv").read_bytes())
    assert tables[0] == tables[1] != tables[2]


def test_a_start_may_have_a_negative_first_number(command, bag):
    assert command("track", bag, "--init", "-5,0.1,9,0", *TABLE_ALONE).code == 0


def test_what_a_detector_says_is_claimed_like_any_other_find(command, bag):
    demanding = ("-p", "evidence_to_find=100", "--force", *TABLE_ALONE)

    def statuses(init):
        assert command("track", bag, "--init", init, "--output", "out", *demanding).code == 0
        return {row.status for row in read_estimates(Path("out") / "estimates.csv")}

    assert statuses("truth") == {"TRACKING"}
    assert statuses("hough") == {"INITIALISING"}


def test_a_missing_recording_is_refused(command):
    command("track", "nothing.mcap").assert_refused("nothing.mcap: there is no such file or folder")


@pytest.mark.parametrize("name", ["a.mcap", "a.db3", "a.bag", "a.mp4", "a.txt", "a.xyz", "a"])
@pytest.mark.parametrize("content", [b"", b"no recording \x00\xff" * 50], ids=["empty", "garbage"])
def test_garbage_is_refused_in_one_line_that_names_it(command, name, content):
    Path(name).write_bytes(content)
    for words in (("track", name), ("convert", name, "out")):
        command(*words).assert_refused(name)
    assert [path.name for path in Path().iterdir()] == [name]


@pytest.mark.parametrize("init", ["", "left", "1,2,3", "nan,0,30,0", "0,0,-1,0"])
def test_a_bad_start_is_refused(command, bag, init):
    command("track", bag, "--init", init).assert_refused("initial state")
    assert not Path("dive_tracked").exists()


def test_truth_needs_labels(command, unlabelled):
    command("track", unlabelled, "--init", "truth").assert_refused("no ground truth to start from")
    assert not Path("pictures_tracked").exists()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("particle_count: 0\n", "particle_count: 0 is outside 1 .. 1"),
        ("colour: 3\n", "unknown parameter colour"),
        ("epsilon: .nan\n", "epsilon"),
        ("- 1\n", "holds no parameters by name"),
        ("a: 2020-99-99\n", "cannot be read as YAML"),
    ],
)
def test_a_bad_parameter_file_is_refused(command, bag, content, words):
    Path("p.yaml").write_text(content)
    command("track", bag, "--params", "p.yaml").assert_refused(words)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--params", "missing.yaml"), "missing.yaml: there is no such file"),
        (("--seed", "-1"), "seed: -1 is outside"),
        (("--rate", "0"), "rate must be a positive number"),
        (("--topic", "/other"), "/other"),
        (("--truth", "labels.txt"), "labels.txt"),
    ],
)
def test_other_bad_options_are_refused(command, bag, options, words):
    command("track", bag, *options).assert_refused(words)


@pytest.mark.parametrize(
    "arguments",
    [
        ("track", "dive", "--preset", "best"),
        ("track",),
        ("track", "dive", "--seed", "x"),
        ("convert", "dive", "out", "--storage", "tape"),
        ("dance",),
    ],
)
def test_wrong_usage_is_explained_with_exit_code_2(command, arguments):
    outcome = command(*arguments)
    assert outcome.code == 2
    assert "Usage" in outcome.err
    assert "Traceback" not in outcome.err


def test_a_bag_of_a_crashed_recorder_is_tracked_as_far_as_it_goes(command, bag):
    stored = Path("dive/dive.mcap")
    Path("cut.mcap").write_bytes(stored.read_bytes()[: stored.stat().st_size * 5 // 8])
    outcome = command("track", "cut.mcap", "--init", "truth", *TABLE_ALONE)
    rows = read_estimates(Path("cut_tracked/estimates.csv"))
    assert 1 <= len(rows) < 8
    assert outcome.code == 0
    assert outcome.out.startswith(f"{len(rows)} frames: ")
    assert outcome.err.startswith("note: ")


@pytest.mark.parametrize("name", ["track", "convert"])
def test_the_frames_before_the_damage_are_used_and_the_damage_is_told(command, unlabelled, name):
    Path("pictures/frame_000002.png").write_bytes(b"garbage")
    output = ("--output", "out", *TABLE_ALONE) if name == "track" else ("out",)
    outcome = command(name, unlabelled, *output)
    assert outcome.code == 2
    assert outcome.out.startswith("2 frames: ")
    assert outcome.err.startswith("error: ")
    assert outcome.err.count("\n") == 1
    assert "frame_000002.png" in outcome.err
    if name == "track":
        assert len(read_estimates(Path("out/estimates.csv"))) == 2


def test_instruments_that_cannot_be_read_are_told_once(command):
    factory = RosbagsMessages()
    with BagWriter(Path("dive")) as writer:
        for frame in small_dive(3, 0.5):
            header = make_header(factory, frame.stamp, "camera")
            message = make_image(factory, frame.image, header)
            writer.write("/image", "sensor_msgs/msg/Image", message, frame.stamp)
            writer.write_serialised(
                "/altitude", "sensor_msgs/msg/Range", b"\x00\x01\x00\x00\x07", frame.stamp
            )
    result = command("track", "dive", *TABLE_ALONE)
    assert result.code == 0
    assert result.err.count("/altitude: 3 of its messages cannot be read") == 1


def test_bad_frames_are_passed_over_where_that_is_wanted(command, unlabelled):
    Path("pictures/frame_000001.png").write_bytes(b"garbage")
    outcome = command("track", unlabelled, "--skip-bad-frames", *TABLE_ALONE)
    assert outcome.code == 0
    statuses = [row.status for row in read_estimates(Path("pictures_tracked/estimates.csv"))]
    assert [status == "REFUSED" for status in statuses] == [False, True, False]
    assert "1 of 3 frames refused; the first, frame 1: " in outcome.err
    assert "taken to be 25 a second (--rate)" in outcome.out


def test_a_recording_without_a_usable_frame_is_refused(command, unlabelled):
    for picture in Path("pictures").glob("*.png"):
        picture.write_bytes(b"garbage")
    outcome = command("track", unlabelled, "--skip-bad-frames")
    outcome.assert_refused("none of the 3 frames can be used; record it again. The first one:")
    assert not Path("pictures_tracked").exists()


def test_bad_frames_are_left_out_of_a_converted_recording_on_request(command, unlabelled):
    Path("pictures/frame_000001.png").write_bytes(b"garbage")
    outcome = command("convert", unlabelled, "copy", "--format", "grey", "--skip-bad-frames")
    assert outcome == (0, "2 frames (1 that cannot be decoded left out): copy\n", "")


def test_a_parameter_file_may_name_preset_and_initial_state_as_for_the_node(command, bag):
    text = "/**:\n  ros__parameters:\n    preset: thesis\n    initial_state: '1,0.1,20,0.01'\n"
    Path("node.yaml").write_text(text)
    table = ("--no-timing", *TABLE_ALONE)
    command("track", bag, "--params", "node.yaml", *table, "--output", "by_file")
    options = ("--preset", "thesis", "--init", "1,0.1,20,0.01")
    command("track", bag, *options, *table, "--output", "by_options")
    tables = [Path(name, "estimates.csv").read_bytes() for name in ("by_file", "by_options")]
    assert tables[0] == tables[1]
    both = command("track", bag, "--params", "node.yaml", "--preset", "default", *table, "--force")
    assert "note: the preset thesis is used" in both.err
    assert Path("dive_tracked/estimates.csv").read_bytes() == tables[0]


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("image_format", ["as-is", "grey", "jpeg"])
def test_a_recording_is_converted_with_its_truth(command, bag, storage, image_format):
    options = ("--storage", storage, "--format", image_format)
    outcome = command("convert", bag, "copy", *options)
    assert outcome == (0, "8 frames: copy\n", "")
    with open_source(Path("copy")) as copy, open_source(bag) as original:
        pairs = list(zip(copy.frames(), original.frames(), strict=True))
        assert copy.compressed is (image_format == "jpeg")
    assert [(a.stamp, a.truth) for a, _ in pairs] == [(b.stamp, b.truth) for _, b in pairs]
    command("convert", bag, "copy").assert_refused("copy: exists already")
    assert command("convert", bag, "copy", "--force").code == 0


def test_pictures_become_a_bag_at_the_wanted_rate(command, unlabelled):
    assert command("convert", unlabelled, "copy", "--rate", 10).code == 0
    with AnyReader([Path("copy")]) as reader:
        stamps = [stamp for _, stamp, _ in reader.messages()]
    assert stamps == [1_000_000_000, 1_100_000_000, 1_200_000_000]
    assert "have times of their own" in command("convert", "copy", "again", "--rate", 10).err


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


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--size", "320"), "'320' is not of the form 320x240"),
        (("--size", "-1x5"), "is not of the form"),
        (("--size", "8x8"), "8x8"),
        (("--frames", "0"), "at least 1 frame"),
        (("--clutter", "2"), "clutter is 2.0"),
        (("--rate", "nan"), "rate is nan"),
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


@pytest.mark.parametrize(
    ("text", "size"), [("320x240", (320, 240)), ("64X48", (64, 48)), ("1x1", (1, 1))]
)
def test_sizes(text, size):
    assert parse_size(text) == size


@pytest.mark.parametrize("text", ["", "x", "3x", "x3", "3.5x4", "3x4x5", "²x3"])
def test_what_is_no_size(text):
    with pytest.raises(ParameterError, match="320x240"):
        parse_size(text)


@pytest.mark.parametrize("width", [60, 80, 200])
def test_parameters_are_printed_with_whole_names_in_any_width(command, monkeypatch, width):
    monkeypatch.setattr(parameters, "console", Console(width=width))
    outcome = command("parameters")
    assert outcome.code == 0
    assert all(name in outcome.out for name in set(PARAMETERS_BY_NAME))
    assert "Number of particles N; time per frame" in " ".join(outcome.out.split())


def test_parameters_are_printed_as_a_file_for_track(command, bag):
    outcome = command("parameters", "--preset", "thesis", "--format", "yaml")
    Path("thesis.yaml").write_text(outcome.out, encoding="utf-8")
    assert set(read_parameter_file(Path("thesis.yaml"))) == set(PARAMETERS_BY_NAME)
    _, chosen = chosen_parameters(CABLE, None, Path("thesis.yaml"), None, None)
    assert chosen == PRESETS["thesis"]


def test_help_and_version(command):
    assert command("--version") == (0, f"cable-tracker {__version__}\n", "")
    for name in ("track", "convert", "simulate", "parameters"):
        outcome = command(name, "--help")
        assert outcome.code == 0
        assert "Usage" in outcome.out


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["--help"], "  track        Track a recording"),
        (["dev", "--help"], "  soak"),
    ],
)
def test_commands_are_listed_without_importing_what_they_need(words, shown):
    listed, imported = told_and_imported(*words)
    assert shown in listed
    assert imported == "set()\n"


def test_the_version_is_told_without_importing_what_commands_need():
    assert told_and_imported("--version") == (f"cable-tracker {__version__}\n", "set()\n")


def told_and_imported(*words):
    """What the command prints in a process of its own, and which large packages it has imported."""
    heavy = {"numpy", "cv2", "numba"} | (set() if OLD_TYPER else {"rich"})
    code = (
        f"import sys; from cable_tracker import cli; sys.argv[1:] = {list(words)}\n"
        "try: cli.main()\n"
        f"finally: print({heavy} & set(sys.modules), file=sys.stderr)"
    )
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return result.stdout, result.stderr


@pytest.mark.parametrize(("group", "groups"), [((), cli.GROUPS), (("dev",), dev.GROUPS)])
def test_the_help_lists_commands_by_what_one_wants_to_do(command, group, groups):
    shown = command(*group, "--help").out
    titles = [line.removesuffix(":") for line in shown.splitlines() if line.endswith(":")]
    assert titles == ["Options", *groups]
    lines = [line.split(maxsplit=1) for line in shown.splitlines()]
    described = {line[0]: line[1] for line in lines if len(line) == 2}
    names = {name for commands in groups.values() for name in commands}
    assert names <= set(described)
    assert not any(described[name].endswith("...") for name in names)


@pytest.mark.parametrize("name", [*cli.COMMANDS, *cli.FORMER_NAMES])
def test_every_command_is_found_and_explains_itself(command, name):
    outcome = command(name, "--help")
    assert outcome.code == 0
    assert "Usage" in outcome.out


@pytest.mark.parametrize("name", cli.FORMER_NAMES)
def test_former_names_are_those_of_commands_under_dev(command, name):
    options = [
        command(*words, "--help").out.split("Options")[1] for words in ((name,), ("dev", name))
    ]
    assert options[0] == options[1]
    assert f"  {name} " not in command("--help").out


@pytest.mark.skipif(OLD_TYPER, reason="Typer gives no such advice before 0.15")
def test_a_mistyped_command_is_told_the_right_one(command):
    assert "Did you mean 'track'?" in command("trak").err


def test_a_command_whose_packages_do_not_fit_keeps_none_from_help(command, monkeypatch):
    def fails(name):
        if name.endswith("commands.survey"):
            raise ImportError("pyarrow requires NumPy 2.0 or newer")
        return import_module(name)

    monkeypatch.setattr("cable_tracker.commands.console.lazy_group.import_module", fails)
    shown = command("--help")
    assert shown.code == 0
    assert "survey Map the cable from dives" in " ".join(shown.out.split())
    used = command("survey", "--help")
    assert (used.code, used.out) == (2, "")
    assert "survey cannot be used here: pyarrow requires NumPy 2.0" in used.err


def test_results_of_a_bag_folder_are_named_after_it():
    assert folder_beside(Path("dives/third.mcap"), "tracked") == Path("third_tracked")
    assert folder_beside(Path(__file__).parent, "tracked") == Path("test_tracked")
    bag = Path(__file__).parent / "metadata.yaml"
    assert folder_beside(bag, "tracked") == Path("test_tracked")


def test_it_runs_as_a_process_without_ros_and_without_a_traceback(tmp_path):
    command = [sys.executable, "-m", "cable_tracker.cli", "track", "missing"]
    root = Path(__file__).parents[1]
    result = subprocess.run(
        command,
        cwd=tmp_path,
        env={"PYTHONPATH": str(root), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr == "error: missing: there is no such file or folder; check the path\n"


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
    command("simulate", "out", "--scenario", "S9").assert_refused("S9")
    assert "S1, S2" in command("simulate", "out", "--scenario", "S9").err


def test_photographs_need_a_scenario(command, tmp_path):
    command("simulate", "out", "--photographs", tmp_path).assert_refused("--scenario")


@pytest.mark.parametrize("detector", ["hough", "lsd"])
def test_a_detector_can_say_where_to_start(command, detector):
    command("simulate", "clear", "--frames", 3, "--clutter", 0.1, "--size", "160x120")
    outcome = command("track", "clear", "--init", detector, *TABLE_ALONE)
    assert outcome.code == 0
    rows = read_estimates(Path("clear_tracked/estimates.csv"))
    assert rows[0].status == "TRACKING"


def test_a_detector_that_sees_nothing_is_no_start(command):
    Path("dark").mkdir()
    cv2.imwrite("dark/0.png", np.zeros((48, 64), np.uint8))
    command("track", "dark", "--init", "lsd").assert_refused("the detector lsd sees no cable")


@pytest.mark.parametrize("output", [".", "/"])
def test_an_output_without_a_name_is_refused(command, bag, output):
    command("track", bag, "--output", output, "--force").assert_refused("no name for a new output")


def test_a_start_in_degrees_is_refused(command, bag):
    command("track", bag, "--init", "12,6.5,40,0.03").assert_refused("radians")


def test_the_dds_profile_is_found(command):
    assert Path(command("dds-profile").out.strip()).name == "fastdds_loopback.xml"


HALTING = """
import time
from cable_tracker.cli import main
from cable_tracker.offline.result_folder import ResultFolder

add = ResultFolder.add

def add_and_halt(*words, **named):
    add(*words, **named)
    time.sleep(3600)

ResultFolder.add = add_and_halt
main()
"""
"""The command line, which comes no further than the first frame: it must not end too early."""


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)]
)
def test_a_signal_leaves_nothing_half_written(unlabelled, tmp_path, number):
    command = [sys.executable, "-c", HALTING, "track", "pictures"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        partial = tmp_path / ".pictures_tracked.partial"
        while process.poll() is None and not partial.exists():
            time.sleep(0.02)
        process.send_signal(number)
        _, errors = process.communicate(timeout=300)
    assert process.returncode == 128 + number
    assert errors.strip().endswith("stopped; nothing was written")
    assert not partial.exists()
    assert not (tmp_path / "pictures_tracked").exists()


def test_names_that_are_not_utf_8_are_printed_byte_for_byte(monkeypatch):
    out = io.TextIOWrapper(io.BytesIO(), "utf-8")
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr(cli, "app", lambda: print("Tauchg\udce4nge"))
    cli.main()
    out.flush()
    assert out.buffer.getvalue() == b"Tauchg\xe4nge\n"


@pytest.mark.parametrize(
    ("encoding", "printed"),
    [
        ("utf-8", "α in ° of Tauchg".encode()),
        ("latin-1", b"\\u03b1 in \xb0 of Tauchg"),
        ("ascii", b"\\u03b1 in \\xb0 of Tauchg"),
    ],
)
def test_what_an_encoding_lacks_is_printed_as_a_number(monkeypatch, encoding, printed):
    out = io.TextIOWrapper(io.BytesIO(), encoding)
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr(cli, "app", lambda: print("α in ° of Tauchg\udce4nge"))
    cli.main()
    out.flush()
    assert out.buffer.getvalue() == printed + b"\xe4nge\n"


@pytest.mark.parametrize("encoding", [pytest.param("latin-1", marks=pytest.mark.slow), "ascii"])
def test_units_are_printed_in_every_locale(encoding):
    words = [sys.executable, "-m", "cable_tracker.cli", "parameters"]
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    printed = subprocess.run(words, capture_output=True, env=environment, check=True)
    assert b"px" in printed.stdout and not printed.stderr


def test_an_error_is_told_with_what_is_kept(command, monkeypatch):
    def fails():
        error = OutputError("map: cannot be written")
        error.add_note("2 finished tasks are kept in map")
        raise error

    monkeypatch.setattr(cli, "app", fails)
    assert command("survey") == (
        2,
        "",
        "error: map: cannot be written; 2 finished tasks are kept in map\n",
    )
