"""The coordinator: plans, runs one primitive at a time, and plans again after a Fail."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from backends.robot import Robot
from primitives.action_primitive import ActionPrimitive
from primitives.attempt import attempt
from primitives.outcome import GiveUp, Outcome, Success
from primitives.world_model import WorldModel

from .binding import NotBound
from .chronicle import Chronicle, Keep
from .events import NotStarted, Observer
from .journal import Journal
from .network import Action, ActionNetwork
from .planner import NoWay, Planner
from .retracing import Standing
from .route import Route
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
        standing: Standing | None = None,
        keep: Keep | None = None,
    ) -> None:
        """Nothing is planned or moved before `run` is iterated.

        Args:
            network: what can be done.
            robot: at rest in the network's start.
            model: what the robot knows.
            journal: what is decided is written there; None: nowhere.
            observers: called with each event, in order.
            permission: asked before each action; None: those that need the operator's permission don't start.
            standing: where a run that goes on stands; None: it begins.
            keep: keeps a checkpoint after each action; None: nobody does.
        """
        self.network = network
        self._left = "" if standing is None else standing.left
        self._route = Route(network) if standing is None else standing.route
        self.life = RunLife()
        self.asks: Action | None = None
        """The action that waits for permission."""
        self._robot = robot
        self._model = model
        self._chronicle = Chronicle(robot, model, journal, observers, standing, keep)
        self._supervision = Supervision(robot, self.life)
        self._permission = permission

    def request(self, what: Request) -> None:
        """Ask for a pause, a stop and so on; honoured at the next period. Safe in a signal handler."""
        self._supervision.requests.append(what)

    @property
    def situation(self) -> str:
        """The last that is known to hold."""
        return self._route.situation

    @property
    def planner(self) -> Planner:
        """What has failed how often, and what is out."""
        return self._route.planner

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
        if self._left:
            self._forget(self._left)
        while not self._route.arrived:
            if not self._route.planned:
                self.life.plan()
                plan = self._route.plan()
                self._chronicle.planned(self.situation, plan)
                if isinstance(plan, NoWay):
                    return self._end("Fail", plan.explanation)
            action, left = self._route.next, self.situation
            outcome = yield from self._carry_out(action)
            if isinstance(outcome, GiveUp):
                return self._end("GiveUp", f"{action}: {outcome.reason}")
            if not isinstance(outcome, Success):
                self._chronicle.fails += 1
            self._route.took(outcome)
            self._forget(left)
            self._supervision.between_actions()
        skipped = self._chronicle.skipped
        if skipped:
            return self._end("Fail", f"left undone: {', '.join(skipped)}")
        return self._end("Success", "")

    def _forget(self, left: str) -> None:
        """What was learned for an element of a repeat, once it is left."""
        situations = self.network.situations
        element = situations[left].element
        if element is not None and situations[self.situation].element != element:
            self._model.clear_element()

    def _carry_out(self, action: Action) -> Generator[None, None, Outcome | NotStarted]:
        if action.binding is None:
            element = self.network.situations[action.source].element or action.source
            self._chronicle.skip(action, element)
            return Success()
        if not (yield from self._permitted(action)):
            return self._chronicle.not_started(action, "permission was refused")
        try:
            primitive = action.binding.make(self._model)
        except NotBound as unknown:
            return self._chronicle.not_started(action, str(unknown))
        return (yield from self._act(action, primitive))

    def _permitted(self, action: Action) -> Generator[None, None, bool]:
        if self._permission is None:
            return not action.permit
        while (answer := self._permission(action)) is None:
            self.life.ask()
            self.asks = action
            yield
            self._supervision.between_actions()
        self.asks = None
        return answer

    def _act(self, action: Action, primitive: ActionPrimitive) -> Generator[None, None, Outcome | NotStarted]:
        self.life.act()
        self._chronicle.start(action, primitive, self.planner.fails(action))
        periods = attempt(primitive, self._robot, self._model, lambda why: self._restore(action, why))
        outcome = yield from self._supervision.to_its_end(periods, action.time_out_s)
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
