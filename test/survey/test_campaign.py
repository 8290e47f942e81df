import csv
import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from rewriting import rewritten

from cable_tracker.atomic_output import alone_in
from cable_tracker.campaigns.folder_tasks import TaskState
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.errors import OutputError, RecordingError
from cable_tracker.sequences.bags.instruments import NO_TOPIC, Instrument, InstrumentChoice
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings as Simulated
from cable_tracker.simulation.instruments.survey_dive import write_survey_bag
from cable_tracker.survey.campaign import (
    RECORDINGS,
    SurveyTask,
    holds_survey,
    names_of,
    run_survey,
)
from cable_tracker.survey.forward_pass import ForwardSettings
from cable_tracker.survey.outputs.surveyed_dive import read_origin, read_surveyed
from cable_tracker.survey.recording import SurveySettings
from cable_tracker.survey.routes.events import Limits

ALONE = ClusterSettings()


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("dives") / "dive"
    write_survey_bag(path, Simulated(length=3.0, rate=5.0, image_size=(160, 120), current=0.0))
    return path


@pytest.fixture(scope="module")
def surveyed(bag, tmp_path_factory):
    broken = bag.parent / "broken.mcap"
    broken.write_bytes(b"no bag")
    output = tmp_path_factory.mktemp("map")
    return output, run_survey([bag, broken], output, SurveySettings(), ALONE), [bag, broken]


def copied(output: Path, folder: Path) -> Path:
    """Copy a map of others, for what a test does to it."""
    return shutil.copytree(output, folder / "map")


@pytest.fixture(scope="module")
def pictured(bag, tmp_path_factory):
    """The map of one dive, with pictures; to be read only."""
    output = tmp_path_factory.mktemp("pictured") / "map"
    run_survey([bag], output, SurveySettings(), ALONE)
    return output


@pytest.fixture(scope="module")
def unpictured(bag, tmp_path_factory):
    """The map of one dive, without pictures; to be read only."""
    output = tmp_path_factory.mktemp("unpictured") / "map"
    run_survey([bag], output, SurveySettings(pictures=False), ALONE)
    return output


def test_a_dive_becomes_a_route_and_a_broken_one_a_row(surveyed):
    output, result, _ = surveyed
    assert [outcome.state for outcome in result.outcomes] == [TaskState.DONE, TaskState.FAILED]
    assert "broken.mcap" in result.rows[1].state
    (route,) = result.routes
    assert route.along[-1] == pytest.approx(3.0, abs=1.5)
    for name in ("route.gpkg", "route.geojson", "events.csv", "frames.parquet", "report.html"):
        assert (output / name).stat().st_size > 0


def test_routes_are_numbered_from_the_longest(bag, tmp_path):
    longer = tmp_path / "longer"
    write_survey_bag(longer, Simulated(length=6.0, rate=5.0, image_size=(160, 120), current=0.0))
    without_fixes = SurveySettings(
        ForwardSettings(choice=InstrumentChoice({Instrument.FIX: NO_TOPIC})), pictures=False
    )
    result = run_survey([bag, longer], tmp_path / "map", without_fixes, ALONE)
    lengths = [route.along[-1] for route in result.routes]
    assert len(lengths) == 2
    assert lengths[0] > lengths[1]


def without_fix(bag, folder):
    def change(topic, message, time):
        if topic != "/fix":
            yield topic, message, time

    return rewritten(bag, folder / "without_fix", change)


def test_routes_have_the_names_of_their_files(bag, tmp_path):
    other = without_fix(bag, tmp_path)
    output = tmp_path / "map"
    result = run_survey([other, bag], output, SurveySettings(pictures=False), ALONE)
    assert result.names == ("route 1", "without_place: route 1")
    assert [route.recordings for route in result.routes] == [("dive",), ("without_fix",)]
    for folder, recording in ((output, "dive"), (output / "without_place", "without_fix")):
        rows = list(csv.DictReader((folder / "events.csv").read_text().splitlines()))
        assert {(row["route"], row["recording"]) for row in rows} == {("route 1", recording)}


def test_a_folder_that_another_survey_is_writing_is_refused_and_as_it_was(bag, unpictured):
    before = sorted((file, file.stat().st_mtime_ns) for file in unpictured.rglob("*"))
    with (
        alone_in(unpictured / RECORDINGS),
        pytest.raises(OutputError, match="another run is writing it; wait"),
    ):
        run_survey([bag], unpictured, SurveySettings(pictures=False), ALONE)
    assert sorted((file, file.stat().st_mtime_ns) for file in unpictured.rglob("*")) == before


def test_what_the_user_puts_beside_the_map_of_dives_without_a_fix_stays(bag, tmp_path):
    other = without_fix(bag, tmp_path)
    beside, settings = tmp_path / "map" / "without_place", SurveySettings(pictures=False)
    run_survey([bag, other], tmp_path / "map", settings, ALONE)
    (beside / "notes.txt").write_text("mine")
    run_survey([bag, other], tmp_path / "map", settings, ALONE, resume=True)
    assert (beside / "notes.txt").read_text() == "mine" and (beside / "route.gpkg").exists()
    # Where no dive is without a fix, nothing but that is left.
    run_survey([bag], tmp_path / "map", settings, ALONE, resume=True)
    assert [each.name for each in beside.iterdir()] == ["notes.txt"]
    (beside / "notes.txt").unlink()
    run_survey([bag], tmp_path / "map", settings, ALONE, resume=True)
    assert not beside.exists()


def test_a_survey_without_routes_leaves_no_map_of_an_earlier_one(bag, pictured, tmp_path):
    output = copied(pictured, tmp_path)
    assert (output / "route.gpkg").exists()
    unmeasured = ForwardSettings(choice=InstrumentChoice({Instrument.ALTITUDE: NO_TOPIC}))
    assert run_survey([bag], output, SurveySettings(unmeasured), ALONE).routes == ()
    assert not (output / "route.gpkg").exists()


def test_a_picture_that_was_not_kept_is_not_named(pictured, unpictured):
    for output, pictures in ((pictured, True), (unpictured, False)):
        rows = csv.DictReader((output / "events.csv").read_text().splitlines())
        assert {bool(row["picture"]) for row in rows} == {pictures}


def test_a_changed_vehicle_file_is_seen_beside_a_storage_file_too(bag, tmp_path):
    copy = shutil.copytree(bag, tmp_path / "dive")
    for path in (copy, next(copy.glob("*.mcap"))):
        task = SurveyTask(path, SurveySettings(), "dive")
        before = task.fingerprint()
        with (copy / "vehicle.yaml").open("a") as file:
            file.write("# another\n")
        assert task.fingerprint() != before


def test_a_list_is_surveyed_anew_when_one_of_its_pictures_has_changed(tmp_path):
    picture, dive = tmp_path / "a.png", tmp_path / "dive.txt"
    picture.write_bytes(b"one")
    dive.write_text("1 0 30 0 # a.png\n")
    task = SurveyTask(dive, SurveySettings(), "dive")
    before = task.fingerprint()
    picture.write_bytes(b"another")
    assert task.fingerprint() != before


def test_results_in_the_folder_of_the_recording_do_not_make_it_another(bag, tmp_path):
    dive = shutil.copytree(bag, tmp_path / "dive")
    run_survey([dive], dive / "map", SurveySettings(), ALONE)
    again = run_survey([dive], dive / "map", SurveySettings(), ALONE, resume=True)
    assert [outcome.state for outcome in again.outcomes] == [TaskState.KEPT]


def test_a_picture_or_a_storage_file_that_has_changed_makes_it_another(tmp_path):
    task = SurveyTask(tmp_path, SurveySettings(), "dive")
    found = [task.fingerprint()]
    for name in ("a.png", "b.png", "dive.mcap", "a.png"):
        with (tmp_path / name).open("a") as file:
            file.write("more")
        found.append(task.fingerprint())
    assert len(set(found)) == len(found)


def test_a_dive_with_a_broken_vehicle_file_ends_no_other(bag, tmp_path):
    broken = shutil.copytree(bag, tmp_path / "broken")
    (broken / "vehicle.yaml").write_text("mounting: sideways\n")
    result = run_survey([broken, bag], tmp_path / "map", SurveySettings(), ALONE)
    assert [outcome.state for outcome in result.outcomes] == [TaskState.FAILED, TaskState.DONE]
    assert "vehicle.yaml" in result.rows[0].state


def test_what_was_written_is_read_back(surveyed):
    output, result, _ = surveyed
    dive = read_surveyed(output / "recordings/dive")
    assert dive.on_earth and dive.frames == result.rows[0].frames
    assert dive.routes[0].route.along[-1] > 1.0


@pytest.mark.parametrize("name", ["routes.npz", "frames.parquet"])
@pytest.mark.parametrize("length", [0, 20, 2000])
def test_a_dive_that_was_cut_off_is_told(surveyed, tmp_path, name, length):
    dive = shutil.copytree(surveyed[0] / "recordings/dive", tmp_path / "dive")
    file = dive / name
    file.write_bytes(file.read_bytes()[:length])
    with pytest.raises(RecordingError, match="survey the recording again"):
        read_surveyed(dive)


def damaged(content: bytes) -> bytes:
    """Overwrite a piece in the middle."""
    return content[:200] + bytes(range(256)) * 2 + content[712:]


@pytest.mark.parametrize("damage", [damaged, lambda content: b""])
def test_a_kept_dive_whose_frames_are_damaged_is_a_row_that_failed(surveyed, tmp_path, damage):
    output = shutil.copytree(surveyed[0], tmp_path / "map")
    frames = output / "recordings/dive/frames.parquet"
    frames.write_bytes(damage(frames.read_bytes()))
    result = run_survey(surveyed[2], output, SurveySettings(), ALONE, resume=True)
    assert result.outcomes[0].state is TaskState.KEPT and not result.routes
    assert "survey the recording again" in result.rows[0].state
    assert result.is_earlier_map_kept


def test_earlier_dives_that_are_not_named_again_are_told(bag, surveyed, tmp_path):
    output = shutil.copytree(surveyed[0], tmp_path / "map")
    assert surveyed[1].left_out == ()
    again = shutil.copytree(bag, tmp_path / "another")
    result = run_survey([again], output, SurveySettings(pictures=False), ALONE, resume=True)
    assert result.left_out == ("dive",)


def test_a_dive_whose_disk_is_not_mounted_is_a_row_and_keeps_its_results(bag, surveyed, tmp_path):
    output = shutil.copytree(surveyed[0], tmp_path / "map")
    away = bag.rename(tmp_path / "away")
    try:
        result = run_survey([bag], output, SurveySettings(), ALONE, resume=True)
    finally:
        away.rename(bag)
    assert not result.routes
    assert "its earlier results stay in" in result.rows[0].state
    again = run_survey([bag], output, SurveySettings(), ALONE, resume=True)
    assert [outcome.state for outcome in again.outcomes] == [TaskState.KEPT]


def test_a_folder_of_recordings_is_no_survey(bag, surveyed, tmp_path):
    shutil.copytree(bag, tmp_path / "day/recordings/dive")
    assert not holds_survey(tmp_path / "day")
    assert not holds_survey(tmp_path)
    assert holds_survey(surveyed[0])
    (tmp_path / "none/recordings").mkdir(parents=True)
    assert holds_survey(tmp_path / "none")


def test_a_recording_that_lies_in_the_place_of_its_results_stays(bag, tmp_path):
    dive = shutil.copytree(bag, tmp_path / "day/recordings/dive")
    before = {file.name: file.read_bytes() for file in dive.iterdir()}
    result = run_survey([dive], tmp_path / "day", SurveySettings(), ALONE)
    assert [outcome.state for outcome in result.outcomes] == [TaskState.FAILED]
    assert {file.name: file.read_bytes() for file in dive.iterdir()} == before


def test_a_kept_dive_without_its_frames_is_a_row_that_failed(surveyed, tmp_path):
    output = shutil.copytree(surveyed[0], tmp_path / "map")
    (output / "recordings/dive/frames.parquet").unlink()
    result = run_survey(surveyed[2], output, SurveySettings(), ALONE, resume=True)
    assert "survey the recording again" in result.rows[0].state
    again = run_survey(surveyed[2], output, SurveySettings(), ALONE, resume=True)
    assert again.outcomes[0].state is TaskState.DONE and again.routes


def test_resuming_keeps_what_is_there_and_does_what_has_changed(surveyed):
    output, _, paths = surveyed
    again = run_survey(paths, output, SurveySettings(), ALONE, resume=True)
    assert [each.state for each in again.outcomes] == [TaskState.KEPT, TaskState.FAILED]
    other = SurveySettings(limits=Limits(least_burial=3.0))
    changed = run_survey(paths, output, other, ALONE, resume=True)
    assert changed.outcomes[0].state is TaskState.DONE


def test_a_dive_whose_name_is_no_utf8_is_surveyed_and_named_in_all_files(bag, tmp_path):
    dive = tmp_path / os.fsdecode(b"dive\xe9")
    shutil.copytree(bag, dive)
    broken = tmp_path / os.fsdecode(b"broken\xe9.mcap")
    broken.write_bytes(b"no bag")
    output = tmp_path / "map"
    result = run_survey([dive, broken], output, SurveySettings(pictures=False), ALONE)
    assert [row.name for row in result.rows] == ["dive\\xe9", "broken\\xe9.mcap"]
    assert "dive\\xe9" in (output / "report.html").read_text(encoding="utf-8")


def contents(folder):
    return {
        path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }


def test_a_mistyped_option_takes_neither_results_nor_map_away(bag, pictured, tmp_path):
    output = copied(pictured, tmp_path)
    before = contents(output)
    mistyped = SurveySettings(ForwardSettings(topic="/camera/imge"))
    result = run_survey([bag], output, mistyped, ALONE, resume=True)
    assert [outcome.state for outcome in result.outcomes] == [TaskState.FAILED]
    assert result.is_earlier_map_kept and not result.routes
    assert contents(output) == before
    again = run_survey([bag], output, SurveySettings(), ALONE, resume=True)
    assert [outcome.state for outcome in again.outcomes] == [TaskState.KEPT]
    assert not again.is_earlier_map_kept


def test_a_survey_of_broken_recordings_alone_has_a_report(tmp_path):
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"no bag")
    for _ in range(2):
        result = run_survey([broken], tmp_path / "map", SurveySettings(), ALONE)
        assert not result.is_earlier_map_kept
        assert "broken.mcap" in (tmp_path / "map/report.html").read_text()
        (tmp_path / "map/report.html").unlink()


def states(result):
    return [outcome.state for outcome in result.outcomes]


@pytest.fixture(scope="module")
def another(tmp_path_factory):
    """A dive over the same cable whose first fix is another, and whose name sorts first."""
    path = tmp_path_factory.mktemp("other_dives") / "a_dive"
    dive = Simulated(length=3.0, rate=5.0, image_size=(160, 120), current=0.0, seed=2)
    write_survey_bag(path, dive)
    return path


def test_a_dive_that_is_added_before_the_others_does_not_make_them_others(
    bag, another, unpictured, tmp_path
):
    plain, output = SurveySettings(pictures=False), copied(unpictured, tmp_path)
    both = run_survey([another, bag], output, plain, ALONE, resume=True)
    assert states(both) == [TaskState.DONE, TaskState.KEPT]
    again = run_survey([another, bag], output, plain, ALONE, resume=True)
    assert states(again) == [TaskState.KEPT] * 2


def test_a_datum_that_was_given_stays_until_another_is_given(bag, tmp_path):
    output, given = tmp_path / "map", SurveySettings(datum=(54.2, 7.8), pictures=False)
    run_survey([bag], output, given, ALONE)
    plain = replace(given, datum=None)
    assert states(run_survey([bag], output, plain, ALONE, resume=True)) == [TaskState.KEPT]
    other = replace(given, datum=(54.3, 7.8))
    assert states(run_survey([bag], output, other, ALONE, resume=True)) == [TaskState.DONE]
    assert states(run_survey([bag], output, plain, ALONE)) == [TaskState.DONE]
    assert read_origin(output / "recordings/dive").datum not in {given.datum, other.datum}


@pytest.mark.parametrize(
    "content", ["", "[]", "{}", '{"recording": 3, "datum": null}', '{"recording": "/a"}',
                '{"recording": "/a", "datum": [1]}', '{"recording": "/a", "datum": "ab"}']
)  # fmt: skip
def test_results_that_do_not_say_of_what_they_are_have_no_origin(tmp_path, content):
    assert read_origin(tmp_path) is None
    (tmp_path / "dive.json").write_text(content)
    assert read_origin(tmp_path) is None


@pytest.fixture(scope="module")
def days(bag, tmp_path_factory):
    """Dives of one name, on two days."""
    root = tmp_path_factory.mktemp("week")
    return [shutil.copytree(bag, root / day / "dive") for day in ("monday", "tuesday")]


@pytest.fixture(scope="module")
def monday(days, tmp_path_factory):
    """The map of the first of them; to be read only."""
    output = tmp_path_factory.mktemp("monday") / "map"
    run_survey(days[:1], output, SurveySettings(pictures=False), ALONE)
    return output


def test_a_second_dive_of_the_same_name_leaves_the_first_its_own(days, monday, tmp_path):
    plain = SurveySettings(pictures=False)
    both = run_survey(days, copied(monday, tmp_path), plain, ALONE, resume=True)
    assert [outcome.name for outcome in both.outcomes] == ["dive", "tuesday_dive"]
    assert states(both) == [TaskState.KEPT, TaskState.DONE]
    assert both.left_out == ()


def test_a_dive_takes_no_results_of_another_one_of_its_name_away(days, monday, tmp_path):
    plain = SurveySettings(pictures=False)
    second = run_survey(days[1:], copied(monday, tmp_path), plain, ALONE, resume=True)
    assert [outcome.name for outcome in second.outcomes] == ["tuesday_dive"]
    assert second.left_out == ("dive",)


def test_a_dive_that_was_moved_keeps_its_results(days, tmp_path):
    plain = SurveySettings(pictures=False)
    dive = shutil.copytree(days[0], tmp_path / "a/dive")
    run_survey([dive], tmp_path / "map", plain, ALONE)
    moved = dive.rename(tmp_path / "dive")
    assert states(run_survey([moved], tmp_path / "map", plain, ALONE, resume=True)) == [
        TaskState.KEPT
    ]


def test_earlier_results_of_a_named_dive_under_another_name_are_not_left_out(days, tmp_path):
    plain = SurveySettings(pictures=False)
    run_survey(days, tmp_path / "map", plain, ALONE)
    alone = run_survey(days[:1], tmp_path / "map", plain, ALONE)
    assert [outcome.name for outcome in alone.outcomes] == ["dive"]
    assert alone.left_out == ("tuesday_dive",)


def test_names_that_are_taken_are_not_given_again():
    first, second = Path("/monday/dive"), Path("/tuesday/dive")
    assert names_of([first, second]) == ["monday_dive", "tuesday_dive"]
    assert names_of([first, second], {"dive": first}) == ["dive", "tuesday_dive"]
    assert names_of([second], {"dive": first}) == ["tuesday_dive"]
    assert names_of([first], {"dive": first, "monday_dive": first}) == ["dive"]
    taken = {"dive": first, "tuesday_dive": Path("/a")}
    assert names_of([Path("/week/tuesday/dive")], taken) == ["week_tuesday_dive"]


def test_notes_beside_the_results_of_a_dive_stay_when_it_is_surveyed_anew(bag, pictured, tmp_path):
    dive = copied(pictured, tmp_path) / "recordings/dive"
    for pictures in (True, False):
        (dive / "notes.txt").write_text("an hour of thoughts")
        run_survey([bag], tmp_path / "map", SurveySettings(pictures=pictures), ALONE)
    assert {each.name for each in dive.iterdir()} == {
        "dive.json", "frames.parquet", "notes.txt", "routes.npz", "task.json",
    }  # fmt: skip
