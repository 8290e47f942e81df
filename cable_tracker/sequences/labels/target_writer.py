"""Write pictures and the boxes around a target in them: into a bag, or beside the pictures."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from cable_tracker.atomic_output import output_folder
from cable_tracker.sequences.bags.bag_writer import BagWriter, StorageFormat
from cable_tracker.sequences.bags.frame_messages import write_box, write_frame
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import BOXES_NAME, format_boxes
from cable_tracker.sequences.pictures.image_writer import (
    picture_name,
    pictures_beside,
    write_picture,
)
from cable_tracker.target.model.estimate import Box

LabelledFrame = tuple[Frame, Box | None]
"""A frame, and where the target is in it; None where it is out of view."""


def write_target_bag(
    path: Path,
    frames: Iterable[LabelledFrame],
    *,
    storage: StorageFormat = StorageFormat.MCAP,
    overwrite: bool = False,
) -> int:
    """Write a bag with the topics `image` and `ground_truth/box`; return the number of frames.

    The box is a polygon of four corners; it has none where the target is out of view.

    Raises
    ------
    OutputError
        The bag cannot be written.
    """
    count = 0
    with BagWriter(path, storage, overwrite=overwrite) as bag:
        for frame, box in frames:
            write_frame(bag, frame)
            write_box(bag, frame, box)
            count += 1
    return count


def write_target_pictures(
    folder: Path, frames: Iterable[LabelledFrame], *, overwrite: bool = False
) -> int:
    """Write each frame as a PNG, and `boxes.txt` beside them; return the number of frames.

    Raises
    ------
    OutputError
        The folder exists, or holds other files, or the disk does not let us write.
    """
    boxes = []
    with output_folder(
        folder, BOXES_NAME, overwrite=overwrite, is_own_name=pictures_beside(BOXES_NAME)
    ) as content:
        for frame, box in frames:
            name = picture_name(frame.index)
            write_picture(content / name, frame.image)
            boxes.append((name, box))
        (content / BOXES_NAME).write_text(format_boxes(boxes), encoding="utf-8")
    return len(boxes)
