"""Running an attempt to its end, while somebody may ask for a pause or a stop."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator
from contextlib import suppress
from enum import Enum

from handcart.backends.robot.robot import Robot
from handcart.networks.graph.planner import NotStarted
from handcart.networks.journal.measured import in_words
from handcart.primitives.contract.cause import FRAMEWORK
from handcart.primitives.contract.discrepancy import Discrepancy
from handcart.primitives.contract.outcome import Outcome
from handcart.primitives.restoring.snapshot import moved, settle, take_snapshot

from .run_life import RunLife, RunState

FRAMEWORK.add(__name__)
Attempt = Generator[None, None, Outcome]
Periods = Generator[None, None, Outcome | NotStarted | None]
"""Periods, and the outcome if the attempt ended in them."""


class Request(Enum):
    """What can be asked of a run from outside."""

    PAUSE = "pause"
    RESUME = "resume"
    STOP = "stop"
    """Stop where it is and hold: the run ends."""
    INTERRUPT = "interrupt"
    """The same, asked for by a signal: what the run is part of ends too."""
    CANCEL = "cancel"
    """Bring back what the running action did, then end."""
    RESTORE = "restore"
    """Bring back what the running action did, count that as its Fail, and go on."""


INTERRUPTED = "interrupted"
"""Why a run ended that a signal stopped."""
_STOPS = (Request.STOP, Request.INTERRUPT)
_ENDING = {
    Request.STOP: "stopped by request",
    Request.INTERRUPT: INTERRUPTED,
    Request.CANCEL: "cancelled by request",
}


MOST = 64
"""Requests that may wait to be honoured."""
CHECK = "supervision"
"""Who finds what is asked from outside, in the journal."""


class Interrupted(Exception):
    """The run is to end, because somebody asked for it."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class Supervision:
    """Honours requests at each period of an attempt."""

    def __init__(
        self, robot: Robot, life: RunLife, on_stop: Callable[[str, float], None] = lambda cause, asked: None
    ) -> None:
        """Nothing is asked for yet; `on_stop` hears of each stop: why, and when it was asked for, in [s]."""
        self._requests: deque[tuple[Request, float]] = deque()
        self._stop: tuple[Request, float] | None = None  # waits in no queue
        self._robot = robot
        self._life = life
        self._on_stop = on_stop
        self._after_restoring: Request | None = None

    def ask(self, request: Request) -> bool:
        """Somebody asks for something; honoured at the next period. Safe in a signal handler.

        Whether it was taken: too much may wait already. A stop always is, and goes before all else.
        """
        if request in _STOPS:
            self._stop = self._stop or (request, self._robot.time)
            return True
        if len(self._requests) >= MOST:
            return False
        self._requests.append((request, self._robot.time))
        return True

    def to_its_end(
        self, attempt: Attempt, time_out: float | None = None
    ) -> Generator[None, None, Outcome | NotStarted]:
        """The attempt's outcome; `NotStarted` if it was called back before it began.

        Args:
            attempt: the running one.
            time_out: the robot's time in [s] after which it is called back; None: never.

        Raises:
            Interrupted: it was stopped; the robot holds where it is.
        """
        latest = math.inf if time_out is None else self._robot.time + time_out
        try:
            next(attempt)
            while True:
                yield
                while (wanted := self._next()) is not None:
                    outcome = yield from self._honour(*wanted, attempt)
                    if outcome is not None:
                        return outcome
                if self._robot.time > latest and self._life.state is RunState.ACTING:
                    outcome = yield from _call_back(
                        attempt, Discrepancy(f"it took longer than {time_out:g} s")
                    )
                    if outcome is not None:
                        return outcome
                next(attempt)
        except StopIteration as end:
            ended: Outcome = end.value
            return ended

    def between_actions(self) -> None:
        """Honour what was asked for while no action runs; a pause waits for the next one.

        Raises:
            Interrupted: the run is to end.
        """
        if self._after_restoring is not None:
            raise Interrupted(_ENDING[self._after_restoring])
        stop = [] if self._stop is None else [self._stop]
        for request, asked in [*stop, *self._requests]:  # a copy: a signal may add to it
            if request in _ENDING:
                self._robot.stop()
                self._on_stop(_ENDING[request], asked)
                raise Interrupted(_ENDING[request])

    def _next(self) -> tuple[Request, float] | None:
        if self._stop is not None:
            return self._stop
        return self._requests.popleft() if self._requests else None

    def _honour(self, request: Request, asked: float, attempt: Attempt) -> Periods:
        if request in _STOPS:
            self._robot.stop()  # before all else; closing the attempt may take its time
            attempt.close()
            self._robot.stop()
            self._on_stop(_ENDING[request], asked)
            yield from come_to_rest(self._robot)
            raise Interrupted(_ENDING[request])
        if request is Request.PAUSE:
            return (yield from self._pause(attempt))
        if request is Request.CANCEL:
            self._after_restoring = request
        if request in (Request.CANCEL, Request.RESTORE) and self._life.state is RunState.ACTING:
            return (yield from _call_back(attempt, Discrepancy(_ENDING.get(request, "interrupted"))))
        return None

    def _pause(self, attempt: Attempt) -> Periods:
        """Hold until something else is asked for; moved by hand meanwhile is a discrepancy."""
        self._life.pause()
        self._robot.stop()
        rest = settle(self._robot)
        stood = None
        while not self._called():
            if stood is None:
                try:
                    next(rest)
                except StopIteration:
                    stood = take_snapshot(self._robot, {})
                    continue
            yield
        self._life.resume()
        off = {} if stood is None else moved(self._robot, stood, take_snapshot(self._robot, {}))
        if off and self._life.state is RunState.ACTING:
            return (yield from _call_back(attempt, Discrepancy(f"moved during a pause: {in_words(off)}")))
        return None

    def _called(self) -> bool:
        """Whether something is asked for but one more pause."""
        while self._requests and self._requests[0][0] is Request.PAUSE:
            self._requests.popleft()
        return self._stop is not None or bool(self._requests)


def come_to_rest(robot: Robot) -> Generator[None, None, None]:
    """Wait until nothing moves any more; where that can't be read, there is nothing to wait for."""
    with suppress(Exception):
        yield from settle(robot)


def _call_back(attempt: Attempt, discrepancy: Discrepancy) -> Periods:
    discrepancy.check = CHECK
    try:
        attempt.throw(discrepancy)
    except StopIteration as end:
        ended: Outcome = end.value
        return ended
    except Discrepancy:  # it was still waiting for rest before its start
        return NotStarted(discrepancy.reason)
    yield
    return None
