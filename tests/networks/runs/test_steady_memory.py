"""Garbage is collected between actions alone (row K6)."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator
from typing import Any, cast

import pytest

from handcart.networks.events.events import Ended, RunEnded
from handcart.networks.runs.steady_memory import SteadyMemory


@pytest.fixture(autouse=True)
def _nothing_excluded() -> Iterator[None]:
    """Nothing is excluded from collection at first, as in a fresh process."""
    gc.unfreeze()
    yield
    gc.freeze()


class Knot:
    """Holds itself."""

    def __init__(self) -> None:
        self.own = self


def test_k6_nothing_is_collected_but_between_actions() -> None:
    """K6: no collection in the loop; after an action what hangs about goes."""
    ended = object.__new__(Ended)
    memory, nothing = SteadyMemory(), cast(Any, None)
    memory.begin(nothing, nothing)
    try:
        assert not gc.isenabled()
        assert gc.get_freeze_count() > 10_000
        gone = weakref.ref(Knot())
        memory.event(object.__new__(RunEnded))
        assert gone() is not None
        memory.event(ended)
        assert gone() is None
    finally:
        memory.end()
    assert gc.isenabled()


def test_only_the_first_run_of_a_process_excludes_what_exists() -> None:
    memory, nothing = SteadyMemory(), cast(Any, None)
    memory.begin(nothing, nothing)
    memory.end()
    gone, frozen = weakref.ref(Knot()), gc.get_freeze_count()
    memory.begin(nothing, nothing)
    memory.end()
    assert gone() is None
    assert frozen >= gc.get_freeze_count() > 10_000


def test_it_leaves_things_as_they_were() -> None:
    gc.disable()
    try:
        memory, nothing = SteadyMemory(), cast(Any, None)
        memory.begin(nothing, nothing)
        memory.end()
        assert not gc.isenabled()
    finally:
        gc.enable()
