"""`cable-tracker survey`, `simulate --survey`, and what `track` makes of such bags."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from estimate_reader import read_estimates

from cable_tracker.commands.survey import parse_datum
from cable_tracker.errors import ParameterError

pytestmark = pytest.mark.slow

USER_ERROR = 2

Run = Callable[..., tuple[int, str]]


@pytest.fixture
def run(command: Callable[..., Any]) -> Run:
    """Run a command; return its exit code, and all that it said."""

    def run_command(*words: object) -> tuple[int, str]:
        outcome = command(*words)
        return outcome.code, " ".join((outcome.out + outcome.err).split())

    return run_command


@pytest.fixture(scope="module")
def dives(
    exit_code: Callable[..., int], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Path]:
    """Two short dives over one cable."""
    folder = tmp_path_factory.mktemp("dives")
    paths = (folder / "first", folder / "second")
    for seed, path in enumerate(paths):
        words = ("--survey", 3, "--rate", 6, "--size", "160x120", "--seed", seed)
        assert exit_code("simulate", path, *words) == 0
    return paths


@pytest.fixture(scope="module")
def surveyed(
    exit_code: Callable[..., int],
    dives: tuple[Path, Path],
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    output = tmp_path_factory.mktemp("map") / "out"
    assert exit_code("survey", *dives, "--output", output) == 0
    return output


def test_a_survey_dive_holds_its_truth_and_its_vehicle(dives):
    assert {"truth.json", "vehicle.yaml"} <= {file.name for file in dives[0].iterdir()}
    assert json.loads((dives[0] / "truth.json").read_text())["world"]


def test_a_survey_writes_all_of_its_files(surveyed):
    names = {file.name for file in surveyed.iterdir()}
    assert names == {
        "route.gpkg", "route.geojson", "events.csv", "frames.parquet", "report.html", "recordings",
    }  # fmt: skip
    assert set(pq.read_table(surveyed / "frames.parquet")["recording"].to_pylist()) == {
        "first", "second",
    }  # fmt: skip
    with (surveyed / "events.csv").open() as file:
        assert "found" in {row["kind"] for row in csv.DictReader(file)}


def test_an_earlier_survey_is_kept_unless_it_is_to_go_on(surveyed, dives, run):
    code, said = run("survey", *dives, "--output", surveyed)
    assert code == USER_ERROR
    assert "--resume" in said and "--force" in said
    code, said = run("survey", *dives, "--output", surveyed, "--resume")
    assert code == 0
    assert "2 recordings (2 kept from before)" in said


def test_dives_of_an_earlier_survey_that_are_not_in_the_map_are_named(
    surveyed, dives, run, tmp_path
):
    output = shutil.copytree(surveyed, tmp_path / "out")
    code, said = run("survey", dives[1], "--output", output, "--resume")
    assert code == 0
    assert "not in this map, for they were not named: first" in said


def test_a_survey_that_ended_before_its_first_result_may_be_given_again(tmp_path, dives, run):
    output = tmp_path / "out"
    words = ("survey", *dives, "--output", output, "--workers", 2)
    code, said = run(*words, "--memory", "much")
    assert code == USER_ERROR and "memory" in said
    code, said = run("survey", dives[0], "--output", output, "--no-pictures")
    assert code == 0, said


def test_a_folder_that_is_no_survey_is_never_written_over(tmp_path, dives, run):
    (tmp_path / "letter.txt").write_text("precious")
    code, said = run("survey", dives[0], "--output", tmp_path, "--force")
    assert code == USER_ERROR
    assert "no earlier survey" in said


def test_recordings_in_a_folder_of_that_name_are_never_written_over(tmp_path, dives, run):
    day = tmp_path / "day"
    bag = shutil.copytree(dives[0], day / "recordings/dive")
    before = sorted(file.name for file in bag.iterdir())
    for path in (bag, dives[1]):
        for how in ("--resume", "--force"):
            code, said = run("survey", path, "--output", day, how)
            assert code == USER_ERROR
            assert "choose another" in said
    assert sorted(file.name for file in bag.iterdir()) == before


def test_a_recording_that_cannot_be_read_is_a_row_and_the_others_are_done(tmp_path, dives, run):
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"nothing")
    code, said = run("survey", dives[0], broken, "--output", tmp_path / "out", "--no-pictures")
    assert code == 0
    assert "2 recordings (1 failed)" in said
    assert "broken.mcap: failed" in said
    assert not list((tmp_path / "out").glob("recordings/*/pictures"))


def test_only_broken_recordings_are_an_error(tmp_path, run):
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"nothing")
    code, said = run("survey", broken, "--output", tmp_path / "out")
    assert code != 0
    assert "none of the 1 recordings could be surveyed" in said


def test_a_mistyped_topic_is_refused_and_leaves_an_earlier_map(surveyed, dives, run, tmp_path):
    output = shutil.copytree(surveyed, tmp_path / "out")
    before = (output / "events.csv").read_bytes()
    code, said = run("survey", *dives, "--output", output, "--resume", "--topic", "/camera/imge")
    assert code == USER_ERROR
    assert "the earlier map in" in said and "is as it was" in said
    assert (output / "events.csv").read_bytes() == before


def test_workers_are_sent_absolute_paths(monkeypatch, tmp_path, run):
    sent = []

    def note(paths, output, settings, *_args, **_options):
        sent.append(settings)
        raise ParameterError("that will do")

    monkeypatch.setattr("cable_tracker.commands.survey.run_survey", note)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text("response_table: table.json\n")
    run("survey", "dive", "--output", "map", "--params", "mine.yaml")
    assert sent[0].forward.parameters.response_table == str(tmp_path / "table.json")


def test_pictures_are_thinned_as_asked(tmp_path, dives, run):
    code, said = run("survey", dives[0], "--output", tmp_path / "out", "--most-rate", 2)
    assert code == 0
    assert "pictures were tracked, 2 a second" in said


def test_without_odometry_there_is_no_route(tmp_path, dives, run):
    code, said = run("survey", dives[0], "--output", tmp_path / "out", "--odometry-topic", "none")
    assert code == 0
    assert "1 recordings, " in said
    assert "known in pixels only" in said
    assert "median sigma" not in said
    content = json.loads((tmp_path / "out/route.geojson").read_text())
    assert not [each for each in content["features"] if each["geometry"]["type"] == "LineString"]


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--datum", "north"), "datum"),
        (("--most-rate", "-1"), "most-rate"),
        (("--workers", "0"), "workers is 0"),
        (("--imu-topic", "/nothing"), "there is no topic /nothing"),
    ],
)
def test_bad_options_are_refused_with_the_reason(tmp_path, dives, run, words, reason):
    code, said = run("survey", dives[0], "--output", tmp_path / "out", *words)
    assert code != 0
    assert reason in said


def test_a_datum_is_two_numbers_of_a_place():
    assert parse_datum("54.25,7.9") == (54.25, 7.9)
    for text in ("54", "95,7", "a,b", "nan,0"):
        with pytest.raises(ParameterError, match="datum"):
            parse_datum(text)


@pytest.fixture(scope="module")
def tracked(
    exit_code: Callable[..., int],
    dives: tuple[Path, Path],
    tmp_path_factory: pytest.TempPathFactory,
):
    """Track a dive with options; return its table."""

    def track(*options: object):
        output = tmp_path_factory.mktemp("tracked") / "out"
        words = ("--output", output, "--no-video", "--no-pictures", "--no-bag", *options)
        assert exit_code("track", dives[0], *words) == 0
        return read_estimates(output / "estimates.csv")

    return track


def test_track_gives_metres_for_what_it_claims(tracked):
    claimed = [row for row in tracked() if row.status == "TRACKING"]
    assert claimed
    assert all(abs(row.metres.offset) < 0.6 for row in claimed)
    assert all(row.metres.sigma_offset > 0.0 for row in claimed)


def test_without_an_altitude_the_reason_for_missing_metres_is_noted(tracked):
    rows = tracked("--altitude-topic", "none")
    assert all(row.metres is None and "altitude" in row.no_metres for row in rows if row.state)


def test_an_altitude_may_be_chosen_by_its_vehicle_file(tracked, tmp_path):
    file = tmp_path / "vehicle.yaml"
    file.write_text("fixed_altitude: 4.0\n")
    near = [row for row in tracked("--altitude-topic", "none", "--vehicle", file) if row.state]
    assert near and all(row.metres is not None for row in near)


def test_without_odometry_the_filter_is_not_aided(tracked):
    aided, alone = tracked(), tracked("--odometry-topic", "none")
    assert [row.state for row in aided] != [row.state for row in alone]
