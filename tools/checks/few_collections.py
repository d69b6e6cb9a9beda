"""Rare garbage collection while a large network is built and checked."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

COLLECTION_THRESHOLDS = 200_000, 50, 1_000
"""New objects until a collection of the youngest, and collections until one of the next generation."""


@contextmanager
def few_collections() -> Iterator[None]:
    """Make Python's garbage collections rare in this context, because each full collection visits all objects
    in use.
    """
    before = gc.get_threshold()
    gc.set_threshold(*COLLECTION_THRESHOLDS)
    try:
        yield
    finally:
        gc.set_threshold(*before)
