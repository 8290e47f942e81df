import shutil

import pytest

from cable_tracker.commands.many_runs.cables import tuned_filters
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.report import REPORT
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate
from cable_tracker.simulation.worlds.ground import FOLDER_VARIABLE


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A labelled recording of five frames."""
    path = tmp_path_factory.mktemp("recording") / "dive"
    write_sequence(path, simulate(SimulationSettings(frame_count=5, image_size=(160, 120))))
    return path


@pytest.fixture
def labels(written, tmp_path):
    """The sequence file of a copy of it."""
    shutil.copytree(written, tmp_path / "dive")
    (path,) = (tmp_path / "dive").glob("*.txt")
    return path


@pytest.fixture
def empty_figures(monkeypatch):
    """Leave the figures of reports empty: to draw them takes most of the time of an evaluation."""
    monkeypatch.setattr("cable_tracker.evaluation.report.as_svg", lambda _: "<svg></svg>")


@pytest.mark.usefixtures("empty_figures")
def test_user_parameters_are_evaluated_beside_the_default(command, tmp_path, labels):
    (tmp_path / "mine.yaml").write_text("particle_count: 60\n")
    code, _, error = command(
        "evaluate", "--source", labels, "--params", tmp_path / "mine.yaml", "-p", "seed:=3",
        "--seeds", 1, "--workers", 1, "--output", tmp_path / "out",
    )  # fmt: skip
    assert (code, error) == (0, "")
    rows = (tmp_path / "out" / "runs.csv").read_text().splitlines()[1:]
    assert {name for row in rows for name in ("default", "mine") if name in row} == {
        "default",
        "mine",
    }
    assert len(rows) == 2


@pytest.mark.usefixtures("empty_figures")
def test_pictures_without_labels_are_evaluated_as_empty_on_request(command, tmp_path, labels):
    labels.unlink()
    judged = ("evaluate", "--source", labels.parent, "--seeds", 1, "--workers", 1)
    code, _, error = command(
        *judged, "--method", "thesis", "--output", tmp_path / "out", "--unlabelled-is-empty"
    )
    assert (code, error) == (0, "")
    code, _, error = command(*judged, "--output", tmp_path / "other")
    assert code == 2
    assert "has no ground truth" in error


@pytest.mark.parametrize("options", [(), ("--targets",)])
def test_labels_without_a_recording_are_refused(command, tmp_path, options):
    code, _, error = command("evaluate", "--truth", tmp_path / "boxes.txt", *options)
    assert code == 2
    assert "--truth can only do something for a recording, --source" in error


def test_trackers_with_user_parameters_are_named_after_their_files(tmp_path):
    for name in ("a", "b", "default"):
        (tmp_path / f"{name}.yaml").write_text("preset: thesis\nloss_time: 2.0\n")
    files = [tmp_path / "a.yaml", tmp_path / "b.yaml"]
    one, other = tuned_filters(files, ["loss_time=1.5"], tmp_path / "table.json")
    assert (one.name, other.name) == ("a", "b")
    assert one.parameters == other.parameters
    assert one.parameters.filter == "bootstrap"
    assert one.parameters.loss_time == 1.5
    assert one.parameters.response_table == str(tmp_path / "table.json")
    assert [each.name for each in tuned_filters(None, ["loss_time=1"], None)] == ["tuned"]
    assert tuned_filters(None, None, None) == ()
    (tmp_path / "sub").mkdir()
    for names in (["default.yaml"], ["a.yaml", "sub/../a.yaml"]):
        with pytest.raises(ParameterError, match="rename a file"):
            tuned_filters([tmp_path / name for name in names], None, None)


def test_a_value_without_effect_is_noted_once_for_all_files(tmp_path, capsys):
    files = [tmp_path / "a.yaml", tmp_path / "b.yaml"]
    for file in files:
        file.write_text("particle_count: 60\n")
    tuned_filters(files, ["image_transport=raw", "camera_pitch=70.0"], None)
    noted = capsys.readouterr().err
    assert [noted.count(name) for name in ("image_transport", "camera_pitch")] == [1, 1]


def test_scenarios_are_evaluated(command, tmp_path):
    out = tmp_path / "out"
    code, printed, _ = command(
        "evaluate", "--scenario", "S6", "--scenario", "tune_clear", "--method", "thesis",
        "--method", "lsd", "--frames", 3, "--seeds", 1, "--workers", 1, "--output", out,
    )  # fmt: skip
    assert code == 0
    assert "thesis" in printed
    assert (
        "runs: told where the cable is in the first frame, if that has a label; --init random"
        in printed
    )
    assert str(out / REPORT) in printed.replace("\n", "")
    assert len((out / "runs.csv").read_text().splitlines()) == 1 + 2 * 2
    assert "--scenario S6" in (out / REPORT).read_text(encoding="utf-8")


@pytest.mark.usefixtures("empty_figures")
def test_worlds_of_a_pattern_that_need_photographs_are_left_out_with_a_note(
    monkeypatch, command, tmp_path
):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "none"))
    code, _, messages = command(
        "evaluate", "--scenario", "tune_[ce]*", "--method", "lsd", "--frames", 1, "--seeds", 1,
        "--workers", 1, "--output", tmp_path / "out",
    )  # fmt: skip
    assert code == 0
    assert messages.startswith("note: tune_empty is left out: ")
    assert "tune_clear" in (tmp_path / "out" / "runs.csv").read_text()


@pytest.mark.usefixtures("empty_figures")
def test_an_evaluation_that_goes_on_does_only_what_is_missing(command, tmp_path):
    out = tmp_path / "out"

    def evaluated(seeds, *words):
        code, _, error = command(
            "evaluate", "--scenario", "tune_clear", "--method", "thesis", "--frames", 2,
            "--workers", 1, "--first-seed", 40, "--seeds", seeds, "--output", out, *words,
        )  # fmt: skip
        assert (code, error) == (0, "")
        return (out / "runs.csv").read_text().splitlines()[1:]

    first = evaluated(1)
    kept = {file.name: file.stat().st_mtime_ns for file in (out / "tasks").iterdir()}
    assert len(kept) == 1
    both = evaluated(2, "--resume")
    # The very same row, with the times that it took then.
    assert both[0] == first[0]
    assert [line.split(",")[2] for line in both] == ["40", "41"]
    assert "seeds 40 to 41" in (out / REPORT).read_text(encoding="utf-8")
    assert len(list((out / "tasks").iterdir())) == 2
    assert not out.with_name("out.tasks").exists()


def test_results_stay_where_the_report_is_stopped(monkeypatch, command, tmp_path):
    class Signal(BaseException):
        """Stops whatever is going on."""

    def stopped(*_, **__):
        raise Signal

    monkeypatch.setattr("cable_tracker.commands.many_runs.cables.write_report", stopped)
    with pytest.raises(Signal) as stop:
        command(
            "evaluate", "--scenario", "tune_clear", "--method", "thesis", "--frames", 2,
            "--workers", 1, "--seeds", 2, "--output", tmp_path / "out",
        )  # fmt: skip
    assert len(list((tmp_path / "out.tasks").iterdir())) == 2
    assert [note.split(" kept in ")[0] for note in stop.value.__notes__] == ["2 finished tasks are"]


@pytest.mark.usefixtures("empty_figures")
def test_a_labelled_recording_is_evaluated(command, labels, tmp_path):
    out = tmp_path / "out"
    code, printed, _ = command(
        "evaluate", "--source", labels, "--method", "thesis", "--init", "random",
        "--seeds", 1, "--output", out,
    )  # fmt: skip
    assert code == 0
    assert "runs: not told where the cable is" in printed
    assert len((out / "frames.csv").read_text().splitlines()) == 1 + 5


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--scenario", "S7"), "'S7' is none of S1 | S2"),
        (("--method", "magic"), "'magic' is none of default | thesis"),
        (("--seeds", "0"), "seeds is 0"),
        (("--first-seed", "-1"), "first-seed is -1: give 0 to"),
        (("--first-seed", "2000000000"), "first-seed is 2000000000: give 0 to"),
        (("--truth", "x.txt"), "--truth can only do something for a recording, --source"),
        (("--unlabelled-is-empty",), "--unlabelled-is-empty can only do something for a recording"),
        (("--rate", "25"), "--rate can only do something for a recording"),
        (("--topic", "x", "--allow-outside"), "--topic and --allow-outside can only do something"),
        (("--skip-bad-frames", "--targets"), "--skip-bad-frames can only do something"),
        (("--source", "x.txt", "--scenario", "S1"), "--scenario can do nothing with --source"),
        (("--targets", "-p", "seed=1"), "--param can do nothing with --targets"),
        (("--source", "x.txt"), "no such file"),
        (("--scenario", "S1", "--workers", "0", "--frames", "2"), "workers is 0"),
    ],
)
def test_bad_wishes_are_refused_in_one_line(command, tmp_path, arguments, words):
    code, printed, messages = command("evaluate", *arguments, "--output", tmp_path / "out")
    assert code == 2
    assert printed == ""
    assert words in messages
    assert messages.count("\n") == 1
    assert not any(tmp_path.iterdir())


def test_a_malformed_line_of_the_truth_is_named(command, labels, tmp_path):
    with labels.open("a") as file:
        file.write("1 2 three 4 # x.png\n")
    code, _, messages = command("evaluate", "--source", labels, "--output", tmp_path / "out")
    assert code == 2
    assert f"line {len(labels.read_text().splitlines())} is malformed" in messages


def test_workers_are_sent_absolute_paths(monkeypatch, command, labels, tmp_path):
    sent = []
    monkeypatch.setattr(
        "cable_tracker.commands.evaluate.evaluate_cables",
        lambda campaign, *_args, **_options: sent.append(campaign),
    )
    monkeypatch.chdir(tmp_path)
    source = labels.relative_to(tmp_path)
    code, _, _ = command(
        "evaluate", "--source", source, "--truth", source, "-p", "response_table=table.json"
    )
    assert code == 0
    (campaign,) = sent
    assert [each.path for each in campaign.sequences] == [labels]
    assert [each.truth for each in campaign.sequences] == [labels]
    assert campaign.filters[0].parameters.response_table == str(tmp_path / "table.json")
