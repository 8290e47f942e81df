"""Report message about the processing of one frame."""

from __future__ import annotations

from collections.abc import Mapping

from cable_tracker.sequences.messages.factory import Message, MessageFactory


def make_report(
    factory: MessageFactory, header: Message, status: str, values: Mapping[str, str]
) -> Message:
    """Pack what was done with one frame as a DiagnosticArray: its status and further facts."""
    pairs = [
        factory.make("diagnostic_msgs/msg/KeyValue", key=key, value=value)
        for key, value in values.items()
    ]
    entry = factory.make(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=factory.octet(0),
        name="cable_tracker: frame",
        message=status,
        hardware_id=str(header.frame_id),
        values=pairs,
    )
    return factory.make("diagnostic_msgs/msg/DiagnosticArray", header=header, status=[entry])


def report_status(report: Message) -> str:
    """Return the status in a message that `make_report` made."""
    return str(report.status[0].message)


def report_facts(report: Message) -> dict[str, str]:
    """Return the facts of a message that `make_report` made, by name."""
    return {str(pair.key): str(pair.value) for pair in report.status[0].values}


def fact_number(facts: Mapping[str, str], name: str) -> float | None:
    """Return a fact that is a number; None: it is empty, or missing."""
    text = facts.get(name, "")
    return float(text) if text else None
