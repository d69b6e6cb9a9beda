"""Reading and writing single objects of a node, without threads."""

from __future__ import annotations

from typing import cast

from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoCommunicationError

from .can_line import CanLine


class LineSdoClient(SdoClient):
    """The library's, that takes its answer in itself instead of waiting for another thread to do so."""

    RESPONSE_TIMEOUT = 0.8
    """[s]"""
    MAX_RETRIES = 2
    """One more try: no drive is asked under way."""

    def read_response(self) -> bytes:
        """The answer to the last request; raises `canopen.SdoError`."""
        line = cast(CanLine, self.network)
        if not line.wait(lambda: not self.responses.empty(), self.RESPONSE_TIMEOUT):
            raise SdoCommunicationError("No SDO response received")
        return cast(bytes, super().read_response())
