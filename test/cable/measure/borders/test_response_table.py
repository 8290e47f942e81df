from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measured_points import points, ratios_at

from cable_tracker.cable.measure.borders.response_table import (
    CLASSES,
    CONTRAST_BINS,
    CONTRAST_LIMIT,
    CONTRAST_SHAPE,
    EDGE_SHAPE,
    LARGEST_RATIO,
    RESPONSE_BINS,
    RESPONSE_LIMIT,
    ResponseTable,
    load_table,
    parse_table,
    point_cell,
)
from cable_tracker.errors import ParameterError

NUMBERS = st.floats(-1e6, 1e6, width=32)


def any_table(rng) -> ResponseTable:
    edges, contrasts = (
        rng.uniform(-3, 1, (CLASSES, *shape)).astype(np.float32)
        for shape in (EDGE_SHAPE, CONTRAST_SHAPE)
    )
    return ResponseTable(edges, contrasts, 'two "dives"')


@pytest.fixture
def content(tmp_path, rng) -> dict:
    path = tmp_path / "table.json"
    any_table(rng).save(path)
    return json.loads(path.read_text())


def test_a_table_that_is_saved_is_read_back(tmp_path, rng):
    table, path = any_table(rng), tmp_path / "table.json"
    table.save(path)
    again = load_table(str(path))
    assert again.source == table.source
    np.testing.assert_allclose(again.edges, table.edges, atol=6e-4)
    np.testing.assert_allclose(again.contrasts, table.contrasts, atol=6e-4)
    again.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == path.read_text()


def test_our_own_table_favours_sharp_edges_of_something_bright():
    table = load_table("")
    assert table is load_table("")
    strongest = CLASSES - 1
    looked_at = points([8.0, 0.0, 8.0, 8.0], [0.0, 0.0, 0.7, 0.0], [8.0, 0.0, 8.0, -8.0])
    clear, nothing, beside, furrow = ratios_at(looked_at, table)[:, strongest]
    assert clear > 0.5
    assert clear > beside
    assert clear > furrow
    assert nothing < 0.0
    both = ratios_at(points(0.0), table).reshape(2, CLASSES)
    np.testing.assert_allclose(table.absent, both.mean(axis=0), rtol=1e-6)
    assert (table.absent < 0.0).all()


def test_the_fainter_the_class_the_less_a_faint_edge_speaks_against_a_border():
    table = load_table("")
    nothing, faint = ratios_at(points([0.0, 2.0], 0.0, [0.0, 2.0]), table)[:, :CLASSES]
    assert faint[0] > 0.0
    assert nothing[0] > nothing[-1]


@given(st.integers(0, 2**32 - 1))
def test_the_ratio_of_a_point_is_bounded(seed):
    rng = np.random.default_rng(seed)
    measured = points(rng.normal(0, 8, 50), rng.normal(0, 0.5, 50), rng.normal(0, 8, 50))
    assert ratios_at(measured, load_table("")).max() <= LARGEST_RATIO


def test_cells_of_known_points(rng):
    table = any_table(rng)
    found = ratios_at(points([-12.0, 11.99, 0.1], [0.0, 9.0, 0.06], [-99.0, 99.0, 0.1]), table)
    cells = [((0, 0), (0, 0)), ((95, 14), (23, 24)), ((48, 1), (12, 12))]
    for strength in range(CLASSES):
        bright = [
            table.edges[strength][edge] + table.contrasts[strength][contrast]
            for edge, contrast in cells
        ]
        np.testing.assert_allclose(found[:, strength], bright)
    cells = [((95, 0), (23, 24)), ((0, 14), (0, 0)), ((47, 1), (11, 12))]
    for strength in range(CLASSES):
        dark = [
            table.edges[strength][edge] + table.contrasts[strength][contrast]
            for edge, contrast in cells
        ]
        np.testing.assert_allclose(found[:, CLASSES + strength], dark)


def inside_bins(rng, limit, bins) -> np.ndarray:
    """Draw measures, some beyond the limits; on the edge of a bin rounding would decide."""
    numbers = rng.integers(-5, bins + 5, 50) + rng.uniform(0.01, 0.99, 50)
    return numbers * 2 * limit / bins - limit


@given(st.integers(0, 2**32 - 1))
def test_a_dark_border_is_a_bright_one_in_the_negative(seed):
    rng = np.random.default_rng(seed)
    table = any_table(rng)
    responses = inside_bins(rng, RESPONSE_LIMIT, RESPONSE_BINS)
    contrasts = inside_bins(rng, CONTRAST_LIMIT, CONTRAST_BINS)
    measured = points(responses, rng.normal(0, 0.5, 50), contrasts)
    picture, negative = ratios_at(measured, table), ratios_at(measured.negative(), table)
    np.testing.assert_array_equal(picture, np.roll(negative, CLASSES, axis=1))


def broken(change):
    def apply(content: dict) -> str:
        change(content)
        return json.dumps(content)

    return apply


BROKEN = {
    "empty": lambda _: "",
    "no JSON": lambda _: "{",
    "a list": lambda _: "[1, 2]",
    "a number": lambda _: "3",
    "nothing": lambda _: "null",
    "too deep": lambda _: "[" * 100_000,
    "no source": broken(lambda content: content.pop("source")),
    "no table": broken(lambda content: content.pop("edges")),
    "no limit": broken(lambda content: content.pop("slope_limit")),
    "another limit": broken(lambda content: content.update(slope_limit=1.0)),
    "a limit that is NaN": broken(lambda content: content.update(slope_limit=float("nan"))),
    "a limit in words": broken(lambda content: content.update(slope_limit="wide")),
    "a row less": broken(lambda content: content["edges"].pop()),
    "a ragged row": broken(lambda content: content["edges"][0][3].pop()),
    "words": broken(lambda content: content["contrasts"][0][0].__setitem__(0, "high")),
    "objects": broken(lambda content: content["contrasts"][0][0].__setitem__(0, {})),
    "null": broken(lambda content: content["contrasts"][0][0].__setitem__(0, None)),
    "NaN": broken(lambda content: content["contrasts"][0][0].__setitem__(0, float("nan"))),
    "infinite": broken(lambda content: content["edges"][0][0].__setitem__(0, float("inf"))),
    "too large": broken(lambda content: content["edges"][0][0].__setitem__(0, 6.1)),
    "beyond float32": broken(lambda content: content["edges"][0][0].__setitem__(0, 1e300)),
    "beyond any float": broken(lambda content: content["edges"][0][0].__setitem__(0, 10**400)),
    "a scalar": broken(lambda content: content.update(edges=1.0)),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_table_is_refused_in_one_line_with_its_path_and_a_remedy(content, kind):
    with pytest.raises(ParameterError, match=r"response_table: my\.json") as caught:
        parse_table(BROKEN[kind](content), "my.json")
    message = str(caught.value)
    assert "\n" not in message
    assert "learn" in message or "not finite or beyond" in message


@pytest.mark.parametrize("path", ["none.json", ".", "bad.json", "\0", "~nobody-at-all/x.json"])
def test_an_unreadable_file_is_refused_with_its_path(tmp_path, monkeypatch, path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.json").write_bytes(b"\xff\xfe\x80")
    with pytest.raises(ParameterError, match=r"response_table: .*cannot be read") as caught:
        load_table(path)
    assert path in str(caught.value)


@given(NUMBERS, NUMBERS, NUMBERS)
def test_every_point_has_a_cell(response, slope, contrast):
    measured = points(response, slope, contrast)
    (edge,), (contrast_cell,) = measured.cells()
    assert 0 <= edge < np.prod(EDGE_SHAPE)
    assert 0 <= contrast_cell < np.prod(CONTRAST_SHAPE)
    row = point_cell(np.float32(response), np.float32(abs(slope)), np.float32(contrast))
    assert divmod(int(row), CONTRAST_BINS) == (edge, contrast_cell % CONTRAST_BINS)
