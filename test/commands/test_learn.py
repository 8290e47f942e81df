import os
import shutil
from pathlib import Path

import pytest
from estimate_reader import read_estimates

from cable_tracker.cable.measure.borders.response_table import is_table, load_table
from cable_tracker.evaluation.learning_sources import LearningPlan, describe_origin
from cable_tracker.sequences.bags.bag_writer import StorageFormat
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate
from cable_tracker.simulation.worlds.ground import FOLDER_VARIABLE

FRAMES = 6
DIVE = SimulationSettings(frame_count=FRAMES, image_size=(160, 120), clutter=0.1, seed=1)


@pytest.fixture(scope="module")
def frames():
    return tuple(simulate(DIVE))


@pytest.fixture
def bag(command, frames):
    write_bag(Path("dive"), frames)
    return Path("dive")


@pytest.fixture
def labels(command, frames):
    """The sequence file of a labelled recording."""
    write_sequence(Path("pictures"), frames)
    (path,) = Path("pictures").glob("*.txt")
    return path


@pytest.fixture
def unlabelled(labels):
    """Its pictures alone."""
    folder = Path("unlabelled")
    folder.mkdir()
    for picture in Path("pictures").rglob("*.png"):
        shutil.copy(picture, folder)
    return folder


def first_numbers(printed):
    """Frames, points on borders, and points elsewhere."""
    return [int(word) for word in printed.splitlines()[0].split() if word.isdigit()]


def left_behind():
    return {path.name for path in Path().iterdir()}


def test_a_bag_with_ground_truth_makes_a_table_for_track(command, bag):
    code, printed, messages = command("learn", bag, "--output", "table.json")
    assert (code, messages) == (0, "")
    assert printed.startswith(f"{FRAMES} frames and {FRAMES} harder copies of them, ")
    source = "dive; as they are and with the cable faded, blurred and in noise"
    assert printed.endswith(f"learnt from {source}: table.json\n")
    table = load_table("table.json")
    assert table.source == source
    assert table.edges.max() > 0.5
    assert (table.absent < 0.0).all()
    Path("p.yaml").write_text("response_table: table.json\n")
    table_alone = ("--no-video", "--no-bag", "--no-pictures")
    assert command("track", bag, "--init", "truth", "--params", "p.yaml", *table_alone)[0] == 0
    statuses = {row.status for row in read_estimates(Path("dive_tracked/estimates.csv"))}
    assert statuses == {"TRACKING"}


def test_all_kinds_of_sources_give_the_same_table(command, bag, labels, unlabelled):
    for name, source in (
        ("bag", (bag,)),
        ("sequence", (labels,)),
        ("pictures", (unlabelled, "--truth", labels)),
    ):
        wanted = ("learn", *source, "--harder", 0, "--output", f"{name}.json")
        assert command(*wanted)[0] == 0
    bag_table, sequence, pictures = (
        load_table(f"{name}.json") for name in ("bag", "sequence", "pictures")
    )
    # The labels are rounded in a sequence file.
    assert abs(bag_table.edges - sequence.edges).max() < 0.2
    assert (pictures.edges == sequence.edges).all()
    assert pictures.source == f"unlabelled labelled by {labels.name}"


def test_several_sources_and_scenarios_add_up(command, bag, labels):
    code, printed, _ = command(
        "learn", bag, labels, "--scenario", "S6", "--scenario", "tune_cl*", "--first-seed", "3",
        "--frames", 7, "--every", 5, "--harder", 2, "--output", "b.json",
    )  # fmt: skip
    assert code == 0
    assert load_table("b.json").source == (
        f"simulated S6, tune_cl* with seed 3, 7 frames of each; dive; {labels.name};"
        " one frame in 5; as they are and with the cable faded, blurred and in noise, 2 times"
    )
    # The frames 0 and 5 of four sequences, each of them also harder, twice.
    assert printed.startswith(f"{4 * 2} frames and {4 * 2 * 2} harder copies of them, ")


def test_without_harder_frames_no_line_mentions_them(command, bag):
    _, printed, _ = command("learn", bag, "--harder", 0, "--output", "table.json")
    assert printed.startswith(f"{FRAMES} frames, ")


def test_harder_frames_teach_fainter_borders(command, bag):
    for name, harder in (("as_it_is", 0), ("harder", 8)):
        assert command("learn", bag, "--harder", harder, "--output", name)[0] == 0
    as_it_is, harder_too = (load_table(name) for name in ("as_it_is", "harder"))
    # A faint border is met only then: without it, its class is that of the next stronger ones.
    moderate, ridge = 62, 0
    faintest = slice(0, 1)
    assert (
        harder_too.edges[faintest, moderate, ridge].mean()
        > as_it_is.edges[faintest, moderate, ridge].mean()
    )


def test_frames_without_a_cable_teach_what_a_bottom_looks_like(command):
    wanted = ("learn", "--scenario", "tune_clear", "--frames", 2, "--harder", 0, "--output")
    _, alone, _ = command(*wanted, "a.json")
    _, with_decoys, _ = command(*wanted, "b.json", "--scenario", "tune_decoys")
    (frames, borders, elsewhere), (same_frames, same_borders, more) = map(
        first_numbers, (alone, with_decoys)
    )
    assert (frames, borders) == (same_frames, same_borders)
    assert more > elsewhere


def test_frames_without_a_label_are_background_on_request(command, labels, unlabelled):
    few = Path("few.txt")
    few.write_text("".join(labels.read_text().splitlines(keepends=True)[:4]))
    wanted = ("learn", unlabelled, "--truth", few, "--harder", 0, "--output")
    _, passed_over, _ = command(*wanted, "a.json")
    code, counted, _ = command(*wanted, "b.json", "--unlabelled-is-empty")
    assert code == 0
    (frames, borders, elsewhere), (same_frames, same_borders, more) = map(
        first_numbers, (passed_over, counted)
    )
    assert (frames, borders) == (same_frames, same_borders)
    assert more > elsewhere
    assert "frames without a label as background" in load_table("b.json").source


def test_simulated_dives_have_no_frames_without_a_label(command):
    code, _, messages = command(
        "learn", "--scenario", "S1", "--unlabelled-is-empty", "--output", "table.json"
    )
    assert code == 2
    assert "--unlabelled-is-empty can only do something for a recording" in messages


def test_the_same_seed_gives_the_same_file_and_another_one_does_not(command, bag):
    contents = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        assert command("learn", bag, "--seed", seed, "--output", name)[0] == 0
        contents.append(Path(name).read_bytes())
    assert contents[0] == contents[1] != contents[2]


def test_the_filter_is_that_of_the_parameters(command, bag):
    Path("p.yaml").write_text("filter_sigma: 3.0\nworking_width: 80\n")
    assert command("learn", bag, "--output", "a.json")[0] == 0
    assert command("learn", bag, "--params", "p.yaml", "--output", "b.json")[0] == 0
    assert (load_table("a.json").edges != load_table("b.json").edges).any()


def test_the_frames_before_a_damage_count_and_the_other_recordings(command, bag, frames):
    write_bag(Path("broken"), frames, storage=StorageFormat.SQLITE3)
    (storage,) = Path("broken").glob("*.db3")
    os.truncate(storage, storage.stat().st_size // 2)
    wanted = ("learn", "--harder", 0, "--output")
    _, whole, _ = command(*wanted, "a.json", bag)
    code, printed, messages = command(*wanted, "b.json", "broken", bag)
    assert code == 2
    assert messages.splitlines()[-1].startswith("error: broken: damaged after ")
    assert first_numbers(whole)[0] < first_numbers(printed)[0] < 2 * FRAMES
    assert is_table(Path("b.json"))


def test_a_sequence_unreadable_from_its_first_frame_makes_no_table(command, labels):
    first = min(Path("pictures").rglob("*.png"))
    first.write_bytes(b"garbage")
    code, printed, messages = command("learn", labels, "--output", "table.json")
    assert (code, printed) == (2, "")
    assert first.name in messages
    assert left_behind() == {"pictures"}


def test_bad_frames_are_passed_over_where_that_is_wanted(command, labels):
    picture = sorted(Path("pictures").rglob("*.png"))[2]
    picture.write_bytes(b"garbage")
    code, _, messages = command("learn", labels, "--output", "table.json")
    assert (code, messages.count("\n")) == (2, 1)
    assert picture.name in messages
    # Those before it count.
    assert Path("table.json").exists()
    code, printed, _ = command(
        "learn", labels, "--output", "table.json", "--skip-bad-frames", "--force"
    )
    assert code == 0
    assert printed.startswith(f"{FRAMES - 1} frames and ")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "there is nothing to learn from; name a labelled recording"),
        (("unlabelled",), "unlabelled: has no ground truth to learn from"),
        (("dive", "unlabelled"), "unlabelled: has no ground truth to learn from"),
        (("dive", "unlabelled", "--truth", "x.txt"), "--truth labels a single recording, not 2"),
        (("--scenario", "S1", "--truth", "x.txt"), "--truth labels a single recording, not 0"),
        (("nothing.mcap",), "nothing.mcap: there is no such file"),
        (("garbage.mcap",), "garbage.mcap"),
        (("dive", "--seeds", "1"), "--seeds can only do something with --scenario"),
        (("dive", "--frames", "1"), "--frames can only do something with --scenario"),
        (("--scenario", "S7"), "'S7' is none of S1 | "),
        (("--scenario", "report_clear"), "report_clear is a world to report on"),
        (("--scenario", "S1", "--seeds", "0"), "seeds is 0: give at least 1"),
        (("--scenario", "no_cable", "--frames", "2"), "no labelled frame shows a border"),
        (("dive", "--seed", "-1"), "seed: -1 is outside"),
        (("dive", "--params", "missing.yaml"), "missing.yaml: there is no such file"),
        (("dive", "--output", "dive/metadata.yaml/table.json"), "cannot be written"),
    ],
)
def test_bad_wishes_are_refused_in_one_line(command, bag, unlabelled, arguments, words):
    Path("garbage.mcap").write_bytes(b"no recording \x00\xff" * 50)
    before = left_behind()
    output = () if "--output" in arguments else ("--output", "table.json")
    code, printed, messages = command("learn", *arguments, *output)
    assert code == 2
    assert printed == ""
    assert words in messages
    assert messages.count("\n") == 1
    assert left_behind() == before


def test_labels_beside_the_picture_teach_nothing(command, unlabelled):
    lines = (f"5000 0 30 0 # {path.name}" for path in sorted(unlabelled.iterdir()))
    Path("far.txt").write_text("\n".join(lines) + "\n")
    code, _, messages = command("learn", unlabelled, "--truth", "far.txt", "--output", "t.json")
    assert code == 2
    assert "no labelled frame shows a border" in messages
    assert not Path("t.json").exists()


def test_the_origin_names_scenarios_and_seeds():
    plan = LearningPlan(harder=0)
    assert describe_origin(["S1", "night"], [2, 3], [], None, plan) == (
        "simulated S1, night with seeds 2, 3"
    )


def test_the_origin_names_no_folders():
    plan = LearningPlan(every=4, harder=0)
    origin = describe_origin([], [], [Path("/home/me/dive.mcap")], Path("/x/y/labels.txt"), plan)
    assert origin == "dive.mcap labelled by labels.txt; one frame in 4"


@pytest.mark.parametrize("content", ["", "{", "[]", "{}", '{"source": 1}', "[" * 100_000])
def test_other_files_are_recognised_as_no_table(tmp_path, content):
    (tmp_path / "x.json").write_text(content)
    assert not is_table(tmp_path / "x.json")


def test_a_table_names_the_worlds_of_a_pattern_that_it_lacks(monkeypatch, command, tmp_path):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "none"))
    code, _, messages = command(
        "learn", "--scenario", "tune_[ce]*", "--frames", 1, "--harder", 0, "--output", "table.json"
    )
    assert code == 0
    assert messages.startswith("note: tune_empty is left out: ")
    assert "tune_[ce]* without tune_empty with seed 0" in load_table("table.json").source
