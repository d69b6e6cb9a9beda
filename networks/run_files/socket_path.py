"""The sockets in a run's folder, and how to name one whose path is longer than a socket's name may be."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

CONTROL_SOCKET = "control"
"""Name of the socket for messages and answers."""
STOP_SOCKET = "control.stop"
"""Name of the socket on which any datagram stops the run."""


@contextmanager
def socket_path(path: Path) -> Iterator[str]:
    """Yield a name of at most 108 bytes, the limit of Unix sockets, for a socket's path that may be longer.

    Raises:
        OSError: the folder of the socket cannot be opened.
    """
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)
