"""Boxes around the target, frame by frame: a text file beside pictures, or a topic of a bag.

One line per frame, ``frame x0 y0 x1 y1``, px from the top left corner, or ``frame none`` where the
target is out of view. The frame is the name of a picture, or a number from 0. A word between name
and numbers is passed over. Lines that begin with ``#`` are comments.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import RecordingError, one_line, read_failure
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag import BagSource
from cable_tracker.sequences.bags.bag_storage import BagStorage
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import deserialise
from cable_tracker.sequences.bags.storage_files import is_ros1
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.headers import stamp_or_received
from cable_tracker.sequences.messages.target import read_polygon
from cable_tracker.sequences.pictures.image_folder import ImageFolderSource
from cable_tracker.sequences.source import is_bag
from cable_tracker.sequences.source_base import Source
from cable_tracker.target.model.estimate import Box

BOXES_NAME = "boxes.txt"
"""Beside the pictures of a folder it is read without being asked for."""

OUT_OF_VIEW = "none"

FORM = "frame x0 y0 x1 y1, in px from the top left corner, or: frame none"

_HEADER = f"# {FORM}\n"


@dataclass(frozen=True, slots=True)
class BoxTruth:
    """True bounding box of the target in labelled frames; None where it is out of view.

    Attributes
    ----------
    by_index : mapping of int to Box or None
        By the number of the frame.
    by_stamp : mapping of int to Box or None
        By its time [ns].
    """

    by_index: Mapping[int, Box | None] = field(default_factory=dict)
    by_stamp: Mapping[int, Box | None] = field(default_factory=dict)

    def knows(self, frame: Frame) -> bool:
        """Tell whether a frame is labelled."""
        return frame.index in self.by_index or frame.stamp in self.by_stamp

    def box(self, frame: Frame) -> Box | None:
        """Return the box of a frame; None where the target is out of view, or nothing is known."""
        return self.by_index.get(frame.index, self.by_stamp.get(frame.stamp))


def read_boxes(path: Path) -> dict[str, Box | None]:
    """Read a text file with boxes, by the names of the frames.

    Raises
    ------
    RecordingError
        It is missing or no text, holds no label, labels a frame twice, or a line is malformed.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path}: is no text; expected lines of the form: {FORM}") from error
    except OSError as error:
        raise read_failure(path, error) from error
    boxes: dict[str, Box | None] = {}
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            name, box = _parse(line.strip())
        except ValueError as error:
            raise RecordingError(
                f"{path}: line {number} is malformed ({one_line(error)}); expected: {FORM}"
            ) from error
        if name in boxes:
            raise RecordingError(f"{path}: line {number} labels {name} again; remove one of them")
        boxes[name] = box
    if not boxes:
        raise RecordingError(f"{path}: holds no labels; expected: {FORM}")
    return boxes


def _parse(line: str) -> tuple[str, Box | None]:
    name, *last = line.rsplit(None, 1)
    if last == [OUT_OF_VIEW]:
        return name, None
    name, *sides = line.rsplit(None, 4)
    if len(sides) != 4:
        raise ValueError(f"{1 + len(sides)} words")
    left, top, right, bottom = map(float, sides)
    if not all(math.isfinite(side) for side in (left, top, right, bottom)):
        raise ValueError("a number is not finite")
    if right <= left or bottom <= top:
        raise ValueError("the box has no area")
    return name, (left, top, right, bottom)


def format_boxes(boxes: Iterable[tuple[str, Box | None]]) -> str:
    """Return the text of a file with boxes; numbers read back are equal to the last bit."""
    lines = [
        f"{name} {OUT_OF_VIEW if box is None else ' '.join(repr(float(side)) for side in box)}\n"
        for name, box in boxes
    ]
    return _HEADER + "".join(lines)


def find_boxes(source: Source, truth: Path | None = None) -> BoxTruth:
    """Return the boxes of a recording.

    Parameters
    ----------
    truth : Path or None
        Text file or bag with the labels; None: what the recording itself holds.

    Raises
    ------
    RecordingError
        There are none, they cannot be read, or belong to no frame of the recording.
    """
    if truth is None:
        truth = _place_of_own_boxes(source)
    if is_bag(truth):
        if not isinstance(source, BagSource):
            raise RecordingError(
                f"{truth}: labels by time, which {source.path} has not; give a text file"
            )
        if truth == source.path:
            return BoxTruth(by_stamp=_read_bag(source.storage, truth))
        with closing(open_bag(truth)) as storage:
            boxes = _read_bag(storage, truth)
        if not source.has_frame_at(boxes):
            raise RecordingError(
                f"{truth}: not one of its {len(boxes)} boxes has the time of a frame of"
                f" {source.path}; give the boxes that belong to this recording"
            )
        return BoxTruth(by_stamp=boxes)
    if truth == source.path:
        raise RecordingError(
            f"{source.path}: has no boxes to judge by; give them with --truth FILE, lines of the"
            f" form: {FORM}"
        )
    return BoxTruth(by_index=_numbered(source, read_boxes(truth), truth))


def _place_of_own_boxes(source: Source) -> Path:
    """Return where a recording's own boxes are, if it has any: beside its pictures, or in it."""
    beside = source.path / BOXES_NAME
    return beside if beside.is_file() else source.path


def own_boxes(source: Source) -> BoxTruth:
    """Return the boxes that a recording holds itself, perhaps none.

    Raises
    ------
    RecordingError
        They cannot be read.
    """
    path = _place_of_own_boxes(source)
    if path != source.path:
        return find_boxes(source, path)
    if isinstance(source, BagSource) and _box_topic(source.storage):
        return find_boxes(source)
    return BoxTruth()


def _numbered(
    source: Source, boxes: Mapping[str, Box | None], truth: Path
) -> dict[int, Box | None]:
    """Return boxes by the numbers of the frames; one frame may have several names."""
    numbers: dict[str, int] = {}
    if isinstance(source, ImageFolderSource):
        numbers = {picture.name: index for index, picture in enumerate(source.pictures)}
    found: dict[int, Box | None] = {}
    for name, box in boxes.items():
        number = numbers.get(name)
        # A file may say after the frame which target it is.
        word = name.split()[0]
        if number is None and word.isascii() and word.isdecimal():
            number = int(word)
        count = source.frame_count
        if number is None or (count is not None and number >= count):
            raise RecordingError(
                f"{truth}: labels {name}, which is no frame of {source.path}; remove the line"
            )
        if number in found:
            raise RecordingError(
                f"{truth}: labels frame {number} again, as {name}; remove one of the lines"
            )
        found[number] = box
    return found


def _box_topic(storage: BagStorage) -> str:
    """Return the first topic of boxes; empty if there is none."""
    wanted = node_topics.TRUE_BOX
    topics = [
        name
        for name, topic in sorted(storage.topics.items())
        if topic.msgtype == wanted.type_name and name.endswith(wanted.global_name)
    ]
    return topics[0] if topics else ""


def _read_bag(storage: BagStorage, path: Path) -> dict[int, Box | None]:
    """Read the boxes of a bag by stamp [ns]."""
    wanted, topic = node_topics.TRUE_BOX, _box_topic(storage)
    if not topic:
        raise RecordingError(
            f"{path}: the bag holds no {wanted.name} ({wanted.type_name}); give boxes with --truth"
        )
    boxes: dict[int, Box | None] = {}
    try:
        with closing(storage.messages([topic])) as messages:
            for stored in messages:
                message = deserialise(stored, is_ros1=is_ros1(path))
                boxes[stamp_or_received(message, stored.time)] = _around(read_polygon(message))
    except RecordingError as error:
        raise RecordingError(
            f"{path}: {topic} is damaged after {len(boxes)} boxes ({error}); copy it again"
        ) from error
    # Deserialising foreign bytes raises what the parser happens to raise.
    except Exception as error:
        raise RecordingError(
            f"{path}: the boxes on {topic} cannot be read ({one_line(error)}); record them again"
        ) from error
    return boxes


def _around(corners: FloatArray) -> Box | None:
    """Return the box around corners (N, 2); None: there are none, or they are not finite."""
    if len(corners) < 2 or not np.isfinite(corners).all():
        return None
    (left, top), (right, bottom) = corners.min(axis=0), corners.max(axis=0)
    return (float(left), float(top), float(right), float(bottom))
