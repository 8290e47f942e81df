"""`cable-tracker evaluate --targets`."""

import csv

import pytest


def rows(folder):
    with (folder / "figures.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_scenarios_are_judged_with_two_seeds(command, tmp_path):
    words = ("--scenario", "near_*", "--frames", 6, "--seeds", 2, "--first-seed", 7)
    methods = ("--method", "default", "--method", "CamShift", "--workers", 1)
    result = command("evaluate", "--targets", *words, *methods, "--output", tmp_path / "out")
    assert result.code == 0, result.err
    found = {(row["scenario"], row["seed"], row["method"]) for row in rows(tmp_path / "out")}
    assert found == {
        ("near_surface", seed, method) for seed in "78" for method in ("default", "CamShift")
    }
    assert "| default | " in (tmp_path / "out" / "table.md").read_text()


def test_a_simulated_recording_is_evaluated_with_a_parameter_file(command, tmp_path):
    dive = tmp_path / "dive"
    made = command("simulate", dive, "--target", "near_surface", "--frames", 6)
    assert made.code == 0, made.err
    file = tmp_path / "few.yaml"
    file.write_text("target_tracker:\n  ros__parameters:\n    particle_count: 60\n")
    words = ("--source", dive, "--params", file, "--seeds", 1)
    result = command("evaluate", "--targets", *words, "--output", tmp_path / "out")
    assert result.code == 0, result.err
    assert [(row["scenario"], row["method"]) for row in rows(tmp_path / "out")] == [
        ("dive", "default"), ("dive", "few"),
    ]  # fmt: skip
    assert all(float(row["success"]) > 0.5 for row in rows(tmp_path / "out"))


def test_a_recording_whose_name_is_not_utf_8_is_judged(command, tmp_path):
    out = tmp_path / "out"
    command("simulate", tmp_path / "dive", "--target", "near_surface", "--frames", 3)
    dive = (tmp_path / "dive").rename(tmp_path / "Tauchg\udce4nge")
    words = ("--source", dive, "--method", "CamShift", "--seeds", 1, "--output", out)
    result = command("evaluate", "--targets", *words)
    assert result.code == 0, result.err
    assert "Tauchg?nge" in result.out
    assert rows(out)[0]["scenario"] == "Tauchg?nge"
    assert "Tauchg?nge" in (out / "table.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "words",
    [
        ("--scenario", "S1"),
        ("--scenario", "nothing"),
        ("--method", "hough"),
        ("--init", "random"),
        ("--param", "seed=3"),
        ("--source", ".", "--scenario", "buoy"),
    ],
)
def test_options_that_targets_do_not_have_are_refused(command, tmp_path, words):
    result = command("evaluate", "--targets", *words, "--output", tmp_path / "out")
    assert result.code == 2
    assert not (tmp_path / "out").exists()
