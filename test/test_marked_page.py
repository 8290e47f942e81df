from __future__ import annotations

import pytest

from cable_tracker.errors import OutputError
from cable_tracker.marked_page import read_marked_page


@pytest.fixture
def page(tmp_path):
    path = tmp_path / "page.md"
    path.write_text("above\n<!-- a -->\nold\n<!-- z -->\nbelow ü\n", encoding="utf-8")
    return path


def test_a_page_is_divided_at_its_marks(page):
    parts = read_marked_page(page, "<!-- a -->", "<!-- z -->")
    assert parts == ("above\n<!-- a -->", "\nold\n", "<!-- z -->\nbelow ü\n")


@pytest.mark.parametrize("content", ["\nnew\n", "\n"])
def test_only_the_text_between_the_marks_is_replaced(page, content):
    read_marked_page(page, "<!-- a -->", "<!-- z -->").write(page, content)
    expected = f"above\n<!-- a -->{content}<!-- z -->\nbelow ü\n"
    assert page.read_text(encoding="utf-8") == expected


@pytest.mark.parametrize("marks", [("<!-- z -->", "<!-- a -->"), ("<!-- a -->", "<!-- b -->")])
def test_a_page_without_the_marks_is_refused_with_what_to_add(page, marks):
    with pytest.raises(OutputError, match=f"add the lines {marks[0]} and {marks[1]}"):
        read_marked_page(page, *marks)


@pytest.mark.parametrize("content", [None, b"\xff\xfe\xff"], ids=["missing", "no text"])
def test_a_page_that_cannot_be_read_is_refused(tmp_path, content):
    path = tmp_path / "page.md"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(OutputError, match=r"page\.md: cannot be read as a page"):
        read_marked_page(path, "a", "z")
