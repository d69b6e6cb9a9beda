"""A pytest plugin: the fixture `stage` runs single primitives in a user's own tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from evaluation.stage import Stage


@pytest.fixture
def set_stage() -> Iterator[Callable[..., Stage]]:
    """Builds stages as `evaluation.stage.set_stage` does, and closes them after the test.

    def test_forward(set_stage):
        outcome = set_stage(seed=3).do(Forward(distance_m=0.5))
    """
    from evaluation.stage import set_stage as build

    stages: list[Stage] = []

    def make(*args: Any, **options: Any) -> Stage:
        stages.append(build(*args, **options))
        return stages[-1]

    yield make
    for stage in stages:
        stage.backend.close()
