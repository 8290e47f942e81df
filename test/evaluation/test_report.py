import base64
import csv
import io
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from cable_tracker.evaluation.report import (
    CSV_FILES,
    REPORT,
    ReportHeader,
    frames_csv,
    make_cell,
    render_report,
    runs_csv,
    seeds_text,
    summary_csv,
    summary_table,
    write_report,
)
from cable_tracker.evaluation.run_metrics import METRIC_TABLE
from cable_tracker.evaluation.runs import chosen, methods_of, sequences_of
from cable_tracker.evaluation.sample_statistics import spread_of

HEADER = ReportHeader("Title <1>", "cable-tracker evaluate --x '<y>'", "a machine", "2026-01-02")
VOID = {"meta", "img", "br", "link", "input", "hr"}
REFERENCES = {"src", "href", "srcset", "data", "poster", "action", "background"}


class Reader(HTMLParser):
    """Checks nesting, and collects references and texts."""

    def __init__(self):
        super().__init__()
        self.open, self.references, self.texts, self.ids, self.tags = [], [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.references += [value for name, value in attrs if name in REFERENCES]
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture(scope="module")
def html(results):
    return render_report(
        results, HEADER, methods={"default": "the <filter>"}, sequences={"stripe": "a & b"}
    )


@pytest.fixture(scope="module")
def page(html):
    reader = Reader()
    reader.feed(html)
    reader.close()
    return reader


def test_the_report_is_well_formed(page):
    assert page.open == []
    assert page.tags.count("html") == page.tags.count("body") == 1


def test_the_report_loads_nothing_from_elsewhere(html, page):
    assert page.references
    assert all(ref.startswith(("data:", "#")) for ref in page.references)
    assert not re.search(r"https?://|url\(|@import|<script|<link", html)


def test_links_lead_to_places_that_exist(page):
    targets = [ref[1:] for ref in page.references if ref.startswith("#")]
    assert set(targets) <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))


def test_pictures_inside_load_nothing_either(page):
    pictures = [ref for ref in page.references if ref.startswith("data:image/svg")]
    assert len(pictures) == 1 + 2 * (1 + 2)
    for picture in pictures:
        svg = base64.b64decode(picture.partition(",")[2]).decode()
        references = re.findall(r'(?:href|src)="([^"]*)"', svg)
        assert all(ref.startswith(("#", "data:")) for ref in references)


def test_names_and_descriptions_are_escaped(page):
    text = "".join(page.texts)
    for words in (HEADER.title, HEADER.command, "the <filter>", "a & b", "<other> & more"):
        assert words in text


def test_all_numbers_can_be_taken_out_of_the_report(page, results):
    (table,) = (ref for ref in page.references if ref.startswith("data:text/csv"))
    assert base64.b64decode(table.partition(",")[2]).decode().count("\n") == len(results) + 1


def test_columns_of_which_nothing_is_known_are_left_out(results):
    labels = [label for label, _ in summary_table(results).headings]
    assert "false tracking" not in labels
    assert "right start" in labels


def test_the_report_says_which_seeds(page):
    assert "seeds 0 to 1." in "".join(page.texts)


@pytest.mark.parametrize(
    ("seeds", "text"),
    [((7,), "seed 7"), ((5, 4, 5, 6), "seeds 4 to 6"), ((1, 3), "seeds 1, 3")],
)
def test_seeds_are_named_in_a_few_words(seeds, text):
    assert seeds_text(seeds) == text


def test_the_folder_holds_report_and_tables(results, tmp_path):
    write_report(tmp_path, results, HEADER, methods={}, sequences={})
    assert {path.name for path in tmp_path.iterdir()} == {REPORT, *(name for name, _ in CSV_FILES)}


def test_a_cell_shows_mean_and_range():
    cell = make_cell(spread_of([10.0, 30.0]), "%")
    assert (cell.text, cell.detail, cell.shade) == ("20.0", "10.0 – 30.0", 0.2)


def test_a_cell_of_one_run_shows_no_range():
    assert make_cell(spread_of([10.0]), "px").detail == ""


def test_letters_of_names_that_are_not_utf_8_are_replaced(results, tmp_path):
    named = [replace(result, sequence="Tauchg\udce4nge") for result in results[:1]]
    write_report(tmp_path, named, HEADER, methods={}, sequences={})
    for name in (REPORT, *(name for name, _ in CSV_FILES)):
        assert "Tauchg?nge" in (tmp_path / name).read_text(encoding="utf-8")


def test_the_report_says_which_frames_were_refused(results):
    refusing = replace(results[0], refused=2, refusal="frame 3: too <dark>")
    page = render_report([refusing], HEADER, methods={}, sequences={})
    assert "2 frames were refused and taken as not claimed (frame 3: too &lt;dark&gt;)" in page


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_runs_are_chosen_by_sequence_and_method(results):
    assert sequences_of(results) == ["stripe", "<other> & more"]
    assert methods_of(results) == ["default", "thesis"]
    assert len(chosen(results)) == 8
    assert len(chosen(results, sequence="stripe")) == 4
    assert len(chosen(results, sequence="stripe", method="thesis")) == 2


def test_there_is_one_row_for_each_run(results):
    table = rows(runs_csv(results))
    assert len(table) == len(results)
    assert float(table[0]["lost [%]"]) == pytest.approx(results[0].metrics["lost"], 1e-5)
    assert table[0]["false_tracking [%]"] == ""


def test_the_summary_has_every_number_of_every_method_and_sequence(results):
    table = rows(summary_csv(results))
    assert len(table) == 2 * 2 * len(METRIC_TABLE)
    frames = next(row for row in table if row["metric"] == "frames")
    assert (frames["runs"], frames["mean"], frames["standard_error"]) == ("2", "12", "0")


def test_there_is_one_row_for_each_frame(results):
    table = rows(frames_csv(results))
    assert len(table) == 8 * 12
    assert table[0]["stamp [s]"] == "1.000000000"
    assert float(table[0]["true_w [px]"]) == 40.0
    assert table[0]["lost"] in ("0", "1")


def test_no_table_holds_nan(results):
    assert not any("nan" in make(results) for _, make in CSV_FILES)
