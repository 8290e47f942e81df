"""Evaluate the methods, and write the results into docs/evaluation.md.

    python docs/evaluation_tables.py --seeds 10                    # run, then write
    python docs/evaluation_tables.py --seeds 10 --keep             # take results that lie there
    python docs/evaluation_tables.py --method default --rows        # the rows of one method alone

Each block of the page between `<!-- NAME -->` and `<!-- end of NAME -->` is written anew: the
command, when and where it was run, and the tables. With `--rows` the rows of the chosen methods
take the place of those in the block, and the rest stays.
"""

from __future__ import annotations

import argparse
import csv
import datetime
import platform
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import cv2
import numpy as np

from cable_tracker.evaluation.result_table import ResultTable, table_markdown
from cable_tracker.marked_page import read_marked_page

PAGE = Path(__file__).with_name("evaluation.md")
METHODS = ("default", "thesis", "hough", "segmentation", "lsd", "texture")

Key: TypeAlias = tuple[str, str, str]
"""Sequence, method, metric."""


@dataclass(frozen=True)
class Measure:
    """A column of the summary, its title, and its number of decimals."""

    name: str
    title: str
    digits: int


USEFUL = Measure("useful", "Useful frames [%]", 1)
WRONG = Measure("wrong_claims", "Wrong claims, of all claims [%]", 1)
FALSE = Measure("false_tracking", "Claims without a cable [%]", 1)
FOUND = Measure("found_again", "Returns after which it is found again within 1 s [%]", 0)
MEDIAN_D = Measure("median_d", "Median error of d [px]", 2)
MEDIAN_ALPHA = Measure("median_alpha", "Median error of alpha [deg]", 2)
MEDIAN_W = Measure("median_w", "Median error of w [px]", 1)
INSIDE_D = Measure("inside_2_sigma_d", "Truths of d inside two sigma [%]", 0)


@dataclass(frozen=True)
class Block:
    """One block of the page: sequences, and the measures in its tables."""

    name: str
    arguments: tuple[str, ...]
    measures: tuple[Measure, ...]


def _scenarios(*names: str) -> tuple[str, ...]:
    return tuple(part for name in names for part in ("--scenario", name))


BLOCKS = (
    Block(
        "scenarios",
        _scenarios("S1", "S2", "S3", "S4", "S5", "S6"),
        (USEFUL, WRONG, MEDIAN_D, MEDIAN_W, INSIDE_D),
    ),
    Block(
        "further",
        _scenarios("leaves", "buried", "crossing", "no_cable", "decoys", "night"),
        (USEFUL, WRONG, FALSE, FOUND),
    ),
    Block("footage", (), (USEFUL, WRONG, MEDIAN_D, MEDIAN_ALPHA, MEDIAN_W)),
)


def main() -> None:
    """Run the chosen evaluations, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--frames", type=int, help="use only so many frames of each scenario")
    parser.add_argument("--method", action="append", choices=METHODS)
    parser.add_argument("--block", action="append", choices=[block.name for block in BLOCKS])
    parser.add_argument("--footage", type=Path, help="strip.mp4, with strip.txt beside it")
    parser.add_argument("--results", type=Path, default=Path("build/evaluation"))
    parser.add_argument("--keep", action="store_true", help="take results that lie there")
    parser.add_argument("--rows", action="store_true", help="leave the other methods' rows")
    chosen = parser.parse_args()
    for block in BLOCKS:
        if chosen.block and block.name not in chosen.block:
            continue
        source: list[str] = []
        if block.name == "footage":
            if chosen.footage is None:
                print("no --footage: its block stays as it is")
                continue
            source = ["--source", str(chosen.footage)]
            source += ["--truth", str(chosen.footage.with_suffix(".txt"))]
        arguments = [*block.arguments, "--seeds", str(chosen.seeds)]
        if chosen.frames and not source:
            arguments += ["--frames", str(chosen.frames)]
        for method in chosen.method or ():
            arguments += ["--method", method]
        folder = chosen.results / block.name
        if not chosen.keep:
            evaluate([*source, *arguments], folder)
        shown = ["--source strip.mp4 --truth strip.txt"] if source else []
        command = " ".join(["cable-tracker evaluate", *shown, *arguments])
        text = text_of(block, command, folder / "summary.csv")
        page = read_marked_page(PAGE, f"<!-- {block.name} -->", f"<!-- end of {block.name} -->")
        page.write(PAGE, with_rows(page.content, text) if chosen.rows else text)


def evaluate(arguments: Sequence[str], folder: Path) -> None:
    """Run `cable-tracker evaluate`."""
    command = [str(Path(sys.executable).with_name("cable-tracker")), "evaluate"]
    subprocess.run([*command, *arguments, "--output", str(folder), "--force"], check=True)


def with_rows(old: str, new: str) -> str:
    """Return an old text of a block, with rows replaced by those of a new one."""
    rows = {row: line for row, line in rows_and_lines(new) if row is not None}
    return "".join(f"{rows.get(row, line)}\n" for row, line in rows_and_lines(old))


def rows_and_lines(text: str) -> Iterator[tuple[tuple[str, str] | None, str]]:
    """Yield lines, each with its table's title and its method; None for a line of no method."""
    title = ""
    for line in text.splitlines():
        title = line if line.endswith(":") else title
        yield ((title, line.split("|")[1]) if line.startswith("| `") else None), line


def text_of(block: Block, command: str, summary: Path) -> str:
    """Return the text of a block: the command, the machine, and its tables."""
    rows = read_summary(summary)
    sequences = list(dict.fromkeys(sequence for sequence, _, _ in rows))
    methods = list(dict.fromkeys(method for _, method, _ in rows))
    libraries = f"NumPy {np.__version__}, OpenCV {cv2.__version__}"
    today = datetime.datetime.now(tz=datetime.UTC).date()
    parts = [
        f"```sh\n{command}\n```\n",
        f"{today}, Python {platform.python_version()}, {libraries}.\n",
    ]
    if len(sequences) == 1:
        columns = [(sequences[0], measure) for measure in block.measures]
        titles = [measure.title for measure in block.measures]
        parts.append(table_of(rows, methods, columns, titles))
    else:
        for measure in block.measures:
            columns = [(sequence, measure) for sequence in sequences]
            parts.append(f"{measure.title}:\n\n" + table_of(rows, methods, columns, sequences))
    return "\n\n" + "\n".join(parts) + "\n"


def table_of(
    rows: Mapping[Key, tuple[str, str]],
    methods: Sequence[str],
    columns: Sequence[tuple[str, Measure]],
    titles: Sequence[str],
) -> str:
    """Return a table with a row for each method; a column is of a sequence and a measure."""
    lines = tuple(
        (f"`{method}`", *(cell_text(rows[name, method, each.name], each) for name, each in columns))
        for method in methods
    )
    return table_markdown(ResultTable(("method", *titles), lines)) + "\n"


def read_summary(path: Path) -> dict[Key, tuple[str, str]]:
    """Return mean and standard error by sequence, method and metric."""
    with path.open(encoding="utf-8", newline="") as file:
        return {
            (row["sequence"], row["method"], row["metric"]): (row["mean"], row["standard_error"])
            for row in csv.DictReader(file)
        }


def cell_text(value: tuple[str, str], measure: Measure) -> str:
    """Return the text of a cell: mean and standard error."""
    mean, error = value
    if not mean or not np.isfinite(float(mean)):
        return "-"
    text = f"{float(mean):.{measure.digits}f}"
    return f"{text} ± {float(error):.{measure.digits}f}" if error else text


if __name__ == "__main__":
    main()
