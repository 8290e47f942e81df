"""Cache of recently used values within a limit of memory."""

from __future__ import annotations

from collections import OrderedDict
from typing import Generic, TypeVar

Item = TypeVar("Item")


class RecentlyUsed(Generic[Item]):
    """Keeps items by number; when there is no more room, what was not used for longest goes.

    Parameters
    ----------
    room : int
        Bytes there is room for. The newest item is kept however large it is.
    """

    def __init__(self, room: int) -> None:
        self._room = room
        self._items: OrderedDict[int, tuple[Item, int]] = OrderedDict()
        self._bytes = 0

    def get(self, number: int) -> Item | None:
        """Return an item, which counts as used now; None if it is not kept."""
        kept = self._items.get(number)
        if kept is None:
            return None
        self._items.move_to_end(number)
        return kept[0]

    def put(self, number: int, item: Item, size: int) -> None:
        """Keep an item of a size [bytes], in the place of one of the same number."""
        _, before = self._items.pop(number, (None, 0))
        self._items[number] = item, size
        self._bytes += size - before
        while self._bytes > self._room and len(self._items) > 1:
            _, (_, freed) = self._items.popitem(last=False)
            self._bytes -= freed
