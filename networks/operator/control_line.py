"""One client connection to a run: bytes received, and bytes still to be sent."""

from __future__ import annotations

import selectors
import socket

MAX_MESSAGE_BYTES = 4096


class ControlLine:
    """Connection of one client that sends commands, as lines, to a run and receives answers.

    It buffers at most one message, and reads nothing while an answer waits to be sent. A client that sends
    too much, or does not read its answers, delays only itself.
    """

    def __init__(self, other: socket.socket, now: float) -> None:
        """Use a connected socket; `now` is the wall clock's time, in [s]."""
        other.setblocking(False)
        self.socket = other
        self.moved = now
        """Time of the last received or sent bytes, in [s] of the wall clock."""
        self._came, self._goes = b"", b""
        self._ended, self._deaf, self._refused = False, False, False

    @property
    def waits(self) -> bool:
        """True if a complete message was received, and the answer to the message before it has been sent."""
        return not self._goes and (
            b"\n" in self._came or self._too_long or (self._ended and self._came != b"")
        )

    @property
    def over(self) -> bool:
        """True if nothing is left to receive from the client, or to send to it."""
        return not self._goes and ((self._ended and not self._came) or self._refused)

    @property
    def interest(self) -> int:
        """Event of the connection's socket to wait for: `EVENT_WRITE` while an answer is to be sent,
        otherwise `EVENT_READ`.
        """
        return selectors.EVENT_WRITE if self._goes else selectors.EVENT_READ

    def exchange(self, now: float) -> None:
        """Send and receive as many bytes as possible without waiting, at a time `now` in [s] of the wall
        clock.
        """
        if self._goes:
            self._send(now)
        if not self._goes and not self.waits and not self._ended:
            self._receive(now)

    def message(self) -> bytes | None:
        """Return the next message, without the line's end; None if its line is too long.

        After a line that is too long, the connection accepts no more messages.
        """
        if self._too_long:
            self._came, self._refused = b"", True
            return None
        line, _, self._came = self._came.partition(b"\n")
        return line

    def answer(self, line: bytes, now: float) -> None:
        """Send a line to the client, or its beginning if the socket takes no more for now.

        Args:
            line: the line without its line end.
            now: present time, in [s] of the wall clock.
        """
        self._goes = b"" if self._deaf else line + b"\n"
        self._send(now)

    @property
    def _too_long(self) -> bool:
        return len(self._came.partition(b"\n")[0]) > MAX_MESSAGE_BYTES

    def _receive(self, now: float) -> None:
        try:
            new = self.socket.recv(MAX_MESSAGE_BYTES)
        except BlockingIOError:
            return
        except OSError:
            new = b""
        self._ended = not new
        self._came += new
        self.moved = now if new else self.moved

    def _send(self, now: float) -> None:
        try:
            sent = self.socket.send(self._goes) if self._goes else 0
        except BlockingIOError:
            return
        except OSError:  # the client hung up; its earlier requests still count
            self._deaf, sent = True, len(self._goes)
        self._goes = self._goes[sent:]
        self.moved = now if sent else self.moved
