"""Metadata of bags are parsed once, not at each of the several times that a bag is opened.

rosbags parses `metadata.yaml`, and the quality of service of each topic in it, whenever a bag is
opened, with a parser in Python: a tenth of a second each time. What a text says does not change.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

from rosbags.rosbag2 import metadata as rosbags_metadata
from rosbags.rosbag2 import reader as rosbags_reader

LARGEST_REMEMBERED = 1 << 18
"""Texts of more characters are parsed each time, so that little memory is kept."""

MOST_REMEMBERED = 64

_PARSER = "YAML"
"""What the modules of rosbags call it."""

_parser_of_rosbags: Any = getattr(rosbags_reader, _PARSER, None)


@lru_cache(maxsize=MOST_REMEMBERED)
def _parsed(text: str) -> Any:  # noqa: ANN401  As the text says.
    return _parser_of_rosbags(typ="safe").load(text)


class RememberingParser:
    """Parses as rosbags does; for the same text it gives the same value, not to be changed."""

    def __init__(self, *, typ: str) -> None:
        self._typ = typ

    def load(self, text: str) -> Any:  # noqa: ANN401  As the text says.
        """Return what a text says."""
        if len(text) <= LARGEST_REMEMBERED:
            return _parsed(text)
        return _parser_of_rosbags(typ=self._typ).load(text)

    def dump(self, data: Any, stream: Any) -> None:  # noqa: ANN401  As rosbags has it.
        """Write a value as text."""
        _parser_of_rosbags(typ=self._typ).dump(data, stream)


@cache
def remember_metadata() -> None:
    """Let rosbags parse the same metadata only once, for all readers of the process."""
    if _parser_of_rosbags is None:
        return  # A rosbags that parses in another way by now.
    for module in (rosbags_metadata, rosbags_reader):
        if getattr(module, _PARSER, None) is _parser_of_rosbags:
            setattr(module, _PARSER, RememberingParser)
