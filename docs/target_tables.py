"""Put what `cable-tracker evaluate --targets` has found into docs/targets.md.

    cable-tracker evaluate --targets --first-seed 201 --seeds 5 --output build/targets
    python docs/target_tables.py build/targets

The block of the page between `<!-- targets -->` and `<!-- end of targets -->` is written anew.
"""

from __future__ import annotations

import sys
from pathlib import Path

from cable_tracker.marked_page import read_marked_page

PAGE = Path(__file__).with_name("targets.md")
BEGIN, END = "<!-- targets -->", "<!-- end of targets -->"


def main(folder: str) -> None:
    """Write the table of a folder, without its title, into the page."""
    table = (Path(folder) / "table.md").read_text(encoding="utf-8")
    _, _, body = table.partition("\n")
    read_marked_page(PAGE, BEGIN, END).write(PAGE, f"\n{body.strip()}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
