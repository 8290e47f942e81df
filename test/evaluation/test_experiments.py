import csv
import dataclasses

import cv2
import numpy as np
import pytest

from cable_tracker.evaluation.experiments import (
    EXPERIMENTS,
    TABLE_CSV,
    TABLE_MARKDOWN,
    ExperimentResult,
    Picture,
    ReinitialisationExperiment,
    SequenceExperiment,
    SpeedExperiment,
    table_csv,
    write_experiment,
)


@pytest.fixture
def long_stripe(stripe):
    return dataclasses.replace(stripe, length=135)


def test_sequences_are_followed_by_every_method(stripe):
    experiment = SequenceExperiment((0, 1), sequences=(stripe,))
    told = []
    result = experiment.run(1, told.append)
    assert [row[:3] for row in result.rows] == [
        ("stripe", "default", "2"),
        ("stripe", "thesis", "2"),
    ]
    assert [picture.file_name for picture in result.pictures] == ["sequence_stripe.png"]
    assert sum(told) == experiment.frame_count() == 24


def test_the_search_begins_anew_every_100_frames(long_stripe):
    experiment = ReinitialisationExperiment((0,), ("default",), (long_stripe,))
    result = experiment.run(1, lambda count: None)
    sequence, everything = result.rows
    # 135 frames: one whole part and one of 35 frames, enough to tell.
    assert sequence[:3] == ("stripe", "default", "2")
    assert everything[:3] == ("all", "default", "2")
    assert sum(float(share) for share in sequence[3:6]) == pytest.approx(100.0)


def test_speed_is_measured_for_every_combination(stripe):
    experiment = SpeedExperiment((0,), stripe, particles=(50, 400), taps=(5, 11))
    result = experiment.run(2, lambda count: None)
    assert [row[:2] for row in result.rows] == [
        ("50", "5"),
        ("400", "5"),
        ("50", "11"),
        ("400", "11"),
    ]
    few, many = (float(row[2]) for row in result.rows[2:])
    assert 0.0 < few < many


def test_every_row_has_a_number_for_every_heading(stripe):
    result = SpeedExperiment((0,), stripe, particles=(50,), taps=(5,)).run(1, lambda count: None)
    assert all(len(row) == len(result.headings) for row in result.rows)


def test_tables_and_figures_are_written(tmp_path):
    picture = cv2.imencode(".png", np.zeros((4, 4), np.uint8))[1].tobytes()
    result = ExperimentResult("T", ("a", "b [px]"), (("x", "−1.5"),), (Picture("f.png", picture),))
    write_experiment(tmp_path, result, "On a machine.")
    with (tmp_path / TABLE_CSV).open() as file:
        assert list(csv.reader(file)) == [["a", "b [px]"], ["x", "-1.5"]]
    text = (tmp_path / TABLE_MARKDOWN).read_text(encoding="utf-8")
    assert "| x | −1.5 |" in text
    assert "![f.png](f.png)" in text
    assert (tmp_path / "f.png").read_bytes() == picture


def test_unknown_numbers_are_left_empty_for_machines():
    assert table_csv(ExperimentResult("T", ("a", "b"), (("–", "1"),), ())) == "a,b\n,1\n"


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_experiment_knows_how_long_it_takes(name):
    assert EXPERIMENTS[name]((0, 1)).frame_count() == 2 * EXPERIMENTS[name]((0,)).frame_count()
