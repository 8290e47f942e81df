"""Follow a target through a whole recording."""

from __future__ import annotations

import time

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError, ParameterError
from cable_tracker.metric.frames import mounting_of
from cable_tracker.metric.messages import relative_messages, target_facts
from cable_tracker.metric.recorded_instruments import RecordedInstruments
from cable_tracker.metric.targets.target_instrument_fusion import TargetInstrumentFusion
from cable_tracker.metric.targets.target_metres import TargetMetres
from cable_tracker.offline.target_folder import TargetFolder
from cable_tracker.offline.target_table import (
    TargetRow,
    metres_row,
    refused_metres_row,
    row_of,
)
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.frame_messages import FrameMessages
from cable_tracker.sequences.encodings import decode_bgr_levels
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.target import (
    messages_without_target,
    target_messages,
)
from cable_tracker.sequences.pictures.shown_levels import shown_levels
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.target.model.start import DETECT, TargetStart, parse_box
from cable_tracker.target.tracker import TargetTracker
from cable_tracker.tracking.status import REFUSED
from cable_tracker.visualisation.target_overlay import draw_target


def parse_start(init: str) -> TargetStart | None:
    """Parse a start: the box `x0,y0,x1,y1` [px], or None for `detect`.

    Raises
    ------
    ParameterError
        It is neither, or the box has no area.
    """
    if init == DETECT:
        return None
    try:
        return parse_box(init)
    except ParameterError as error:
        raise ParameterError(f"{error}; give {DETECT} or a box") from error


def follow_picture(
    frame: Frame,
    image: Image,
    tracker: TargetTracker,
    instruments: RecordedInstruments[TargetInstrumentFusion] | None,
) -> tuple[TargetEstimate, float, TargetMetres | None]:
    """Track a target in a picture, shape (H, W, 3), with the instruments' readings up to its frame.

    Return the estimate, its processing time [ms], and the target in metres, None without
    instruments.

    Raises
    ------
    FrameError
        The frame cannot be used.
    """
    if instruments is not None:
        instruments.advance(frame)
    begin = time.perf_counter()
    height, width = image.shape[:2]
    fusion = instruments.fusion if instruments is not None else None
    motion = fusion.camera_motion(frame.stamp, (width, height)) if fusion is not None else None
    estimate = tracker.process(image, frame.stamp, motion)
    ms = (time.perf_counter() - begin) * 1e3
    return estimate, ms, fusion.take([estimate])[0] if fusion is not None else None


def follow_frame(
    frame: Frame,
    tracker: TargetTracker,
    results: TargetFolder,
    instruments: RecordedInstruments[TargetInstrumentFusion] | None,
) -> None:
    """Track a target in a frame, and add it to the results; in pixels without instruments."""
    output = FrameMessages(results.bag, frame)
    try:
        image = decode_bgr_levels(frame.image)
        estimate, ms, metres = follow_picture(frame, image, tracker, instruments)
    except FrameError as error:
        output.write_all(
            messages_without_target(output.factory, output.header, REFUSED, str(error))
        )
        if instruments is not None:
            results.metres.append(refused_metres_row(frame, str(error)))
        results.add(frame, TargetRow(frame.index, frame.stamp, REFUSED, event=str(error)), None)
        return
    factory, header, particles = output.factory, output.header, tracker.particles
    poses = particles.states if particles is not None else None
    picture = draw_target(shown_levels(image), estimate, poses)
    facts: dict[str, str] = {}
    if instruments is not None and metres is not None:
        parameters = instruments.fusion.parameters
        camera_position = mounting_of(parameters).position
        facts = target_facts(metres, camera_position)
        results.metres.append(metres_row(frame, facts))
        output.write_all(
            relative_messages(factory, header, parameters.base_frame, metres, camera_position)
        )
    output.write_all(
        target_messages(factory, header, estimate, particles, ms=ms, metres=lambda: facts)
    )
    output.write_overlay(node_topics.TARGET_OVERLAY, lambda: picture)
    results.add(frame, row_of(frame, estimate, ms), picture)
