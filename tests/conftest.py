"""Fixtures of all tests; Hypothesis draws the same examples in every run."""

from __future__ import annotations

import gc
import hashlib
import shutil
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver

settings.register_profile("handcart", derandomize=True, deadline=None)
settings.load_profile("handcart")

# Hypothesis draws some values from the constants of all local modules imported so far, which
# depend on the tests before. Finding them also parses each module (HypothesisWorks/hypothesis#4627).
if hasattr(providers, "_get_local_constants"):
    providers._get_local_constants = lambda: providers._local_constants


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options that draw some of the slow tests: others with each seed, all of them with time."""
    parser.addoption("--drawn", type=int, metavar="PERCENT", help="run so many slow tests, drawn by seed")
    parser.addoption("--draw-seed", default="", metavar="TEXT", help="seed of --drawn, such as a commit")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect the slow tests that were not drawn."""
    percent, seed = config.getoption("--drawn"), config.getoption("--draw-seed")
    if percent is None:
        return
    kept, left = list[pytest.Item](), list[pytest.Item]()
    for item in items:
        is_left = item.get_closest_marker("slow") and _draw(item.nodeid, seed) >= percent
        (left if is_left else kept).append(item)
    config.hook.pytest_deselected(items=left)
    items[:] = kept


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect no garbage while modules are imported, which took a sixth of that time; nearly all is kept."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_finish() -> None:
    """Exclude modules and collected tests from garbage collection, which took a tenth of the time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True, scope="module")
def _excluded_leftovers() -> Iterator[None]:
    """Exclude what each module of tests leaves, too: every simulated run in a process collects four times."""
    yield
    gc.collect()
    gc.freeze()


def pytest_sessionfinish() -> None:
    """Include them again, so that libraries find nothing leaked at exit."""
    gc.unfreeze()


def _draw(name: str, seed: str) -> float:
    """Return a number from 0 to 100 for a test, the same in each process and on each machine."""
    return 100.0 * int.from_bytes(hashlib.sha256(f"{seed}:{name}".encode()).digest()[:4]) / 2**32


class Clock:
    """A clock that advances on request."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


class Copier(RunObserver):
    """Observer that copies a run's folder after each action, as it would be left by a kill at that time."""

    def __init__(self, number: int, to: Path) -> None:
        self.number, self.to, self.folder = number, to, Path()

    def begin(self, prepared: object, run_dir: Path) -> None:
        self.folder = run_dir

    def event(self, event: Event) -> None:
        if isinstance(event, Ended) and event.number == self.number:
            shutil.copytree(self.folder, self.to, ignore=shutil.ignore_patterns("control*"))


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def copier() -> type[Copier]:
    return Copier
