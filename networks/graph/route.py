"""Position of a run in its network, and its next actions."""

from __future__ import annotations

from dataclasses import dataclass, field

from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, Outcome, Success

from .network import Action, ActionNetwork
from .planner import NoWay, Plan, Planner


@dataclass(frozen=True)
class NotStarted:
    """Result of an action that could not be started, because it was refused or a parameter is not known.

    It counts as a Fail.
    """

    reason: str
    cause: str = field(default="", kw_only=True)
    """Name of the cause's kind, which may decide the situation; empty if it has none."""


@dataclass(frozen=True)
class Elsewhere(NotStarted):
    """Result for an action that is not started because somebody changed the world, with the new situation."""

    situation: str


class RunDecisions:
    """Decisions of a run (next action, situation, goal), which depend only on the outcomes of its actions.

    The run follows a planned route, and plans again after each Fail, from the situation that the Fail leads
    to.

    The outcomes may be real or scripted.
    """

    def __init__(self, network: ActionNetwork, planner: Planner | None = None) -> None:
        """Begin at the network's start, with nothing planned.

        Args:
            network: the network.
            planner: planner of the network; None: the rule.
        """
        self.network = network
        self.planner = planner or Planner(network)
        self.round = 0
        """Number of the round of a task that repeats, from 1."""
        self.unfinished: list[int] = []
        """Numbers of the rounds that did not reach the goal."""
        self.begin_round()
        self._bound = network.bound()

    def begin_round(self) -> None:
        """Begin the next round of a task that is repeated: start at the network's start, with all Fails
        forgotten.
        """
        if self.round and self.lost is not None:
            self.unfinished.append(self.round)
        self.round += 1
        self.situation = self.network.start
        self.planner.begin_again()
        self.taken = 0
        """Number of actions that have ended."""
        self.lost: NoWay | None = None
        """Reason why the goal was abandoned for one of `otherwise`; None while it is pursued."""
        self._goals = [self.network.goal, *self.network.otherwise]
        self.missed = set[int]()
        """Numbers of the interrupts whose goals no route led to in this round."""
        self._first: list[tuple[str, int, int]] = []
        """Goals of interrupts with their priorities and numbers, the present one last."""
        self._ahead: list[Action] = []
        self._hopes = False

    @property
    def has_next_round(self) -> bool:
        """True if the task is repeated once more after the present round (repetition).

        The number of rounds must not be used up, and the facts of the present situation must be those of the
        network's start.
        """
        rounds = self.network.aims.rounds
        if rounds is None or (rounds.most is not None and self.round >= rounds.most):
            return False
        situations = self.network.situations
        return dict(situations[self.situation].facts) == dict(situations[self.network.start].facts)

    @property
    def goal(self) -> str:
        """The situation that the run pursues.

        It is the network's goal, the goal of an interrupt, or one of the situations that the task names
        (`otherwise`) for when no route to the goal is left.
        """
        return self._first[-1][0] if self._first else (self._goals or [self.network.goal])[0]

    @property
    def priority(self) -> int | None:
        """Priority of the interrupt (goal pursued before the task's own) that the run pursues; None without
        one.
        """
        return self._first[-1][1] if self._first else None

    @property
    def arrived(self) -> bool:
        """True if the situation that the run tries to reach, its goal, is reached."""
        return bool(self._goals) and self.situation == self.goal

    @property
    def planned(self) -> bool:
        """True if the last plan has actions that were not started yet; they stay the best route while nothing
        fails.
        """
        return bool(self._ahead)

    def plan(self) -> Plan | NoWay:
        """Plan the route from the present situation to the goal.

        If no route leads there, plan to the first situation that can be reached of those that the network
        lists as `otherwise`.
        """
        plan = self._plan()
        while isinstance(plan, NoWay) and not plan.calls_person and (self._first or len(self._goals) > 1):
            if self._first:
                self.missed.add(self._first.pop()[2])
            else:
                self.lost = self.lost or plan
                self._goals.pop(0)
            plan = self._plan()
        if isinstance(plan, Plan):
            self._ahead, self._hopes = list(reversed(plan.actions)), plan.hopes
            return plan
        return self.lost or plan

    def abandon(self, reason: str) -> None:
        """Abandon the goal, and pursue instead the situations that the network lists as `otherwise`.

        Args:
            reason: reason in words.
        """
        self.lost = self.lost or NoWay(self.situation, (), reason)
        self._goals.pop(0)
        self._first, self._ahead = [], []

    def interrupt(self, number: int) -> str:
        """Pursue the goal of an interrupt before the present goal.

        Return the situation that is now pursued; "" if the interrupt is ignored, because no route leads to
        its goal or the goal is reached already.

        Args:
            number: number of the interrupt in the network's aims.
        """
        goals = self.network.aims.interrupts[number].goals
        if self.situation in goals:
            return ""
        plans = [(self.planner.plan(self.situation, goal), goal) for goal in goals]
        routes = [(plan.cost, goal) for plan, goal in plans if isinstance(plan, Plan) and not plan.hopes]
        if not routes:
            self.missed.add(number)
            return ""
        goal = min(routes)[1]
        self._first.append((goal, self.network.aims.interrupts[number].priority, number))
        self._ahead = []
        return goal

    def _plan(self) -> Plan | NoWay:
        if self.taken >= self._bound:
            words = (
                f"no way left from {self.situation} to {self.goal}: {self.taken} actions have been started"
            )
            return NoWay(self.situation, (), f"{words}; allowed: at most {self._bound}")
        if not self._goals:
            return NoWay(self.situation, (), "nothing is left to be reached")
        if self.lost is None and not self._first:
            return self.planner.plan(self.situation)
        return self.planner.plan(self.situation, self.goal)

    def _moved(self, situation: str) -> None:
        """Note the new situation; an interrupt whose goal is reached is over."""
        self.situation = situation
        while self._first and self._first[-1][0] == situation:
            self._first.pop()
            self._ahead = []

    @property
    def next(self) -> Action:
        """Next action of the planned route; only valid while the route has actions left (`planned`)."""
        return self._ahead[-1]

    def took(self, outcome: Outcome | NotStarted) -> None:
        """Move to the situation that an outcome of the executed action leads to; count the outcome if it is a
        Fail.

        A GiveUp changes nothing. `NotStarted` counts as `failed` describes. `Elsewhere`, the result after
        somebody has changed the world, counts as a Fail too, and the run moves to the situation that it
        names.

        Args:
            outcome: outcome of the action that the property `next` named.
        """
        match outcome:
            case Success(_, result):
                self._succeeded(result)
            case Fail(reason, permanent):
                self.failed(reason, permanent, outcome.cause.name)
            case Elsewhere(reason, situation):
                self.failed(reason)
                self._moved(situation)
            case NotStarted(reason):
                self.failed(reason, cause=outcome.cause)

    def _succeeded(self, result: str) -> None:
        hopes = self._hopes and len(self._ahead) == 1
        action = self._ahead.pop()
        self.taken += 1
        target = action.target_of(result)
        renewed = self.planner.succeeded(action)
        if hopes:
            self.planner.hoped(action)
        if renewed or (self._ahead and self._ahead[-1].source != target):
            self._ahead = []
        self._moved(target)

    def failed(self, reason: str, permanent: bool = False, cause: str = "") -> None:
        """Count a Fail of the executed action, drop the plan, and move to the situation that the Fail leads
        to.

        A start that the operator refused shows nothing about the world: it counts, and the situation stays
        as it is. An action that was preempted may be tried as often as before: nothing counts.

        Args:
            reason: reason in words.
            permanent: True if the Fail uses up all attempts of the action.
            cause: name of the Fail's `CauseKind`, which may decide the situation.
        """
        action, self._ahead = self.next, []
        if cause == causes.PREEMPTED.name:
            return
        self.taken += 1
        if cause == causes.REFUSED.name:
            self.planner.refused(action, reason)
            return
        self.planner.failed(action, reason, permanent=permanent)
        self._moved(action.after_fail(cause))

    def acknowledged(self, reason: str) -> None:
        """Count an action as failed that ended in GiveUp, or was broken off, and is undone as a person
        acknowledged, or as the sensors of a real robot measured when its run was resumed.

        What the action learned is not kept. So the situation stays as it is, whatever `on_fail` names.

        Args:
            reason: reason in words.
        """
        action, self._ahead = self.next, []
        self.taken += 1
        self.planner.failed(action, reason)
