"""Position of a run in its network, and its next actions."""

from __future__ import annotations

from dataclasses import dataclass

from handcart.primitives.outcomes.outcome import Fail, Outcome, Success

from .network import Action, ActionNetwork
from .planner import NoWay, Plan, Planner


@dataclass(frozen=True)
class NotStarted:
    """An action that could not be started: refused, or a parameter isn't known. Counts as a Fail."""

    reason: str


@dataclass(frozen=True)
class Elsewhere(NotStarted):
    """An action that was not started because the world was changed: another situation holds."""

    situation: str


class RunDecisions:
    """The decisions of a run, without a robot: the same whether outcomes are real, scripted or imagined.

    Paper 003, section 2.6: follow the cheapest way; after a Fail, plan again from where it leads.
    """

    def __init__(self, network: ActionNetwork, planner: Planner | None = None) -> None:
        """Begin at the network's start, with nothing planned.

        Args:
            network: the network.
            planner: planner of the network; None: the rule.
        """
        self.network = network
        self.situation = network.start
        self.planner = planner or Planner(network)
        self.taken = 0
        """Number of actions that have ended."""
        self.lost: NoWay | None = None
        """Reason why the goal was abandoned for one of `otherwise`; None while it is pursued."""
        self._goals = [network.goal, *network.otherwise]
        self._ahead: list[Action] = []
        self._hopes = False
        self._bound = network.bound()

    @property
    def goal(self) -> str:
        """Situation that is pursued: the goal, or one of `otherwise` if no route leads to the goal."""
        return self._goals[0]

    @property
    def arrived(self) -> bool:
        """True if the pursued situation is reached."""
        return self.situation == self._goals[0]

    @property
    def planned(self) -> bool:
        """True if the last plan still holds: its rest remains the best route while nothing fails."""
        return bool(self._ahead)

    def plan(self) -> Plan | NoWay:
        """Plan the route from here to the goal, or to the first of `otherwise` that can be reached."""
        plan = self._plan()
        while isinstance(plan, NoWay) and not plan.calls_person and len(self._goals) > 1:
            self.lost = self.lost or plan
            self._goals.pop(0)
            plan = self._plan()
        if isinstance(plan, Plan):
            self._ahead, self._hopes = list(reversed(plan.actions)), plan.hopes
            return plan
        return self.lost or plan

    def _plan(self) -> Plan | NoWay:
        if self.taken >= self._bound:
            words = (
                f"no way left from {self.situation} to {self.goal}: {self.taken} actions have been started"
            )
            return NoWay(self.situation, (), f"{words}; allowed: at most {self._bound}")
        if self.lost is None:
            return self.planner.plan(self.situation)
        return self.planner.plan(self.situation, self.goal)

    @property
    def next(self) -> Action:
        """Action to do now; valid after `plan` returned a `Plan` short of the goal."""
        return self._ahead[-1]

    def took(self, outcome: Outcome | NotStarted) -> None:
        """Note the outcome of the action that was `next`; a GiveUp changes nothing."""
        match outcome:
            case Success(_, result):
                self._succeeded(result)
            case Fail(reason, permanent):
                self.failed(reason, permanent, outcome.cause.name)
            case Elsewhere(reason, situation):
                self.failed(reason)
                self.situation = situation
            case NotStarted(reason):
                self.failed(reason)

    def _succeeded(self, result: str) -> None:
        hopes = self._hopes and len(self._ahead) == 1
        action = self._ahead.pop()
        self.taken += 1
        self.situation = action.target_of(result)
        renewed = self.planner.succeeded(action)
        if hopes:
            self.planner.failed(action, "it succeeded, and its Fail was needed")
        if renewed or (self._ahead and self._ahead[-1].source != self.situation):
            self._ahead = []

    def failed(self, reason: str, permanent: bool = False, cause: str = "") -> None:
        """Note a Fail of the action that was `next`; a permanent Fail uses up all its attempts.

        Its cause may decide to which situation it leads.
        """
        action = self.next
        self.taken += 1
        self.planner.failed(action, reason, permanent=permanent)
        self._ahead = []
        self.situation = action.after_fail(cause)
