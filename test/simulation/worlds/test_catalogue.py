"""Worlds: their splits, their truth, their frames."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from cable_tracker.errors import ParameterError, RecordingError
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.simulation.worlds.catalogue import (
    WORLDS,
    Disturbance,
    Optics,
    Split,
    World,
    worlds_of,
)
from cable_tracker.simulation.worlds.ground import (
    FOLDER_VARIABLE,
    KINDS,
    photographed_texture,
    photographs_folder,
    photographs_of,
)
from cable_tracker.simulation.worlds.world_dive import simulate_world

MADE = [name for name, world in WORLDS.items() if not world.photographed]


def needs_photographs() -> None:
    """Skip where there are no photographs."""
    try:
        photographs_folder()
    except RecordingError as error:
        pytest.skip(str(error))


def frames_of(world: str | World, seed: int, count: int = 4):
    """Return the first frames of a dive."""
    return list(islice(simulate_world(world, seed), count))


def images_of(world: str | World, seed: int, count: int = 4) -> list[np.ndarray]:
    return [decode_grey(each.frame.image) for each in frames_of(world, seed, count)]


def test_each_kind_is_there_once_to_tune_on_and_once_to_report_on():
    names = [{world.name.split("_", 1)[1] for world in worlds_of(split)} for split in Split]
    assert names[0] == names[1]
    assert sum(len(worlds_of(split)) for split in Split) == len(WORLDS)


def test_the_splits_share_no_kind_of_texture():
    assert not set(KINDS[Split.TUNE]) & set(KINDS[Split.REPORT])


def test_the_splits_share_no_photograph():
    needs_photographs()
    tune, report = (set(photographs_of(split)) for split in Split)
    assert tune
    assert report
    assert not tune & report


def test_the_same_seed_of_the_two_splits_is_another_dive():
    tune, report = (frames_of(f"{split.value}_clear", 3, 1)[0] for split in Split)
    assert tune.frame.truth != report.frame.truth


@pytest.mark.parametrize("name", MADE)
def test_the_same_seed_gives_the_same_frames(name):
    for first, second in zip(images_of(name, 5, 2), images_of(name, 5, 2), strict=True):
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("name", MADE)
def test_another_seed_gives_another_dive(name):
    assert (images_of(name, 5, 1)[0] != images_of(name, 6, 1)[0]).any()


def test_a_world_without_a_cable_has_no_truth():
    for item in frames_of("report_decoys", 0):
        assert item.frame.truth is None
        assert item.visibility == 0.0


def test_worlds_of_photographs_say_what_is_missing(monkeypatch, tmp_path):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "none"))
    with pytest.raises(RecordingError, match=FOLDER_VARIABLE):
        simulate_world("tune_inspection", 0)


def test_a_photograph_that_cannot_be_read_is_refused_in_words(tmp_path):
    (tmp_path / "lost.jpg").symlink_to("nowhere.jpg")
    (tmp_path / "folder.jpg").mkdir()
    (tmp_path / "empty.jpg").touch()
    for path in tmp_path.iterdir():
        with pytest.raises(RecordingError, match=f"{path.name} is no readable photograph"):
            photographed_texture(path)


def test_photographed_worlds_show_a_cable():
    needs_photographs()
    item = frames_of("report_inspection", 0, 1)[0]
    assert item.visibility > 0.5


def test_an_unknown_world_is_refused():
    with pytest.raises(ParameterError, match="tune_faint"):
        simulate_world("nowhere")


PLAIN = World(
    "plain",
    "no noise, even light",
    Split.TUNE,
    contrast=(6.0, 6.0),
    widths=(40.0, 60.0),
    optics=Optics(
        lamps=(0.0, 0.0), vignette=(0.0, 0.0), haze=(0.0, 0.0), blur=(0.3, 0.3), noise=(0.0, 0.0)
    ),
)


@pytest.mark.parametrize("seed", range(6))
def test_the_cable_is_where_the_truth_says(seed):
    item = frames_of(PLAIN, seed, 1)[0]
    truth, image = item.frame.truth, decode_grey(item.frame.image).astype(float)
    height, width = image.shape
    rows, columns = np.mgrid[:height, :width]
    x, y = columns - (width - 1) / 2, (height - 1) / 2 - rows
    across = x * np.cos(truth.angle) + y * np.sin(truth.angle) - truth.distance
    along = y * np.cos(truth.angle) - x * np.sin(truth.angle)
    half = truth.width / 2 - along * np.tan(truth.skew)
    inside = np.abs(across) < half - 2
    beside = (np.abs(across) > half + 2) & (np.abs(across) < half + 12)
    step = abs(image[inside].mean() - image[beside].mean())
    assert step > 2 * image[beside].std()
    # Just inside the borders it is still the cable, just outside no longer.
    rim = np.abs(np.abs(across) - half)
    inner = image[inside & (rim < 4)].mean()
    outer = image[beside & (rim < 4)].mean()
    assert abs(inner - outer) > 0.6 * step


def test_lengths_scale_with_the_size_of_the_frames():
    small = next(simulate_world(PLAIN, 1, (320, 240))).frame.truth
    large = next(simulate_world(PLAIN, 1, (640, 480))).frame.truth
    assert large.width == pytest.approx(2 * small.width)
    assert large.distance == pytest.approx(2 * small.distance)
    assert large.angle == pytest.approx(small.angle)


def test_bars_are_black_and_hide_the_cable():
    barred = replace(PLAIN, disturbance=Disturbance(bars=1.0), optics=Optics(noise=(3.0, 3.0)))
    for seed in range(4):
        item = frames_of(barred, seed, 1)[0]
        image = decode_grey(item.frame.image)
        edges = (image[:4], image[-4:], image[:, :4], image[:, -4:])
        assert sum(float(np.ptp(edge)) == 0.0 for edge in edges) >= 1


def test_a_cable_without_contrast_is_not_called_visible():
    item = frames_of(replace(PLAIN, contrast=(0.1, 0.1)), 0, 1)[0]
    assert np.isnan(item.visibility)
    assert item.frame.truth is not None
