"""Rare garbage collection while many states are visited."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

COLLECTION_THRESHOLDS = 200_000, 50, 1_000
"""New objects until a collection of the youngest, and collections until one of the next generation."""
_lock, _outer = Lock(), list[tuple[int, int, int]]()
"""Thresholds at the begin of each context that is active; the first ones are restored after the last end."""


@contextmanager
def few_collections() -> Iterator[None]:
    """Make Python's garbage collections rare in this context, because each full collection visits all objects
    in use.

    States and decisions are tuples without cycles, which are freed without a collection. Contexts may be
    nested, and overlap in several threads.
    """
    with _lock:
        _outer.append(gc.get_threshold())
        gc.set_threshold(*COLLECTION_THRESHOLDS)
    try:
        yield
    finally:
        with _lock:
            before = _outer[0]
            _outer.pop()
            if not _outer:
                gc.set_threshold(*before)
