"""Long computations on the map that EXPLORE draws, one at a time."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, TypeVar

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.driving.scan_collector import ScanCollector

T = TypeVar("T")


class MapWork:
    """Computation on a growing map, during which keyframes wait.

    On a real robot it runs in a thread, which no exception of the control loop ends. A computation that was
    left is therefore run to its end (`drain`) before anything else uses the map.
    """

    def __init__(self, scans: ScanCollector) -> None:
        """Begin without a computation, on the map of a collector of scans."""
        self._scans = scans
        self._job: Generator[None, None, Any] | None = None

    @property
    def is_running(self) -> bool:
        """True from `begin` until `advance` has returned the result."""
        return self._job is not None

    def begin(self, robot: Robot, work: Callable[..., object], *args: object, takes: float = 0.2) -> None:
        """Begin a computation; arguments as for `Robot.compute`. Another one must not be running."""
        assert self._job is None, "the map is in use"
        self._scans.is_busy = True
        self._job = robot.compute(work, *args, takes=takes)

    def advance(self) -> tuple[Any] | None:
        """Continue for one control period; return the result once there is one, otherwise None."""
        assert self._job is not None
        try:
            next(self._job)
        except StopIteration as end:
            self._end()
            return (end.value,)
        except Exception:
            self._end()
            raise
        return None

    def run(
        self, robot: Robot, work: Callable[..., T], *args: object, takes: float = 0.2
    ) -> Generator[None, None, T]:
        """Compute while the base holds still; arguments as for `Robot.compute`. Return the result.

        A computation that was left before is run to its end first.
        """
        yield from self.drain()
        self.begin(robot, work, *args, takes=takes)
        while (result := self.advance()) is None:
            yield
        value: T = result[0]
        return value

    def drain(self) -> Periods:
        """Run a computation that was left to its end; its result is lost."""
        while self._job is not None and self.advance() is None:
            yield

    def _end(self) -> None:
        """Let the keyframes that have waited be added to the map."""
        self._job, self._scans.is_busy = None, False
        self._scans.flush()
