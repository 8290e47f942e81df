"""The page of promises names tests that exist."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")


def named_tests():
    """Yield file and name of each test; a name alone belongs to the file before it in its row."""
    for line in PAGE.splitlines():
        if not line.startswith("|"):
            continue
        file = ""
        for named, name in re.findall(r"`(test/[\w/]+\.py)?(?:::(\w+)[^`]*)?`", line):
            file = named or file
            if named or name:
                yield file, name


def test_every_named_test_exists():
    for file, name in sorted(set(named_tests())):
        text = (ROOT / file).read_text(encoding="utf-8")
        found = re.search(rf"^\s*(?:async )?(?:def|class) {name}\b", text, re.MULTILINE)
        assert not name or found, (file, name)


def test_the_page_names_tests():
    assert len(set(named_tests())) > 40
