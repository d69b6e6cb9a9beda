"""Long computing beside a control loop."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol, TypeVar

from handcart.robotics.numerics.stepwise import finish

T = TypeVar("T")


class Holding(Protocol):
    """Robot that can hold still while something is computed."""

    time: float

    def wait(self, seconds: float) -> Generator[None, None, None]:
        """Hold still for a time in [s]."""


def beside(work: Callable[..., T], *args: object) -> Generator[None, None, T]:
    """Compute in a thread, and hand back control once a period until it is done.

    A generator that is closed early doesn't wait: the result is lost, and the thread ends by itself.
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
    """Compute in steps, one a period in simulation; on a real robot all of them in a thread, as `beside`
    does.

    Args:
        steps: computation, whose return value is the result; a step ends with each `yield`.
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
    """Compute while the robot holds, in simulation one step a period; see `Robot.compute`.

    Args:
        steps: computation.
        robot: the robot that holds.
        simulated: True for a robot with a simulated backend.
        takes: least simulated duration of the computation, in [s].
    """
    result: T
    if not simulated:
        result = yield from beside(finish, steps)
        return result
    begun = robot.time
    result = yield from steps
    yield from robot.wait(takes - (robot.time - begun))
    return result
