"""A process that ends when the one that started it is gone."""

from __future__ import annotations

import os
import signal
import threading
import time
from multiprocessing import parent_process


def end_with_parent() -> None:
    """Have this process, which `multiprocessing` started, end as soon as its parent has, however that did."""
    threading.Thread(target=_wait, daemon=True).start()


def _wait() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    while True:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(1.0)
