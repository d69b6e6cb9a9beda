"""An attempt that is under way, and what must be true when it has ended."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, field

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.rig.periods import SETTLING_PERIODS, steps
from handcart.evaluation.conformance.rig.standing import TrueState
from handcart.evaluation.judging.survey import SurveyedRun, simulated_world
from handcart.evaluation.judging.surveys import Surveys
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.contract.attempt import LONGEST_RESTORE, attempt
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Outcome, Success

from .fault import HARMLESS_FAULTS, Fault, FaultKind
from .faulty_backend import FaultyBackend

QUIET_TIME_S = 2.0  # [s] in which nothing may move after the end
MAX_TIME_AFTER_FAULT_S = 2 * LONGEST_RESTORE  # [s] of the robot's time that an attempt gets after the fault


class Endless(Exception):
    """Exception for an attempt that does not end within its limit of periods."""


@dataclass(frozen=True)
class AttemptEnding:
    """Outcome of a primitive's attempt with an injected fault, and the claims of this outcome that the ground
    truth contradicts.
    """

    outcome: str
    """Success, Fail or GiveUp; Error where an exception came through."""
    reason: str
    periods: int
    """Number of periods from the call of `Underway.finish` to the end."""
    bitten: bool = True
    """True if the fault changed anything."""
    wrong: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()
    """Sensors that were read."""
    cause: str = ""
    """Kind of cause of a Fail or GiveUp."""


@dataclass
class Underway:
    """An attempt of a primitive in progress, on a robot whose backend can inject faults."""

    primitive: ActionPrimitive
    robot: Robot
    backend: FaultyBackend
    model: WorldModel
    spec: RobotFile
    """Original robot file, unmodified."""
    seed: int = 0
    """Seed of the simulated errors."""
    periods: Generator[None, None, Outcome] = field(init=False)
    surveys: Surveys = field(init=False)
    _bumps: int | None = field(default=None, init=False)
    """Number of the base's bumps before restoring."""
    _no_return: bool = field(default=False, init=False)
    """True if a point of no return was declared, even if it was withdrawn."""

    def __post_init__(self) -> None:
        does = frozenset({self.primitive.label()})
        world = simulated_world(self.backend)
        self.surveys = Surveys(SurveyedRun(self.robot, self.spec, self.model, world, self.seed, does))
        self.surveys.started(1, self.primitive)
        self.periods = attempt(self.primitive, self.robot, self.model, self._restores)

    def _restores(self, reason: str) -> None:
        truth = self.backend.ground_truth()
        self._bumps = truth.bumps if truth else None

    def _step(self) -> None:
        self._no_return |= self.primitive._no_return is not None
        self.backend.asked = False
        self.robot.step()
        self.surveys.look(self.robot)
        self.backend.asked = True

    def advance(self) -> Outcome | None:
        """Execute one control period of the attempt; return its outcome if it has ended, otherwise None."""
        try:
            next(self.periods)
        except StopIteration as end:
            outcome: Outcome = end.value
            return outcome
        self._step()
        return None

    def finish(self, fault: Fault | None = None) -> AttemptEnding:
        """Inject a fault (None: no fault), run the attempt to its end, and compare its outcome with the
        ground truth.
        """
        count = [0]
        try:
            outcome = self._to_the_end(fault, count)
        except Endless:
            return self._ended(
                "none", f"no end after {MAX_TIME_AFTER_FAULT_S:.0f} s", count[0], ("it doesn't end",)
            )
        except Exception as error:
            message = f"{type(error).__name__}: {error}"
            return self._ended("Error", message, count[0], (f"an exception came through: {message}",))
        if not isinstance(outcome, Success | Fail | GiveUp):
            return self._ended(str(outcome), "", count[0], (f"{outcome!r} is no outcome",))
        wrong = self._untrue(outcome)
        if isinstance(outcome, GiveUp) and self._whole(fault):
            wrong.append("it gave up, although the robot is whole and nothing was done for good")
        reason = "" if isinstance(outcome, Success) else outcome.reason
        cause = "" if isinstance(outcome, Success) else outcome.cause.name
        return self._ended(type(outcome).__name__, reason, count[0], tuple(wrong), cause)

    def _ended(
        self, outcome: str, reason: str, periods: int, wrong: tuple[str, ...], cause: str = ""
    ) -> AttemptEnding:
        bitten = bool(self.backend.bitten)
        return AttemptEnding(outcome, reason, periods, bitten, wrong, self.backend.sensors_read, cause)

    def _to_the_end(self, fault: Fault | None, count: list[int]) -> Outcome:
        if fault is not None:
            self.backend.inject(fault)
        error = _thrown(fault)
        end = self.robot.time + MAX_TIME_AFTER_FAULT_S
        if error is not None:
            self.backend.bitten += 1
            try:
                self.periods.throw(error)
            except StopIteration as ended:
                outcome: Outcome = ended.value
                return outcome
            self._step()
        while self.robot.time < end:
            count[0] += 1
            found = self.advance()
            if found is not None:
                return found
        raise Endless

    def _untrue(self, outcome: Outcome) -> list[str]:
        after = self.backend.ground_truth()
        wrong = []
        if isinstance(outcome, Fail) and self._no_return:
            wrong.append("Fail after a point of no return")
        word = type(outcome).__name__
        untrue = self.surveys.ended(1, self.primitive, outcome)
        wrong += [f"{word}, but {item}" for item in untrue]
        bumps = 0 if self._bumps is None or after is None else after.bumps - self._bumps
        if isinstance(outcome, Fail) and bumps > 0:
            wrong.append("the base ran into something while it was restored")
        wrong += self.surveys.broken
        return wrong + self._unquiet(outcome)

    def _unquiet(self, outcome: Outcome) -> list[str]:
        """Return the parts that move although the attempt has ended."""
        if self.backend.stay():
            steps(self.backend, SETTLING_PERIODS)  # a slide of the kit's own that a drive brakes
        ended = TrueState.of(self.backend.inner)
        for _ in range(round(QUIET_TIME_S / self.robot.period)):
            self.backend.step()
        word = type(outcome).__name__
        moving = ended.moved(TrueState.of(self.backend.inner))
        return [f"after {word} it doesn't stand still: {item}" for item in moving]

    def _whole(self, fault: Fault | None) -> bool:
        return not self._no_return and (fault is None or fault.kind in HARMLESS_FAULTS)


def _thrown(fault: Fault | None) -> Exception | None:
    """Return the exception by which a fault ends an attempt from outside, such as a cancel; None for other
    faults.
    """
    if fault is not None and fault.kind is FaultKind.CANCEL:
        return Discrepancy("cancelled by request", cause=causes.CANCELLED)
    if fault is not None and fault.kind is FaultKind.TIME_OUT:
        return TimeoutError("it takes too long")
    return None
