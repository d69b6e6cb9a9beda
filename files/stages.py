"""Names of the stages of a long check or loading, for whoever shows what is being done."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_heard: ContextVar[Callable[[str], None] | None] = ContextVar("heard", default=None)


def begin_stage(words: str) -> None:
    """Report that a stage of a program begins, to the listener set with `hearing_of_stages`, if any.

    Args:
        words: name of the stage, such as "map and knowledge".
    """
    heard = _heard.get()
    if heard is not None:
        heard(words)


@contextmanager
def hearing_of_stages(heard: Callable[[str], None]) -> Iterator[None]:
    """Call `heard` with the name of each stage that `begin_stage` reports while this context is open."""
    before = _heard.set(heard)
    try:
        yield
    finally:
        _heard.reset(before)
