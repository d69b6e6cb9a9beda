"""Load of the cyclic frames on a bus."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

MAX_CYCLIC_LOAD = 0.7
"""Largest share of the bus, 0 to 1, for cyclic frames; the rest is for SDOs, emergencies, repeated frames."""

# ISO 11898-1, a data frame with an 11-bit identifier: 34 bits before the data's end that may be stuffed
# (start, identifier, control field, check sum), and 13 that are not (delimiters, acknowledgement, end of
# frame, space between frames).
_STUFFED, _PLAIN = 34, 13


def frame_bits(length: int) -> int:
    """Return the largest number of bits of a data frame on the wire, with all possible stuff bits.

    The 3 bits of space after the frame are included.

    Args:
        length: length of the frame's data, in [bytes].
    """
    stuffed = _STUFFED + 8 * length
    return stuffed + _PLAIN + (stuffed - 1) // 4


class CyclicFrame(NamedTuple):
    """A CAN frame that is sent in each control period, or every few periods."""

    what: str
    """Sender and kind of the frame, as shown to the user."""
    cob_id: int
    length: int
    """Length of the frame's data, in [bytes]."""
    period_s: float

    @property
    def bits(self) -> int:
        """Number of bits of the frame on the wire, with the largest possible number of stuff bits."""
        return frame_bits(self.length)


@dataclass(frozen=True)
class BusLoad:
    """Load of a CAN bus by cyclic frames, which are sent in each control period or every few periods."""

    frames: tuple[CyclicFrame, ...]
    bitrate: int
    """Bit rate in [bit/s]."""
    MAX_CYCLIC_LOAD: ClassVar = MAX_CYCLIC_LOAD

    @classmethod
    def of(cls, frames: Iterable[CyclicFrame], bitrate: int) -> BusLoad:
        """Return the load of cyclic frames on a bus with a `bitrate` in [bit/s]."""
        return cls(tuple(sorted(frames, key=lambda frame: frame.cob_id)), bitrate)

    def share_of(self, frame: CyclicFrame) -> float:
        """Return the share of the bus's capacity that a cyclic frame takes, from 0 to 1."""
        return frame.bits / frame.period_s / self.bitrate

    @property
    def share(self) -> float:
        """Share of the bus that all cyclic frames take together, from 0 to 1."""
        return sum(map(self.share_of, self.frames))

    @property
    def burst_s(self) -> float:
        """Time in [s] that the bus needs to send each cyclic frame once, without gaps.

        This is the largest delay of the frame that is sent last in a control period.
        """
        return sum(frame.bits for frame in self.frames) / self.bitrate

    @property
    def too_much(self) -> bool:
        """True if the cyclic frames take more than 70 % of the bus's capacity (`MAX_CYCLIC_LOAD`)."""
        return self.share > MAX_CYCLIC_LOAD
