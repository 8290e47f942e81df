"""Put what `cable-tracker evaluate --targets` has found into docs/targets.md.

    cable-tracker evaluate --targets --first-seed 201 --seeds 5 --output build/targets
    python docs/target_tables.py build/targets

The block of the page between `<!-- targets -->` and `<!-- end of targets -->` is written anew.
"""

from __future__ import annotations

import sys
from pathlib import Path

PAGE = Path(__file__).with_name("targets.md")
BEGIN, END = "<!-- targets -->", "<!-- end of targets -->"


def written(page: str, table: str) -> str:
    """Return the page with a table, without its title, in its block."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    _, _, body = table.partition("\n")
    return f"{before}{BEGIN}\n{body.strip()}\n{END}{after}"


def main(folder: str) -> None:
    """Write the table of a folder into the page."""
    table = (Path(folder) / "table.md").read_text(encoding="utf-8")
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), table), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
