"""Long computing beside a control loop."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol, TypeVar

from handcart.robotics.numerics.stepwise import finish

T = TypeVar("T")


class Holding(Protocol):
    """Protocol of a robot that can hold still for a time, for a long computation between two motions."""

    time: float

    def wait(self, seconds: float) -> Generator[None, None, None]:
        """Keep the robot at rest for a time in [s], as a generator that yields once a period."""


def beside(work: Callable[..., T], *args: object) -> Generator[None, None, T]:
    """Run a function in a thread, and yield once a control period until it is done; return its result.

    A generator that is closed early does not wait for the function: the thread runs on to the function's end,
    and the result is lost.
    """
    pool = ThreadPoolExecutor(1, "compute")
    try:
        running = pool.submit(work, *args)
        while not running.done():
            yield
        return running.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def in_steps(steps: Generator[None, None, T], simulated: bool) -> Generator[None, None, T]:
    """Run a long computation without delaying the control loop; yield once in each control period.

    In simulation one step is computed in each period; on a real robot all steps run in a thread (`beside`).

    Args:
        steps: the computation as a generator; each of its steps ends with a `yield`, and it returns the
            result.
        simulated: True for a robot with a simulated backend.
    """
    result: T
    if not simulated:
        result = yield from beside(finish, steps)
        return result
    result = yield from steps
    yield
    return result


def at_rest(
    steps: Generator[None, None, T], robot: Holding, simulated: bool, takes: float
) -> Generator[None, None, T]:
    """Run a long computation while the robot holds still; yield once in each control period (see
    `Robot.compute`).

    In simulation one step is computed in each period; on a real robot all steps run in a thread (`beside`).

    Args:
        steps: the computation as a generator; each of its steps ends with a `yield`, and it returns the
            result.
        robot: the robot that holds still.
        simulated: True for a robot with a simulated backend.
        takes: simulated time that the computation takes at least, in [s].
    """
    result: T
    if not simulated:
        result = yield from beside(finish, steps)
        return result
    begun = robot.time
    result = yield from steps
    yield from robot.wait(takes - (robot.time - begun))
    return result
