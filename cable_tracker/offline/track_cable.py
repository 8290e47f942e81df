"""Track a cable through a whole recording in this process, without ROS."""

from __future__ import annotations

import time

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.initial_state_text import parse_initial_state
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.baselines.detectors import DETECTORS
from cable_tracker.detection.line_pairs import PairLimits
from cable_tracker.errors import FrameError, ParameterError, RecordingError
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.messages import cable_facts, cross_track_messages, row_metres
from cable_tracker.metric.recorded_instruments import RecordedCableInstruments
from cable_tracker.metric.withheld import Withheld
from cable_tracker.offline.cable_folder import CableFolder
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.frame_messages import FrameMessages, write_truth
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.cable import cable_messages, cloud_of, messages_without_cable
from cable_tracker.sequences.source_base import Source
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.trackers import CableTracker
from cable_tracker.tracking.status import REFUSED
from cable_tracker.visualisation.overlay import draw_estimate

TRUTH = "truth"


def given_state_for(source: Source, init: str, limits: PairLimits) -> GivenState | None:
    """Return the start by `truth`, a detector's name, or `d,alpha,w,beta`; None by `random`.

    Parameters
    ----------
    limits : PairLimits
        Widths and skews of the cables that a detector reports.

    Raises
    ------
    ParameterError
        `init` is none of these, or the first frame has no ground truth, or shows no cable to
        the detector.
    RecordingError
        The recording cannot be read.
    """
    if init != TRUTH and init not in DETECTORS:
        try:
            state = parse_initial_state(init)
        except ParameterError as error:
            others = ", ".join((TRUTH, *DETECTORS))
            raise ParameterError(f"{error}; a recording also takes {others}") from error
        return GivenState.around(state) if state is not None else None
    first = next(source.frames(), None)
    if first is None:
        raise RecordingError(f"{source.path}: holds no frames; record it again")
    if init == TRUTH:
        return GivenState.around(_true_state(source, first))
    return GivenState.around(_detected_state(source, first, init, limits), is_guess=True)


def _detected_state(source: Source, first: Frame, detector: str, limits: PairLimits) -> CableState:
    try:
        found = DETECTORS[detector](limits).detect(decode_grey(first.image))
    except FrameError as error:
        raise ParameterError(
            f"{source.path}: no start from its first frame ({error}); use --init random"
        ) from error
    if not found:
        raise ParameterError(
            f"{source.path}: the detector {detector} sees no cable in its first frame; start with"
            " another detector, with --init random or with --init d,alpha,w,beta"
        )
    return found[0].state


def _true_state(source: Source, first: Frame) -> CableState:
    if first.truth is None:
        raise ParameterError(
            f"{source.path}: its first frame has no ground truth to start from; give labels with"
            " --truth FILE, or start with --init random or --init d,alpha,w,beta"
        )
    truth = first.truth
    # The rates are left to the filter: a label file has none, and `--init d,alpha,w,beta` neither.
    return CableState(truth.distance, truth.angle, truth.width, truth.skew)


def row_of(
    frame: Frame,
    estimate: CableEstimate,
    ms: float | None,
    metres: CrossTrack | Withheld | None = None,
) -> EstimateRow:
    """Return the row of the table for a tracked frame."""
    d, alpha, w, beta = (float(value) for value in estimate.standard_deviations()[:4])
    return EstimateRow(
        frame=frame.index,
        stamp=frame.stamp,
        status=estimate.status.value,
        state=estimate.claimed_state,
        sigma=(d, alpha, w, beta) if estimate.is_claimed else None,
        n_eff=estimate.effective_sample_size,
        presence=estimate.presence,
        evidence=estimate.evidence,
        hypotheses=len(estimate.hypotheses),
        ms=ms,
        metres=row_metres(metres) if isinstance(metres, CrossTrack) else None,
        no_metres=str(metres) if isinstance(metres, Withheld) else "",
        event=estimate.event,
    )


def track_picture(
    frame: Frame, grey: Image, tracker: CableTracker, metres: RecordedCableInstruments | None
) -> tuple[CableEstimate, float, CrossTrack | Withheld | None]:
    """Track a picture, shape (H, W), with the instruments' readings up to its frame.

    Return the estimate, its processing time [ms], and the cable in metres, None without
    instruments.

    Raises
    ------
    FrameError
        The frame cannot be used.
    """
    if metres is not None:
        metres.advance(frame)
    begin = time.perf_counter()
    motion = metres.motion(frame.stamp, grey) if metres is not None else None
    estimate = tracker.process(grey, frame.stamp, motion)
    ms = (time.perf_counter() - begin) * 1e3
    if metres is None:
        return estimate, ms, None
    metres.fusion.observe(estimate)
    return estimate, ms, metres.measure(estimate)


def track_frame(
    frame: Frame,
    tracker: CableTracker,
    results: CableFolder,
    metres: RecordedCableInstruments | None,
) -> None:
    """Track a frame, and add it to the results; without `metres` everything stays in pixels."""
    output = FrameMessages(results.bag, frame)
    write_truth(results.bag, frame)
    try:
        grey = decode_grey(frame.image)
        estimate, ms, known = track_picture(frame, grey, tracker, metres)
    except FrameError as error:
        output.write_all(messages_without_cable(output.factory, output.header, REFUSED, str(error)))
        results.add(frame, EstimateRow(frame.index, frame.stamp, REFUSED, event=str(error)), None)
        return
    assert tracker.particles is not None
    cloud = cloud_of(tracker.particles)
    factory, header, particles = output.factory, output.header, tracker.particles
    facts = {} if known is None else cable_facts(known)
    output.write_all(
        cable_messages(factory, header, estimate, particles, ms=ms, metres=lambda: facts)
    )
    output.write_overlay(node_topics.OVERLAY, lambda: draw_estimate(grey, estimate, cloud))
    if metres is not None and isinstance(known, CrossTrack):
        base_frame = metres.fusion.parameters.base_frame
        output.write_all(cross_track_messages(factory, header, base_frame, known))
    row = row_of(frame, estimate, ms, known)
    results.add(frame, row, cloud, estimate.hypotheses, estimate.image_size[0])
