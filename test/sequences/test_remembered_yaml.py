from io import StringIO

from cable_tracker.sequences.remembered_yaml import LARGEST_REMEMBERED, RememberingParser


def test_a_text_is_parsed_once():
    parser = RememberingParser(typ="safe")
    first = parser.load("a: [1, 2]")
    assert first == {"a": [1, 2]}
    assert RememberingParser(typ="safe").load("a: [1, 2]") is first
    assert parser.load("a: [1, 3]") == {"a": [1, 3]}


def test_a_long_text_is_not_kept():
    parser = RememberingParser(typ="safe")
    text = "a: " + "b" * LARGEST_REMEMBERED
    assert parser.load(text) == parser.load(text)
    assert parser.load(text) is not parser.load(text)


def test_it_writes_as_well():
    stream = StringIO()
    RememberingParser(typ="safe").dump([{"a": 1}], stream)
    assert RememberingParser(typ="safe").load(stream.getvalue()) == [{"a": 1}]
