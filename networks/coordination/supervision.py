"""Running an attempt to its end, while others may request a pause or a stop."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator
from contextlib import suppress
from enum import Enum
from typing import NamedTuple

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause import FRAMEWORK_MODULES
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Outcome
from handcart.primitives.outcomes.residual import Residuals
from handcart.primitives.restoring.snapshot import residuals, settle, take_snapshot

from .run_life import RunLife, RunState

FRAMEWORK_MODULES.add(__name__)
Attempt = Generator[None, None, Outcome]
Periods = Generator[None, None, Outcome | None]
"""Generator of periods that returns the outcome if the attempt has ended, otherwise None."""


class Request(Enum):
    """Request that an operator, a program or a signal makes to a run, such as a pause or a stop."""

    PAUSE = "pause"
    RESUME = "resume"
    STOP = "stop"
    """Stop where it is and hold: the run ends."""
    INTERRUPT = "interrupt"
    """Stop as for STOP, requested by a signal: the program around the run ends too."""
    CANCEL = "cancel"
    """Restore what the running action changed, then end."""
    RESTORE = "restore"
    """Restore what the running action changed, count that as its Fail, and continue."""
    PREEMPT = "preempt"
    """Restore what the running action changed, without counting a Fail, and continue."""


INTERRUPTED_REASON = "interrupted"
"""Reason of the end of a run that a signal stopped."""
_STOPS = (Request.STOP, Request.INTERRUPT)
_ENDING = {
    Request.STOP: "stopped by request",
    Request.INTERRUPT: INTERRUPTED_REASON,
    Request.CANCEL: "cancelled by request",
}


MAX_REQUESTS = 64
"""Maximum number of requests that wait to be honoured."""
MAX_UNAPPLIED = 20
"""Maximum number of late requests that are kept in words."""
CHECK_NAME = "supervision"
"""Name of the check in the journal that finds requests from outside."""


class Interrupted(Exception):
    """Exception: the run has to end because its end was requested."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class PendingRequest(NamedTuple):
    """A request to a run, such as a pause or a stop, that the run has accepted but not followed yet."""

    what: Request
    time: float
    """The robot's time of the request, in [s]."""
    number: int | None
    """Number of the action that is meant, from 1; None: the run is meant."""


class Supervision:
    """Supervisor of a run's attempts, which follows requests from outside (`Request`) in each period.

    A pause, resume, cancel or stop concerns the run; a restore concerns the action that runs when it is
    requested. A request may also name an action. If that action has not begun or is over, the request is
    rejected or dropped; it never concerns another action.
    """

    def __init__(
        self, robot: Robot, life: RunLife, on_stop: Callable[[str, float], None] = lambda cause, asked: None
    ) -> None:
        """Begin without a request; `on_stop` is called with the reason and the time in [s] of each stop."""
        self._requests: deque[PendingRequest] = deque()
        self._stop: tuple[Request, float] | None = None  # waits in no queue
        self._robot = robot
        self._life = life
        self._on_stop = on_stop
        self._after_restoring: Request | None = None
        self._latest = 0
        self.running: int | None = None
        """Number of the action that runs, from 1; None between two of them."""
        self.unapplied: deque[str] = deque(maxlen=MAX_UNAPPLIED)
        """Requests that were taken and not applied, because their action was over, in words."""

    def ask(self, request: Request, number: int | None = None) -> str:
        """Accept or reject an operator's request, which is followed in the next control period if accepted.

        The method may be called in a signal handler.

        Args:
            request: the request. A stop is always accepted, and precedes all other requests.
            number: number of the action that the request concerns, from 1. None: the request concerns the
                run, or, if it is to restore, the action that runs now.

        Returns:
            The reason in words if the request is rejected; empty if it is accepted.
        """
        if request in _STOPS:
            self._stop = self._stop or (request, self._robot.time)
            return ""
        if wrong := self._misaddressed(request, number):
            return wrong
        if len(self._requests) >= MAX_REQUESTS:
            return "too much is asked for at once; allowed: to wait until it is done, and to stop"
        meant = self.running if request is Request.RESTORE else number
        self._requests.append(PendingRequest(request, self._robot.time, meant))
        return ""

    def _misaddressed(self, request: Request, number: int | None) -> str:
        """Return why a request cannot be meant for what is done now; empty if it can."""
        state, running = self._life.state, self.running
        if state is RunState.ENDED:
            return "the run is over; allowed: while it runs"
        if number is not None and number != running:
            allowed = "an action that runs; none does now" if running is None else f"{running}, which runs"
            was = "is over" if number <= self._latest else "has not begun"
            return f"action {number} {was}; allowed: {allowed}"
        if request is Request.RESTORE and running is None:
            return "no action runs, so there is nothing to restore; allowed: while one runs"
        if request is Request.RESTORE and state in (RunState.RESTORING, RunState.PAUSED_WHILE_RESTORING):
            return f"action {running} is being restored already; allowed: once"
        pauses = self._life.paused or any(
            pending_request.what is Request.PAUSE for pending_request in self._requests
        )
        return "nothing is paused; allowed: after a pause" if request is Request.RESUME and not pauses else ""

    def begins(self, number: int) -> None:
        """Note that an action starts: from now on, requests may refer to its number."""
        self.running = self._latest = number

    def to_its_end(
        self, attempt: Attempt, time_out: float | None = None, late: str = ""
    ) -> Generator[None, None, Outcome]:
        """Run the attempt of an action, one control period for each `yield`, and return its outcome.

        Args:
            attempt: the attempt.
            time_out: time in [s] after which the attempt is called back; None: never.
            late: message of the Fail after `time_out`; "" for the message "it took longer than ... s".

        Raises:
            Interrupted: the attempt was stopped; the robot holds where it is.
        """
        latest = math.inf if time_out is None else self._robot.time + time_out
        try:
            next(attempt)
            while True:
                yield
                while (wanted := self._next()) is not None:
                    outcome = yield from self._honour(wanted.what, wanted.time, attempt)
                    if outcome is not None:
                        return outcome
                if self._robot.time > latest and self._life.state is RunState.ACTING:
                    words = late or f"it took longer than {time_out:g} s"
                    outcome = yield from _call_back(attempt, Discrepancy(words, cause=causes.TIME_OUT))
                    if outcome is not None:
                        return outcome
                next(attempt)
        except StopIteration as end:
            ended: Outcome = end.value
            return ended
        finally:
            self.running = None

    def between_actions(self) -> None:
        """Follow requests while no action runs; a requested pause waits until the next action has started.

        Raises:
            Interrupted: the end of the run was requested; the robot was commanded to stop.
        """
        if self._after_restoring is not None:
            raise Interrupted(_ENDING[self._after_restoring])
        if self._stop is None and not self._requests:
            return
        self._drop_late()
        stop = [] if self._stop is None else [self._stop]
        waiting = [(pending_request.what, pending_request.time) for pending_request in self._requests]
        for request, asked in [*stop, *waiting]:
            if request in _ENDING:
                self._robot.stop()
                self._on_stop(_ENDING[request], asked)
                raise Interrupted(_ENDING[request])

    def _next(self) -> PendingRequest | None:
        if self._stop is not None:
            return PendingRequest(*self._stop, None)
        self._drop_late()
        return self._requests.popleft() if self._requests else None

    def _drop_late(self) -> None:
        """Drop the requests that are meant for an action that is over; a signal only adds stops."""
        for request in [
            pending_request
            for pending_request in self._requests
            if pending_request.number not in (None, self.running)
        ]:
            self._requests.remove(request)
            words = f"{request.what.value} of action {request.number}, asked for at {request.time:.3f} s"
            self.unapplied.append(f"{words}: that action was over")

    def _honour(self, request: Request, asked: float, attempt: Attempt) -> Periods:
        if request in _STOPS:
            self._robot.stop()  # stop first; closing the attempt may take time
            attempt.close()
            self._robot.stop()
            self._on_stop(_ENDING[request], asked)
            yield from come_to_rest(self._robot)
            raise Interrupted(_ENDING[request])
        if request is Request.PAUSE:
            return (yield from self._pause(attempt))
        if request is Request.PREEMPT and self._life.state is RunState.ACTING:
            urgent = Discrepancy("something more urgent came first", cause=causes.PREEMPTED)
            return (yield from _call_back(attempt, urgent))
        if request is Request.CANCEL:
            self._after_restoring = request
        if request in (Request.CANCEL, Request.RESTORE) and self._life.state is RunState.ACTING:
            return (
                yield from _call_back(
                    attempt, Discrepancy(_ENDING.get(request, "interrupted"), cause=causes.CANCELLED)
                )
            )
        return None

    def _pause(self, attempt: Attempt) -> Periods:
        """Hold until another request comes; a robot moved by hand meanwhile is a discrepancy."""
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
        off = Residuals()
        if stood is not None:
            off = residuals(stood, take_snapshot(self._robot, {}), self._robot.spec).moved
        if off and self._life.state is RunState.ACTING:
            return (
                yield from _call_back(
                    attempt, Discrepancy(f"moved during a pause: {off.words}", cause=causes.DISPLACED)
                )
            )
        return None

    def _called(self) -> bool:
        """Return whether any request other than a further pause waits."""
        while self._requests and self._requests[0].what is Request.PAUSE:
            self._requests.popleft()
        return self._stop is not None or bool(self._requests)


def come_to_rest(robot: Robot) -> Generator[None, None, None]:
    """Wait, one control period for each `yield`, until base, arm and gripper are at rest by their readings.

    After a time-out or an error the wait ends without raising anything.
    """
    with suppress(Exception):  # the run ends with an error of its own; a second one would hide it
        yield from settle(robot)


def _call_back(attempt: Attempt, discrepancy: Discrepancy) -> Periods:
    discrepancy.check = CHECK_NAME
    try:
        attempt.throw(discrepancy)
    except StopIteration as end:
        ended: Outcome = end.value
        return ended
    yield
    return None
