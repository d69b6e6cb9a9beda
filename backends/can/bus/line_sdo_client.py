"""Reading and writing single objects of a node, without threads."""

from __future__ import annotations

from typing import cast

from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoCommunicationError

from .can_line import CanLine

_LENGTH = 8  # bytes of each SDO frame (CiA 301)
_FRAMES = 16  # maximum frames of one answer: only numbers are read


class NoAnswer(SdoCommunicationError):
    """Error: a node has not answered an SDO request within the time-out."""


class LineSdoClient(SdoClient):
    """SDO client that receives a node's answer itself instead of waiting for another thread.

    It raises `SdoCommunicationError` if an answer violates CiA 301 or has too many frames.
    """

    RESPONSE_TIMEOUT = 0.8
    """Time-out of an answer, in [s]."""
    MAX_RETRIES = 2
    """Number of tries of a request; a second one delays no motion, because objects are not read while a drive
    moves.
    """
    _left = _FRAMES

    def upload(self, index: int, subindex: int) -> bytes:
        """Read an object of a node by SDO, and return its data."""
        self._left = _FRAMES
        return super().upload(index, subindex)

    def download(self, index: int, subindex: int, data: bytes, force_segment: bool = False) -> None:
        """Write `data` into an object of a node; `force_segment` also sends up to 4 bytes in segments."""
        self._left = _FRAMES
        super().download(index, subindex, data, force_segment)

    def read_response(self) -> bytes:
        """Return the answer to the last request.

        Raises:
            NoAnswer: no answer has arrived within the time-out.
            canopen.SdoError: the node refused the request, or its answer is malformed.
        """
        line = cast(CanLine, self.network)
        self._left -= 1
        if self._left < 0:
            raise SdoCommunicationError(f"an answer of more than {_FRAMES} frames")
        if not line.wait(lambda: not self.responses.empty(), self.RESPONSE_TIMEOUT):
            raise NoAnswer("No SDO response received")
        length = len(self.responses.queue[0])
        if length != _LENGTH:
            self.responses.get()
            raise SdoCommunicationError(f"an answer of {length} bytes")
        return cast(bytes, super().read_response())
