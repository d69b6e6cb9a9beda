"""Long computing beside a control loop."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def beside(work: Callable[..., T], *args: object) -> Generator[None, None, T]:
    """Compute in a thread, and hand back control once a period until it is done.

    Closed before, it doesn't wait: the result is lost, and the thread ends by itself.
    """
    pool = ThreadPoolExecutor(1, "compute")
    try:
        running = pool.submit(work, *args)
        while not running.done():
            yield
        return running.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
