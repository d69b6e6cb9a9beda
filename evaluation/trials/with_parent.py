"""Termination of a child process together with its parent."""

from __future__ import annotations

import os
import signal
import threading
import time
from multiprocessing import parent_process


def end_with_parent() -> None:
    """Terminate this process, started by `multiprocessing`, as soon as its parent has ended in any way."""
    threading.Thread(target=_wait, daemon=True).start()


def _wait() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    while True:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(1.0)
