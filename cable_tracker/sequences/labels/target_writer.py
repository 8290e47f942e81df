"""Write pictures and the boxes around a target in them: into a bag, or beside the pictures."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Literal

import numpy as np

from cable_tracker.atomic_output import output_folder
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.convert import write_frame
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import BOXES_NAME, format_boxes
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.target import make_polygon
from cable_tracker.sequences.pictures.image_writer import picture_name, write_picture
from cable_tracker.target.model.estimate import Box, box_corners

LabelledFrame = tuple[Frame, Box | None]
"""A frame, and where the target is in it; None where it is out of view."""


def write_target_bag(
    path: Path,
    frames: Iterable[LabelledFrame],
    *,
    storage: Literal["sqlite3", "mcap"] = "mcap",
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
    factory, topic = RosbagsMessages(), node_topics.TRUE_BOX
    with BagWriter(path, storage, overwrite=overwrite) as bag:
        for frame, box in frames:
            write_frame(bag, frame)
            header = make_header(factory, frame.stamp, frame.frame_id)
            corners = np.empty((0, 2)) if box is None else box_corners(box)
            polygon = make_polygon(factory, header, corners)
            bag.write(topic.global_name, topic.type_name, polygon, frame.bag_time)
            count += 1
    return count


def write_target_pictures(
    folder: Path, frames: Iterable[LabelledFrame], *, overwrite: bool = False
) -> int:
    """Write each frame as a PNG, and `boxes.txt` beside them; return the number of frames.

    Raises
    ------
    OutputError
        The folder exists, or the disk does not let us write.
    """
    boxes = []
    with output_folder(folder, BOXES_NAME, overwrite=overwrite) as content:
        for frame, box in frames:
            name = picture_name(frame.index)
            write_picture(content / name, frame.image)
            boxes.append((name, box))
        (content / BOXES_NAME).write_text(format_boxes(boxes), encoding="utf-8")
    return len(boxes)
