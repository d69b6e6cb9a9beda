"""Fixtures of all tests; Hypothesis draws the same examples in every run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from hypothesis import settings

from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver

settings.register_profile("handcart", derandomize=True, deadline=None)
settings.load_profile("handcart")


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
