"""Callbacks made of others."""

from __future__ import annotations

from collections.abc import Callable

from cable_tracker.sequences.messages.factory import Message


def followed_by(
    take: Callable[[Message], None], on_news: Callable[[], None]
) -> Callable[[Message], None]:
    """Return a callback that takes a message, and calls `on_news` then.

    It is a plain function: rclpy wants to see a callback's signature.
    """

    def taken(message: Message) -> None:
        take(message)
        on_news()

    return taken
