"""The coordinator: plans, runs one primitive at a time, and plans again after a Fail."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import suppress

from handcart.backends.robot.robot import Robot
from handcart.networks.deciding.planners import planner_of
from handcart.networks.events.events import Event
from handcart.networks.events.run_end import RunEnd, RunOutcome
from handcart.networks.graph.network import Action, ActionNetwork, NotBound
from handcart.networks.graph.planner import NoWay, Plan, Planner
from handcart.networks.graph.route import Elsewhere, NotStarted, RunDecisions
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.measured import measure
from handcart.networks.journal.retracing import RunPosition
from handcart.networks.journal.run_log import Keep, RunLog
from handcart.networks.journal.run_records import Aim
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.contract.attempt import attempt, pushed_reason
from handcart.primitives.contract.unmet import find_unmet
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Outcome, Success
from handcart.primitives.restoring.snapshot import Snapshot, residuals

from .aim_watch import aim_watch
from .day_clock import DayClock
from .run_life import RunLife
from .supervision import Interrupted, Request, Supervision
from .world_watch import WorldWatch

Permission = Callable[[Action], bool | None]
"""Called once a period before an action starts: returns yes, no, or None while no answer has come."""


class Coordinator:
    """Executor of one run through an action network, independent of the robot's kind.

    The caller iterates the generator that `run` returns and, after each `yield`, steps the robot by one
    period; while `life.paused` is true, the robot's time does not pass. Every decision is written to the
    journal before it is acted on. Actions that failed, were refused or could not be started are counted.
    These counts never decrease, except when a new round of a repeated task begins, so that every round ends
    within `network.bound()` actions; a task that is not repeated is one round.
    """

    def __init__(
        self,
        network: ActionNetwork,
        robot: Robot,
        model: WorldModel,
        journal: Journal | None = None,
        observers: Sequence[Callable[[Event], None]] = (),
        permission: Permission | None = None,
        standing: RunPosition | None = None,
        keep: Keep | None = None,
        clock: DayClock | None = None,
    ) -> None:
        """Create a coordinator; nothing is planned or moved before `run` is iterated.

        Args:
            network: the network of the task.
            robot: the robot, at rest in the network's start.
            model: the robot's world model.
            journal: journal of all decisions; None: no journal.
            observers: called with each event, in order.
            permission: asked before each action; None: actions that need the operator's permission do not
                start.
            standing: position of a run that is resumed; None: a new run.
            keep: called after each action to keep a checkpoint; None: no checkpoints.
            clock: clock of the aims' times of day; None: a rehearsed day that begins at the first of them.
        """
        self.network = network
        self._left = "" if standing is None else standing.left
        self._route = RunDecisions(network, planner_of(network)) if standing is None else standing.route
        self.life = RunLife()
        self.asks: Action | None = None
        """The action that waits for permission."""
        self._robot = robot
        self._model = model
        self._log = RunLog(robot, model, journal, observers, standing, keep)
        self._supervision = Supervision(robot, self.life, self._log.stopped)
        self._watch = WorldWatch(robot, network, standing.seen if standing else {})
        self._permission = permission
        self._cause = standing.cause if standing else ""
        self._aims = aim_watch(robot, network, standing, clock)

    def request(self, what: Request, number: int | None = None) -> bool:
        """Make a request to the run as `ask` does, and return whether it was accepted."""
        return not self.ask(what, number)

    def ask(self, what: Request, number: int | None = None) -> str:
        """Make a request to the run, such as a pause or a stop, which it follows in its next period.

        It may be called in a signal handler.

        Args:
            what: the request. A stop is always accepted, and precedes all other requests.
            number: number of the action that is meant, as `running` gives it; None: the run, or for a restore
                the action that runs now.

        Returns:
            The reason in words if the request is rejected: the action is over or has not begun, or too many
            requests wait; empty if it is accepted.
        """
        return self._supervision.ask(what, number)

    @property
    def acting(self) -> int | None:
        """Number of the running action, from 1; None between two actions."""
        return self._supervision.running

    @property
    def unapplied(self) -> Sequence[str]:
        """Descriptions of accepted requests that were not applied because their action had ended."""
        return tuple(self._supervision.unapplied)

    @property
    def situation(self) -> str:
        """Last situation that is known to hold; during an action, the one in which the action started."""
        return self._route.situation

    @property
    def planner(self) -> Planner:
        """Planner of the run's routes, with the Fails of each action and the excluded actions."""
        return self._route.planner

    @property
    def running(self) -> int:
        """Number of the action that was started last, from 1; 0 before the first."""
        return self._log.started

    def run(self) -> Generator[None, None, RunEnd]:
        """Execute the run, one control period for each `yield`, and return how it ended.

        The run goes from the start to the goal, or to a situation in which no action is left to try.
        """
        try:
            end = yield from self._pursue()
        except Interrupted as interrupted:
            self.asks = None
            end = self._end("Cancelled", interrupted.reason)
        self.life.end()
        self._log.ended(end, measure(self._robot))
        while not self._log.kept:
            yield
        return end

    def _pursue(self) -> Generator[None, None, RunEnd]:
        if self._left:
            self._forget(self._left)
        if self._aims.is_early() and (expected := self._aims.expected):
            words = f"round {self._route.round} begins at {expected[1]}"
            here, number, at = self.situation, self._route.round, round(expected[0], 6)
            self._log.aims_at(words, Aim(what="wait", situation=here, round=number, at_s=at))
        while (end := (yield from self._reach())) is None:
            self._begin_next_round()
        return end

    def _reach(self) -> Generator[None, None, RunEnd | None]:
        """Run until the pursued situation is reached; return the run's end, None if another round follows."""
        while not self._route.arrived:
            self._supervision.between_actions()
            self._look_at_aims()
            waits = self._aims.waits(self.situation)
            if waits and self._route.priority is None:
                yield
                continue
            if not self._route.planned:
                plan = self._plan()
                if isinstance(plan, GiveUp):
                    return self._end("GiveUp", plan.reason)
                if isinstance(plan, NoWay):
                    return self._end("GiveUp" if plan.calls_person else "Fail", plan.explanation)
                if self._route.arrived:
                    break
                if waits and self._route.priority is None:
                    continue  # an interrupt is abandoned, because no route leads on
            action, left = self._route.next, self.situation
            outcome = yield from self._carry_out(action)
            if isinstance(outcome, GiveUp):
                self._cause = outcome.cause.name
                return self._end("GiveUp", f"{action}: {outcome.reason}")
            if outcome is not None:
                self._take(outcome)
                self._forget(left)
        self._supervision.between_actions()
        return None if self._route.has_next_round else self._arrived()

    def _take(self, outcome: Success | Fail | NotStarted) -> None:
        """Count the outcome of an action, and note the situation that it leads to."""
        if not isinstance(outcome, Success):
            cause = outcome.cause if isinstance(outcome, NotStarted) else outcome.cause.name
            if cause != causes.PREEMPTED.name:
                self._cause, self._log.fails = cause, self._log.fails + 1
        self._route.took(outcome)
        self._watch.arrived(self.situation)

    def _arrived(self) -> RunEnd:
        """Return the end of a run that has reached its last pursued situation."""
        if self._route.unfinished:
            rounds = [*self._route.unfinished, *([self._route.round] if self._route.lost else [])]
            return self._end("Fail", f"rounds left undone: {', '.join(map(str, rounds))}")
        if self._route.lost is not None:
            reason = f"{self._route.lost.explanation}; otherwise: {self.situation} is reached"
            return self._end("Fail", reason, self.situation)
        skipped = self._log.skipped
        if skipped:
            return self._end("Fail", f"left undone: {', '.join(skipped)}")
        return self._end("Success", "")

    def _look_at_aims(self) -> None:
        """Abandon the goal when its time is over, and begin an interrupt that is due."""
        route, left = self._route, self._aims.left_s
        if left is not None and left <= 0.0 and route.lost is None:
            reason = f"the task took longer than {self.network.aims.time_out_s:g} s"
            self._log.aims_at(reason, Aim(what="abandon", situation=self.situation, reason=reason))
            route.abandon(reason)
        if not self.network.aims.interrupts or route.lost is not None:
            return
        number = self._aims.due(route.priority, self.situation)
        if number is not None:
            self._interrupt(number)

    def _interrupt(self, number: int) -> None:
        here, name = self.situation, self.network.aims.interrupts[number].name
        goal = self._route.interrupt(number)
        record = Aim(what="interrupt", situation=here, interrupt=number)
        if goal:
            record["goal"] = goal
        words = f"first to {goal}" if goal else "it is there already, or no route leads there"
        self._log.aims_at(f"{name}: {words}", record)

    def _begin_next_round(self) -> None:
        """Begin the next round, which waits until it is due."""
        here, at = self.situation, self._aims.begin_round(self._route.missed)
        self._route.begin_round()
        number, expected = self._route.round, self._aims.expected
        record = Aim(what="round", situation=here, round=number, at_s=round(at, 6))
        self._log.aims_at(f"round {number} begins at {expected[1] if expected else f'{at:.1f} s'}", record)
        self._forget(here)

    def _plan(self) -> Plan | NoWay | GiveUp:
        self.life.plan()
        try:
            plan = self._route.plan()
        except Exception as error:  # a fault in planning: the next action is unknown (row N10)
            self._robot.stop()
            self._log.not_planned(self.situation, error)
            return GiveUp(f"planning failed: {type(error).__name__}: {error}")
        self._log.planned(self.situation, plan)
        return plan

    def _forget(self, left: str) -> None:
        """Forget facts learned for an element of a repeat when the run leaves it; they stay while it is in a
        nested element.
        """
        situations = self.network.situations
        element, here = situations[left].element, situations[self.situation].element or ""
        if element is not None and here != element and not here.startswith(f"{element}, "):
            self._model.clear_element()

    def _carry_out(self, action: Action) -> Generator[None, None, Outcome | NotStarted | None]:
        """Carry out an action, and return its outcome; None if the run has another aim before it starts."""
        if action.binding is None:
            element = self.network.situations[action.source].element or action.source
            self._log.skip(action, element)
            return Success()
        ask = self._permission
        permitted = not action.permit if ask is None else (yield from self._permitted(action, ask))
        if permitted is None:
            return None
        if not permitted:
            return self._log.not_started(action, "permission was refused", causes.REFUSED.name)
        try:
            primitive = action.binding.make(self._model)
        except NotBound as unknown:
            return self._log.not_started(action, str(unknown), causes.NOT_KNOWN.name)
        return (yield from self._act(action, primitive))

    def _permitted(self, action: Action, permission: Permission) -> Generator[None, None, bool | None]:
        """Return whether an action may start; None if the run has another aim before an answer comes."""
        while (answer := permission(action)) is None:
            self.life.ask()
            self.asks = action
            yield
            self._supervision.between_actions()
            self._look_at_aims()
            if not self._route.planned:
                break
        self.asks = None
        if answer is None:
            self.life.plan()
        return answer

    def _act(self, action: Action, primitive: ActionPrimitive) -> Generator[None, None, Outcome | NotStarted]:
        log, moves = self._log, not primitive.only_knowledge
        at = measure(self._robot) if moves else None
        if at is not None and (stood := self._watch.changed(at)):
            return self._world_changed(action, stood, at)
        if at is not None and self._robot.localization.lifted is not None and primitive.needs_pose:
            return self._lifted(action, at)
        if unmet := self._unmet_precondition(primitive):
            return log.not_started(action, unmet, causes.PRECONDITION.name)
        self._watch.begins(self.situation, at)
        self.life.act()
        self._supervision.between_actions()  # a request since the last check: then the action does not start
        self._supervision.begins(log.started + 1)
        log.start(action, primitive, self.planner.fails(action), at)
        periods = attempt(
            primitive,
            self._robot,
            self._model,
            lambda why: self._restore(action, why),
            log,
            self.network.restoring,
            is_checked=True,
        )
        limit, words = self._limit(action)
        outcome = yield from self._supervision.to_its_end(periods, limit, words)
        if moves:
            at = measure(self._robot)
            self._watch.stands(at)
        log.result(primitive, outcome, at)
        try:
            while not log.kept:
                yield
                self._supervision.between_actions()
        except Interrupted:  # the action has ended all the same
            log.result_told(action, primitive, outcome)
            if isinstance(outcome, GiveUp):
                return outcome
            self._take(outcome)
            raise
        log.result_kept(action, primitive, outcome)
        return outcome

    def _limit(self, action: Action) -> tuple[float | None, str]:
        """Return the time that an action may take, in [s], and the message if it takes longer."""
        left, own = self._aims.left_s, action.time_out_s
        if left is None or self._route.lost is not None or (own is not None and own <= left):
            return own, "" if own is None else f"it took longer than {own:g} s"
        return left, f"the task took longer than {self.network.aims.time_out_s:g} s"

    def _unmet_precondition(self, primitive: ActionPrimitive) -> str:
        """Return the precondition that prevents the start; empty if all are met (row N7)."""
        try:
            return find_unmet(primitive, self._robot, self._model)
        except Exception as error:  # a fault of the primitive's own code
            return f"{type(error).__name__}: {error}"

    def _world_changed(self, action: Action, stood: Snapshot, now: Snapshot) -> GiveUp | Elsewhere:
        """Continue from the situation found after a change of the world, or give up (row N9)."""
        reason = f"somebody changed the world: {residuals(stood, now, self._robot.spec).moved.words}"
        situation = self._watch.situation(self.situation, stood, now)
        self._log.world_changed(action, stood, now, situation, reason)
        if situation is None:
            self._robot.stop()
            return GiveUp(reason)
        self._watch.stands(now)
        return Elsewhere(reason, situation)

    def _lifted(self, action: Action, now: Snapshot) -> GiveUp | Elsewhere:
        """Continue where LOCATE can find a robot that was lifted between two actions, or give up."""
        self._robot.stop()
        reason = pushed_reason(self._robot)
        situation = self._watch.unlocated_situation(self.situation)
        self._log.world_changed(action, now, now, situation, reason)
        if situation is None:
            return GiveUp(reason)
        self._watch.stands(now)
        return Elsewhere(reason, situation)

    def _restore(self, action: Action, reason: str) -> None:
        self.life.restore()
        self._log.restoring(action, reason)

    def broken_off(self, reason: str, outcome: RunOutcome = "Error") -> RunEnd:
        """Write to the journal that a fault has broken off the run, and return this end of the run.

        The robot must have been stopped before. `outcome` is Error for a fault of the program or of the
        journal, and GiveUp for a fault of the robot.
        """
        if self._log.open and outcome == "Error":
            reason = f"{reason}; how action {self.running} ended is not in the journal for good"
        end = self._end(outcome, reason)
        with suppress(Exception):  # the cause that ended the run may end this, too
            self._log.stopped(reason, self._robot.time)
            self._log.ended(end, measure(self._robot))
        return end

    def _end(self, outcome: RunOutcome, reason: str, otherwise: str = "") -> RunEnd:
        log = self._log
        replans = max(0, log.plans - 1)
        counts = log.started, log.fails, replans, tuple(log.skipped)
        cause = "" if outcome == "Success" else self._cause
        return RunEnd(outcome, self.situation, reason, *counts, cause, otherwise, self._route.round)
