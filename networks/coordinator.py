"""The coordinator: plans, runs one primitive at a time, and plans again after a Fail."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from backends.robot import Robot
from primitives.action_primitive import ActionPrimitive
from primitives.attempt import attempt
from primitives.outcome import Fail, GiveUp, Outcome, Success
from primitives.world_model import WorldModel

from .binding import NotBound
from .chronicle import Chronicle
from .events import NotStarted, Observer
from .journal import Journal
from .network import Action, ActionNetwork
from .planner import NoWay, Planner
from .run_end import RunEnd, RunOutcome
from .run_life import RunLife
from .supervision import Interrupted, Request, Supervision

Permission = Callable[[Action], bool | None]
"""Asked once a period before an action starts: yes, no, or None while nobody has answered."""


class Coordinator:
    """One run through an action network, as a generator of periods; it knows no robot.

    Who iterates steps the robot after each `yield` (time standing still while `life.paused`). Everything is
    in the journal before it is acted on. What failed, was refused or could not be started is counted, and
    counts never go down, so that every run ends within `network.bound()` actions.
    """

    def __init__(
        self,
        network: ActionNetwork,
        robot: Robot,
        model: WorldModel,
        journal: Journal | None = None,
        observers: Sequence[Observer] = (),
        permission: Permission | None = None,
    ) -> None:
        """Nothing is planned or moved before `run` is iterated.

        Args:
            network: what can be done.
            robot: at rest in the network's start.
            model: what the robot knows.
            journal: what is decided is written there; None: nowhere.
            observers: called with each event, in order.
            permission: who has to permit each action; None: nobody.
        """
        self.network = network
        self.situation = network.start
        self.planner = Planner(network)
        self.life = RunLife()
        self._robot = robot
        self._model = model
        self._chronicle = Chronicle(robot, model, journal, observers)
        self._supervision = Supervision(robot, self.life)
        self._permission = permission
        self._ahead: list[Action] = []

    def request(self, what: Request) -> None:
        """Ask for a pause, a stop and so on; honoured at the next period. Safe in a signal handler."""
        self._supervision.requests.append(what)

    @property
    def running(self) -> int:
        """Number of the action that was started last, from 1; 0 before the first."""
        return self._chronicle.started

    def run(self) -> Generator[None, None, RunEnd]:
        """From the start to the goal, or to where nothing leads on."""
        try:
            end = yield from self._pursue()
        except Interrupted as interrupted:
            end = self._end("Cancelled", interrupted.reason)
        self.life.end()
        self._chronicle.ended(end)
        return end

    def _pursue(self) -> Generator[None, None, RunEnd]:
        # Paper 003, section 2.6
        while self.situation != self.network.goal:
            action = self._next()
            if isinstance(action, NoWay):
                return self._end("Fail", action.explanation)
            outcome = yield from self._carry_out(action)
            match outcome:
                case Success():
                    self._ahead.pop()
                    self._enter(action.target)
                case Fail(reason, permanent):
                    self._count(action, reason, permanent)
                case NotStarted(reason):
                    self._count(action, reason, False)
                case GiveUp(reason):
                    return self._end("GiveUp", f"{action}: {reason}")
            self._supervision.between_actions()
        skipped = self._chronicle.skipped
        if skipped:
            return self._end("Fail", f"left undone: {', '.join(skipped)}")
        return self._end("Success", "")

    def _next(self) -> Action | NoWay:
        """The action to do now: the rest of a plan stays the cheapest while nothing fails."""
        if not self._ahead:
            self.life.plan()
            plan = self.planner.plan(self.situation)
            self._chronicle.planned(self.situation, plan)
            if isinstance(plan, NoWay):
                return plan
            self._ahead = list(reversed(plan.actions))
        return self._ahead[-1]

    def _count(self, action: Action, reason: str, permanent: bool) -> None:
        self.planner.failed(action, reason, permanent=permanent)
        self._chronicle.fails += 1
        self._ahead = []
        self._enter(action.on_fail or self.situation)

    def _enter(self, situation: str) -> None:
        left = self.network.situations[self.situation].element
        if left is not None and self.network.situations[situation].element != left:
            self._model.clear_element()
        self.situation = situation

    def _carry_out(self, action: Action) -> Generator[None, None, Outcome | NotStarted]:
        if action.binding is None:
            element = self.network.situations[action.source].element or action.source
            self._chronicle.skip(action, element)
            return Success()
        if self._permission is not None and not (yield from self._permitted(action, self._permission)):
            return self._chronicle.not_started(action, "permission was refused")
        try:
            primitive = action.binding.make(self._model)
        except NotBound as unknown:
            return self._chronicle.not_started(action, str(unknown))
        return (yield from self._act(action, primitive))

    def _permitted(self, action: Action, permission: Permission) -> Generator[None, None, bool]:
        self.life.ask()
        while (answer := permission(action)) is None:
            yield
            self._supervision.between_actions()
        return answer

    def _act(self, action: Action, primitive: ActionPrimitive) -> Generator[None, None, Outcome | NotStarted]:
        self.life.act()
        self._chronicle.start(action, primitive, self.planner.fails(action))
        periods = attempt(primitive, self._robot, self._model, lambda why: self._restore(action, why))
        outcome = yield from self._supervision.to_its_end(periods)
        if isinstance(outcome, NotStarted):
            return self._chronicle.not_started(action, outcome.reason)
        self._chronicle.result(action, primitive, outcome)
        return outcome

    def _restore(self, action: Action, reason: str) -> None:
        self.life.restore()
        self._chronicle.restoring(action, reason)

    def broken_off(self, reason: str) -> RunEnd:
        """The end of a run that a fault in our own code or the journal broke off."""
        return self._end("Error", reason)

    def _end(self, outcome: RunOutcome, reason: str) -> RunEnd:
        told = self._chronicle
        replans = max(0, told.plans - 1)
        return RunEnd(outcome, self.situation, reason, told.started, told.fails, replans, tuple(told.skipped))
