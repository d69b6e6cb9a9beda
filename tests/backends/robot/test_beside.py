"""Long computations while the robot holds."""

from __future__ import annotations

from collections.abc import Generator
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.robot.beside import at_rest

PERIOD_S = 0.05


@pytest.mark.parametrize(("count", "takes", "periods"), [(3, 0.2, 4), (9, 0.2, 9), (0, 0.05, 1)])
def test_a_computation_at_rest_does_one_step_a_period(count: int, takes: float, periods: int) -> None:
    done: list[int] = []

    def steps() -> Generator[None, None, str]:
        for number in range(count):
            done.append(number)
            yield
        return "answer"

    robot: Any = SimpleNamespace(time=0.0)

    def wait(seconds: float) -> Generator[None, None, None]:
        end = robot.time + seconds
        while robot.time < end - 1e-9:
            yield

    robot.wait = wait
    job, passed = at_rest(steps(), robot, True, takes), 0
    while True:
        before = len(done)
        try:
            next(job)
        except StopIteration as end:
            assert end.value == "answer"
            break
        assert len(done) - before <= 1
        robot.time += PERIOD_S
        passed += 1
    assert passed == periods
