import os
from pathlib import Path

import pytest

from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME, TrackerParameters
from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.errors import GuiError, OutputError, ParameterError
from cable_tracker.gui.subject import CABLE, TARGET
from cable_tracker.gui.tracking.parameter_sheet import (
    grouped,
    parameter_text,
    value_from_field,
    values_for_page,
    values_from_text,
    write_parameter_file,
)


@pytest.mark.parametrize("subject", [CABLE, TARGET])
def test_every_parameter_is_in_one_group_and_those_of_the_node_in_the_last(subject):
    groups = grouped(subject.session_table(is_live=True), subject.groups)
    own = [spec.name for title, rows in groups.items() if title != "Node" for spec in rows]
    assert sorted(own) == sorted(spec.name for spec in subject.kind.table)
    assert list(groups) == [title for title, _ in subject.groups]
    assert groups["Node"] == list(subject.kind.runtime)
    assert "Node" not in grouped(subject.kind.table, subject.groups)


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("particle_count", " 300 ", 300),
        ("particle_count", "1,000", "1,000"),
        ("seed", "1,5", "1,5"),
        ("tempering", "0,05", 0.05),
        ("tempering", "5e-2", 0.05),
        ("tempering", "much", "much"),
        ("filter", "bootstrap", "bootstrap"),
        ("response_table", "a,b", "a,b"),
    ],
)
def test_what_stands_in_a_field_is_read_as_a_person_means_it(name, text, value):
    assert value_from_field(PARAMETERS_BY_NAME[name], text) == value


def test_a_whole_number_is_shown_as_one():
    assert values_for_page({"a": 2.0, "b": 0.5, "c": True}) == {"a": 2, "b": 0.5, "c": True}


def test_what_is_saved_is_read_as_the_same():
    changed = TrackerParameters(tempering=0.07, filter="bootstrap", response_table="a b")
    text = parameter_text(changed.as_mapping(), "a\n dive", CABLE)
    assert text.startswith("# Tuned on a dive.\n")
    assert values_from_text(text, "file", CABLE) == changed.as_mapping()


def test_what_only_the_node_knows_is_saved_and_read_too():
    values = TrackerParameters().as_mapping() | {"camera_pitch": 70.0, "input_timeout": 2.0}
    assert values_from_text(parameter_text(values, "/boat/tracker", CABLE), "file", CABLE) == values


def test_a_file_may_name_its_preset_and_what_only_the_node_knows():
    read = values_from_text("preset: thesis\nseed: 3\nimage_transport: raw\n", "file", CABLE)
    assert read["filter"] == "bootstrap"
    assert read["seed"] == 3
    assert read["image_transport"] == "raw"


@pytest.mark.parametrize(
    "text", ["a: [", "colour: 1", "seed: -1", "input_timeout: -1", "just words", None]
)
def test_what_is_no_parameter_file_is_refused_by_its_name(text):
    with pytest.raises(ParameterError, match=r"my\.yaml"):
        values_from_text(text, "my.yaml", CABLE)


def test_a_file_is_replaced_only_when_that_is_wanted(tmp_path):
    path = tmp_path / "tracker.yaml"
    write_parameter_file(path, "one", CABLE, overwrite=False)
    with pytest.raises(GuiError, match="exists already"):
        write_parameter_file(path, "two", CABLE, overwrite=False)
    assert path.read_text() == "one"
    write_parameter_file(path, "two", CABLE, overwrite=True)
    assert path.read_text() == "two"
    for other in (tmp_path, Path("/dev/null")):
        with pytest.raises(GuiError, match="is a folder or a device; name a file"):
            write_parameter_file(other, "two", CABLE, overwrite=True)
    with pytest.raises(OutputError, match="cannot be written"):
        write_parameter_file(tmp_path / "none" / "tracker.yaml", "", CABLE, overwrite=False)


def test_a_file_that_cannot_be_replaced_stays_as_it_was(tmp_path, monkeypatch, full_disk):
    path = tmp_path / "tracker.yaml"
    path.write_text("precious")
    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(OutputError, match="No space left"):
        write_parameter_file(path, "two", CABLE, overwrite=True)
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]


TUNED = """# the boat's own file; ask before changing
preset: default  # the usual one
/**:
  ros__parameters:
    camera_pitch: 70.0  # measured on deck
/vehicle/tracker:
  ros__parameters:
    particle_count: 300  # so many the old computer takes
    filter_sigma: 2.0
controller:
  ros__parameters: {speed: 0.4}
"""


def saved(path, old, values):
    path.write_text(old)
    write_parameter_file(path, parameter_text(values, "a dive", CABLE), CABLE, overwrite=True)
    return path.read_text()


def test_of_a_file_with_parameters_only_the_values_that_differ_are_changed(tmp_path):
    old = TUNED.replace("preset: default  # the usual one\n", "")
    values = TrackerParameters().replaced({"particle_count": 800, "tempering": 0.25}).as_mapping()
    text = saved(tmp_path / "boat.yaml", old, values)
    assert text == old.replace("count: 300", "count: 800").replace(
        "    filter_sigma: 2.0\n",
        f"    filter_sigma: {values['filter_sigma']}\n    tempering: 0.25\n",
    )
    read = values_from_text(text, "boat.yaml", CABLE)
    assert all(read[name] == value for name, value in values.items())
    assert read["camera_pitch"] == 70.0


def test_a_plain_file_and_its_preset_stay_plain(tmp_path):
    old = "preset: thesis  # as in the thesis\nparticle_count: 200"
    values = PRESETS["thesis"].replaced({"particle_count": 700, "seed": 3}).as_mapping()
    text = saved(tmp_path / "plain.yaml", old, values)
    assert text == "preset: thesis  # as in the thesis\nparticle_count: 700\nseed: 3"


@pytest.mark.parametrize(
    "old",
    ["no parameters", "", "tracker: [", "camera: {ros__parameters: {rate: 5}}",
     "controller: {ros__parameters: {speed: 0.4}}"],
)  # fmt: skip
def test_a_file_without_parameters_of_the_node_is_replaced(tmp_path, old):
    values = TrackerParameters().replaced({"particle_count": 800}).as_mapping()
    text = saved(tmp_path / "other.yaml", old, values)
    assert text == parameter_text(values, "a dive", CABLE)


CONTROLLER = "controller: {ros__parameters: {speed: 0.4}}  # not ours\n"


@pytest.mark.parametrize(
    "old",
    ["tracker: {ros__parameters: {seed: 1}}\n", "tracker: {ros__parameters: {}}\n",
     "tracker: {ros__parameters: {wrong_name: 1}}\n",
     "tracker: {ros__parameters: {particle_count: -3}}\n"],
)  # fmt: skip
def test_what_cannot_be_changed_without_loss_is_left(tmp_path, old):
    values = TrackerParameters().replaced({"particle_count": 800}).as_mapping()
    with pytest.raises(GuiError, match="save under another name"):
        saved(tmp_path / "boat.yaml", old + CONTROLLER, values)
    assert (tmp_path / "boat.yaml").read_text() == old + CONTROLLER


@pytest.mark.parametrize(
    "itself",
    ["boat: &boat\n  boat: *boat\n", "boat: &boat\n  ros__parameters: {speed: 1}\n  boat: *boat\n"],
)
def test_a_namespace_that_names_itself_is_passed_over(tmp_path, itself):
    old = itself + "tracker:\n  ros__parameters:\n    particle_count: 300\n"
    values = TrackerParameters().replaced({"particle_count": 800}).as_mapping()
    assert saved(tmp_path / "boat.yaml", old, values) == old.replace("300", "800")


def test_line_ends_stay_as_they_are(tmp_path):
    path = tmp_path / "boat.yaml"
    path.write_bytes(b"# ours\r\nparticle_count: 300\r\n")
    values = TrackerParameters().replaced({"particle_count": 800}).as_mapping()
    write_parameter_file(path, parameter_text(values, "a dive", CABLE), CABLE, overwrite=True)
    assert path.read_bytes() == b"# ours\r\nparticle_count: 800\r\n"


def test_parameters_tuned_on_a_recording_whose_name_is_no_utf8_can_be_saved(tmp_path):
    text = parameter_text(TrackerParameters().as_mapping(), os.fsdecode(b"dive\xe9"), CABLE)
    write_parameter_file(tmp_path / "tracker.yaml", text, CABLE, overwrite=False)
    assert "Tuned on dive\\xe9." in (tmp_path / "tracker.yaml").read_text(encoding="utf-8")
