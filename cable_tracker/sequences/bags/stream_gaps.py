"""Finds where packets of a video stream are missing.

A picture that was coded against one that never came looks like a picture: H.264's and VP9's
decoders fill in what they have, and say nothing. H.265's notices by itself, as each of its packets
names what it needs.
"""

from __future__ import annotations

import re
from collections import deque
from dataclasses import dataclass
from typing import Protocol

USUAL_STEPS, FEWEST_STEPS = 8, 3
"""Number of latest steps from packet to packet that say what is usual, and fewest for that."""

LONG_STEP = 1.6
"""A step so many times as long as the longest of the latest ones is a gap."""

_START = re.compile(rb"\x00\x00\x01")

_HEADER = 64
"""Bytes of a unit of H.264 that are looked at; a parameter set with its own scaling has more."""

_PARAMETER_SET, _IDR, _SLICES = 7, 5, (1, 2, 5)
"""Kinds of units of H.264: sequence parameter set, and slices of pictures."""

_HIGH_PROFILES = frozenset((44, 83, 86, 100, 110, 118, 122, 128, 134, 135, 138, 139, 244))


class Numbered(Protocol):
    """What is known of a packet from outside."""

    @property
    def stamp(self) -> int:
        """Stamp of the picture [ns]."""

    @property
    def count(self) -> int:
        """Number of the picture as its sender counts; 0 for all: it does not."""

    @property
    def data(self) -> bytes:
        """One access unit."""


class GapFinder(Protocol):
    """Looks at packet after packet, in the order in which they were recorded."""

    def is_after_gap(self, packet: Numbered) -> bool:
        """Tell whether others are missing before a packet."""


class NoGaps:
    """For decoders that notice by themselves."""

    def is_after_gap(self, packet: Numbered) -> bool:
        """Tell nothing."""
        return False


class TimeGaps:
    """For codings whose pictures have no number: by the sender's count, or else by the stamps.

    A camera that leaves out a picture before it is coded cannot be told from a lost packet by its
    stamps.
    """

    def __init__(self) -> None:
        self._latest: tuple[int, int] | None = None
        self._steps = deque[int](maxlen=USUAL_STEPS), deque[int](maxlen=USUAL_STEPS)

    def is_after_gap(self, packet: Numbered) -> bool:
        """Tell whether a step is out of the ordinary."""
        here, before = (packet.count, packet.stamp), self._latest
        self._latest = here
        if before is None:
            return False
        kind = 0 if here[0] != before[0] else 1
        steps, step = self._steps[kind], here[kind] - before[kind]
        if step <= 0:
            # A clock that jumps back tells nothing.
            return False
        gap = len(steps) >= FEWEST_STEPS and step > LONG_STEP * max(steps)
        steps.append(step)
        return gap


class H264Gaps:
    """By `frame_num`, which grows by one with each picture that others are coded against."""

    def __init__(self) -> None:
        self._set: _ParameterSet | None = None
        self._reference: int | None = None

    def is_after_gap(self, packet: Numbered) -> bool:
        """Tell whether a picture that others are coded against is missing."""
        for unit in _units(packet.data):
            kind = unit[0] & 31
            if kind == _PARAMETER_SET:
                self._set = _read_parameter_set(unit) or self._set
            elif kind in _SLICES:
                # All slices of a picture have the same number.
                return self._is_slice_after_gap(unit)
        return False

    def _is_slice_after_gap(self, unit: bytes) -> bool:
        own = self._set
        number = None if own is None else _frame_number(unit, own)
        if own is None or number is None:
            return False
        before = self._reference
        if unit[0] & 31 == _IDR or unit[0] & 96:
            self._reference = number
        if unit[0] & 31 == _IDR or before is None or own.may_skip:
            return False
        return number not in {before, (before + 1) % (1 << own.bits)}


@dataclass(frozen=True, slots=True)
class _ParameterSet:
    """What a sequence parameter set says of `frame_num`.

    Attributes
    ----------
    bits : int
        Its length.
    has_planes : bool
        Whether the number of a colour plane stands before it.
    may_skip : bool
        Whether numbers may be left out though nothing is missing.
    """

    bits: int
    has_planes: bool
    may_skip: bool


class _ShortError(Exception):
    """A unit ends before what is read of it."""


class _Bits:
    """Reads bits, without the bytes that keep start codes out of a unit."""

    def __init__(self, unit: bytes) -> None:
        plain = unit.replace(b"\x00\x00\x03", b"\x00\x00")
        self._text = "".join(f"{byte:08b}" for byte in plain)
        self._place = 0

    def number(self, count: int) -> int:
        end = self._place + count
        if end > len(self._text):
            raise _ShortError
        text, self._place = self._text[self._place : end], end
        return int(text or "0", 2)

    def flag(self) -> bool:
        return self.number(1) == 1

    def golomb(self) -> int:
        """Read a number in the code of Golomb, without a sign."""
        end = self._text.find("1", self._place)
        if end < 0:
            raise _ShortError
        zeros, self._place = end - self._place, end + 1
        return (1 << zeros) - 1 + self.number(zeros)

    def signed(self) -> int:
        value = self.golomb()
        return (value + 1) // 2 if value % 2 else -(value // 2)


def _units(data: bytes) -> list[bytes]:
    """Return the beginnings of the units of an access unit."""
    places = [found.end() for found in _START.finditer(data)]
    return [data[place : place + _HEADER] for place in places if place < len(data)]


def _read_parameter_set(unit: bytes) -> _ParameterSet | None:
    """Read a sequence parameter set (ITU-T H.264, 7.3.2.1.1); None where it cannot be."""
    bits = _Bits(unit[1:])
    try:
        profile = bits.number(8)
        bits.number(16)
        bits.golomb()
        has_planes = profile in _HIGH_PROFILES and _skip_colours(bits)
        length = bits.golomb() + 4
        _skip_order(bits)
        bits.golomb()
        return _ParameterSet(length, has_planes, bits.flag())
    except _ShortError:
        return None


def _skip_colours(bits: _Bits) -> bool:
    """Pass over how colours are coded; tell whether each plane is coded alone."""
    chroma = bits.golomb()
    has_planes = chroma == 3 and bits.flag()
    bits.golomb()
    bits.golomb()
    bits.flag()
    if bits.flag():
        for number in range(12 if chroma == 3 else 8):
            if bits.flag():
                _skip_scaling(bits, 16 if number < 6 else 64)
    return has_planes


def _skip_scaling(bits: _Bits, count: int) -> None:
    last = following = 8
    for _ in range(count):
        if following:
            following = (last + bits.signed()) % 256
        last = following or last


def _skip_order(bits: _Bits) -> None:
    """Pass over how the order of pictures is told."""
    kind = bits.golomb()
    if kind == 0:
        bits.golomb()
    elif kind == 1:
        bits.flag()
        bits.golomb()
        bits.golomb()
        for _ in range(min(bits.golomb(), 255)):
            bits.golomb()


def _frame_number(unit: bytes, own: _ParameterSet) -> int | None:
    """Read `frame_num` of a slice (7.3.3); None where it cannot be."""
    bits = _Bits(unit[1:])
    try:
        for _ in range(3):
            bits.golomb()
        if own.has_planes:
            bits.number(2)
        return bits.number(own.bits)
    except _ShortError:
        return None
