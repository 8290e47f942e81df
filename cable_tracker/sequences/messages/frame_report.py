"""Words and facts as a DiagnosticArray, and the report about the processing of one frame."""

from __future__ import annotations

from collections.abc import Mapping

from cable_tracker.sequences.messages.factory import Message, MessageFactory


def make_status_array(
    factory: MessageFactory,
    header: Message,
    name: str,
    status: str,
    values: Mapping[str, str],
    *,
    level: int = 0,
    hardware_id: str,
) -> Message:
    """Pack one status and further facts as a DiagnosticArray.

    Parameters
    ----------
    name : str
        What the status is of.
    status : str
        In a word or two.
    values : mapping of str to str
        Facts by key.
    level : int
        Level of diagnostic_msgs/DiagnosticStatus: 0 OK, 1 WARN, 2 ERROR, 3 STALE.
    hardware_id : str
        Full name of a node, or frame of a camera.
    """
    entry = factory.make(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=factory.octet(level),
        name=name,
        message=status,
        hardware_id=hardware_id,
        values=[
            factory.make("diagnostic_msgs/msg/KeyValue", key=key, value=value)
            for key, value in values.items()
        ],
    )
    return factory.make("diagnostic_msgs/msg/DiagnosticArray", header=header, status=[entry])


def make_report(
    factory: MessageFactory, header: Message, status: str, values: Mapping[str, str]
) -> Message:
    """Pack what was done with one frame as a DiagnosticArray: its status and further facts."""
    frame_id = str(header.frame_id)
    return make_status_array(
        factory, header, "cable_tracker: frame", status, values, hardware_id=frame_id
    )


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
