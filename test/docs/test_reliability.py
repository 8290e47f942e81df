"""The page of promises names tests that exist."""

import re
from pathlib import Path

import pytest

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


@pytest.mark.parametrize(("file", "name"), sorted(set(named_tests())))
def test_a_named_test_exists(file, name):
    text = (ROOT / file).read_text(encoding="utf-8")
    assert not name or re.search(rf"^\s*(?:async )?(?:def|class) {name}\b", text, re.MULTILINE)


def test_the_page_names_tests():
    assert len(set(named_tests())) > 40
