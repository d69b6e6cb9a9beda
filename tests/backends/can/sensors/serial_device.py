"""A serial device on a pseudo-terminal, for tests of sensors."""

from __future__ import annotations

import fcntl
import os
import pty
import termios
import time
import tty


class Device:
    """Device at the other end of a pseudo-terminal."""

    def __init__(self) -> None:
        self._ours, theirs = pty.openpty()
        tty.setraw(theirs)
        self.port = os.ttyname(theirs)
        self._theirs = theirs

    def say(self, line: bytes) -> None:
        waiting = self._waiting() + len(line)
        os.write(self._ours, line)
        while self._waiting() < waiting:  # the system hands it over by and by
            time.sleep(0.001)

    def _waiting(self) -> int:
        return int.from_bytes(fcntl.ioctl(self._theirs, termios.FIONREAD, bytes(4)), "little")

    def unplug(self) -> None:
        for item in (self._ours, self._theirs):
            if item >= 0:
                os.close(item)
        self._ours = self._theirs = -1
