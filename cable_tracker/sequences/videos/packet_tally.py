"""What the packets of a video tell of frames that are missing, and of those that none misses."""

from __future__ import annotations

import av


class PacketTally:
    """Counts the packets of a stream while they are read.

    Attributes
    ----------
    discarded : int
        Number of packets that only serve to decode others: a file that was cut without coding it
        anew says with an edit list where the first frame that is shown begins.
    end : int or None
        Latest end of a packet, in ticks of the stream; None: none has a time.
    """

    def __init__(self) -> None:
        self.discarded = 0
        self.end: int | None = None
        self._numbered = 0
        self._last_number = -1

    def counted(self, packet: av.Packet[av.VideoStream]) -> av.Packet[av.VideoStream]:
        """Count a packet, and return it."""
        self.discarded += packet.is_discard
        if packet.pts is not None:
            end = packet.pts + (packet.duration or 0)
            self.end = end if self.end is None else max(self.end, end)
        if packet.dts is not None:
            self._numbered += 1
            self._last_number = max(self._last_number, packet.dts)
        return packet

    @property
    def empty(self) -> int:
        """Number of packets without data before the last one of an AVI, which numbers them.

        FFmpeg passes over these, but the header counts them. What is missing behind the last packet
        is not taken for a pause: a file that was cut off looks alike.
        """
        return self._last_number + 1 - self._numbered
