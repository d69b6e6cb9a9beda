"""Where a run stands in its network, and what it does next."""

from __future__ import annotations

from handcart.networks.coordination.events import Elsewhere, NotStarted
from handcart.primitives.contract.outcome import Fail, Outcome, Success

from .network import Action, ActionNetwork
from .planner import NoWay, Plan, Planner


class Route:
    """The decisions of a run, without a robot: the same whether outcomes are real, scripted or imagined.

    Paper 003, section 2.6: follow the cheapest way; after a Fail, plan again from where it leads.
    """

    def __init__(self, network: ActionNetwork) -> None:
        """At the network's start, nothing planned."""
        self.network = network
        self.situation = network.start
        self.planner = Planner(network)
        self._ahead: list[Action] = []

    @property
    def arrived(self) -> bool:
        """Whether the goal is reached."""
        return self.situation == self.network.goal

    @property
    def planned(self) -> bool:
        """Whether the last plan still holds: the rest of it stays the cheapest way while nothing fails."""
        return bool(self._ahead)

    def plan(self) -> Plan | NoWay:
        """The cheapest way from here to the goal, kept."""
        plan = self.planner.plan(self.situation)
        if isinstance(plan, Plan):
            self._ahead = list(reversed(plan.actions))
        return plan

    @property
    def next(self) -> Action:
        """The action to do now; there is one after `plan` gave no `NoWay`."""
        return self._ahead[-1]

    def took(self, outcome: Outcome | NotStarted) -> None:
        """The action that was `next` has ended like this; a GiveUp leaves everything as it is."""
        match outcome:
            case Success():
                self.situation = self._ahead.pop().target
            case Fail(reason, permanent):
                self.failed(reason, permanent)
            case Elsewhere(reason, situation):
                self.failed(reason)
                self.situation = situation
            case NotStarted(reason):
                self.failed(reason)

    def failed(self, reason: str, permanent: bool = False) -> None:
        """The action that was `next` has failed; a permanent Fail uses up all its attempts."""
        action = self.next
        self.planner.failed(action, reason, permanent=permanent)
        self._ahead = []
        self.situation = action.on_fail or self.situation
