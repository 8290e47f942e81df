from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from estimate_reader import read_estimates
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader

from cable_tracker.cable.model.estimate import CableEstimate, Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.messages import cable_facts
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.offline.results import BAG
from cable_tracker.offline.track_cable import row_of
from cable_tracker.ros.clients.recorder import RecordedFrame
from cable_tracker.ros.clients.track_cable import _row
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.frame import CompressedImage, Frame
from cable_tracker.sequences.messages.cable import make_state, report_values
from cable_tracker.sequences.messages.frame_report import make_report
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings, write_survey_bag
from cable_tracker.tracking.status import REFUSED, TrackingStatus

FRAME = Frame(3, 1_700_000_000_040_000_000, CompressedImage("jpeg", memoryview(b"")))
STATE = CableState(12.5, -0.3, 40.25, 0.01, -3.0, 0.2, 1.5, -0.01)
MILLISECONDS = 1.25
PLACE = CrossTrack(0.25, 0.5, 0.125, 0.06, np.diag([0.04, 0.05, 0.01, 0.02]), 1.0, -2.0)


def estimate_of(
    status: TrackingStatus, presence: float | None, hypotheses: tuple[Hypothesis, ...]
) -> CableEstimate:
    return CableEstimate(
        stamp=FRAME.stamp,
        status=status,
        state=STATE,
        covariance=np.diag(np.arange(1.0, 9.0) / 3),
        effective_sample_size=100 / 3,
        evidence=2 / 3,
        image_size=(320, 240),
        presence=presence,
        hypotheses=hypotheses,
    )


def row_over_ros(estimate: CableEstimate | None, frame: Frame = FRAME) -> EstimateRow:
    """Return the row that is made of the node's messages; without an estimate, of a refusal."""
    factory = RclpyMessages()
    header = make_header(factory, FRAME.stamp, "camera")
    if estimate is None:
        status, state = REFUSED, make_state(factory, header, None)
        report = make_report(factory, header, REFUSED, {"event": "too small"})
    else:
        status = estimate.status.value
        claimed = estimate.state if estimate.status is TrackingStatus.TRACKING else None
        state = make_state(factory, header, claimed, estimate.standard_deviations()[:4])
        report = make_report(factory, header, status, report_values(estimate, MILLISECONDS))
    messages = {node_topics.FRAME_REPORT: serialize_message(report)}
    return _row(frame, RecordedFrame(messages, status), state, in_metres=True)


@pytest.mark.parametrize("status", list(TrackingStatus))
@pytest.mark.parametrize(
    ("presence", "hypotheses"),
    [
        (None, ()),
        (0.0, (Hypothesis(1.0, STATE),)),
        (1 / 3, (Hypothesis(0.9, STATE), Hypothesis(0.1, STATE))),
    ],
)
def test_the_row_is_the_one_made_without_ros(
    status: TrackingStatus, presence: float | None, hypotheses: tuple[Hypothesis, ...]
) -> None:
    estimate = estimate_of(status, presence, hypotheses)
    assert row_over_ros(estimate) == row_of(FRAME, estimate, MILLISECONDS)


def test_a_refused_frame_has_no_numbers() -> None:
    assert row_over_ros(None) == EstimateRow(FRAME.index, FRAME.stamp, REFUSED, event="too small")


def test_a_row_without_an_image_gives_the_reason_of_the_recording() -> None:
    frame = replace(FRAME, image=replace(FRAME.image, missing="the PNG is truncated"))
    assert row_over_ros(None, frame).event == "the PNG is truncated"


@pytest.mark.parametrize("known", [PLACE, Withheld(Reason.NO_ALTITUDE, "none has come")])
def test_metres_stand_in_the_row_where_they_are_wanted_alone(known: CrossTrack | Withheld) -> None:
    """The node, which knows no recording, measures with what it hears, or says why not."""
    estimate = estimate_of(TrackingStatus.TRACKING, None, ())
    header = make_header(RclpyMessages(), FRAME.stamp, "camera")
    facts = report_values(estimate, MILLISECONDS) | cable_facts(known)
    report = make_report(RclpyMessages(), header, estimate.status.value, facts)
    recorded = RecordedFrame({node_topics.FRAME_REPORT: serialize_message(report)}, "TRACKING")
    sigma = estimate.standard_deviations()[:4]
    state = make_state(RclpyMessages(), header, estimate.state, sigma)
    wanted = row_of(FRAME, estimate, MILLISECONDS, known)
    assert _row(FRAME, recorded, state, in_metres=True) == wanted
    assert _row(FRAME, recorded, state, in_metres=False) == row_of(FRAME, estimate, MILLISECONDS)


@pytest.mark.slow
def test_the_estimates_and_the_metres_are_the_same_with_ros_and_without(
    command: Callable[..., Any],
) -> None:
    settings = SurveyDiveSettings(length=2.0, rate=8.0, image_size=(160, 120), seed=3)
    write_survey_bag(Path("dive"), settings)

    def tracked(name: str, *words: str) -> Path:
        options = ("--output", name, "--no-video", "--no-pictures", "--no-timing")
        assert command("track", "dive", *options, *words).code == 0
        return Path(name) / "estimates.csv"

    plain, over_ros = tracked("plain"), tracked("over_ros", "--ros")
    rows = [row for row in read_estimates(plain) if row.metres is not None]
    assert rows
    assert plain.read_text() == over_ros.read_text()
    offline, live = (metres_in_bag(each.with_name(BAG)) for each in (plain, over_ros))
    assert [len(stamps) for stamps in offline.values()] == [len(rows), len(rows)]
    assert offline == live


def metres_in_bag(bag: Path) -> dict[str, list[bytes]]:
    """Return the serialised messages in metres, by the last part of their topics."""
    found: dict[str, list[bytes]] = {"cross_track": [], "cross_track_ahead": []}
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            name = connection.topic.rpartition("/")[2]
            if name in found:
                found[name].append(bytes(data))
    return found
