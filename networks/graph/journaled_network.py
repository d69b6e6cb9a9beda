"""An action network as a journal keeps it: what planning needs, readable without the task's other files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from handcart.primitives.contract.action_primitive import ActionPrimitive

from .binding import Binding
from .network import Action, ActionNetwork, Situation

_KEYS = ("do", "from", "to", "on_fail", "cost_s", "attempts", "uses")


@dataclass(frozen=True)
class NamedBinding(Binding):
    """A primitive of which nothing but its name is known: enough to plan with, not to run."""

    kind: type[ActionPrimitive] = ActionPrimitive  # type: ignore[type-abstract]
    name: str = ""

    @cached_property
    def label(self) -> str:
        """The primitive's name in files."""
        return self.name


def network_fields(network: ActionNetwork) -> dict[str, Any]:
    """A network, ready for JSON: `keys` names the columns of `actions`, `uses` among them: the entries of
    the world model that a primitive may read. A skip has no `do`."""
    rows = [
        (a.binding and a.do, a.source, a.target, a.on_fail, a.cost_s, a.attempts, _uses(a))
        for a in network.actions
    ]
    facts = {each.name: dict(each.facts) for each in network.situations.values()}
    return {
        "start": network.start,
        "goal": network.goal,
        "situations": facts,
        "keys": _KEYS,
        "actions": rows,
    }


@dataclass(frozen=True)
class JournaledNetwork:
    """A network that a journal kept."""

    network: ActionNetwork
    uses: tuple[tuple[str, ...], ...]
    """For each action the entries of the world model that its primitive may read."""


def network_of(fields: Mapping[str, Any]) -> JournaledNetwork:
    """The network that `network_fields` told.

    Raises:
        LookupError, TypeError, ValueError: the fields tell no sound network.
    """
    rows = [dict(zip(fields["keys"], row, strict=True)) for row in fields["actions"]]
    actions = [
        Action(
            row["from"],
            row["to"],
            None if row["do"] is None else NamedBinding(name=row["do"]),
            row["cost_s"],
            row["attempts"],
            row["on_fail"],
        )
        for row in rows
    ]
    situations = [Situation(name, facts) for name, facts in fields["situations"].items()]
    network = ActionNetwork.build(situations, actions, fields["start"], fields["goal"])
    return JournaledNetwork(network, tuple(tuple(row["uses"]) for row in rows))


def _uses(action: Action) -> list[str]:
    if action.binding is None:
        return []
    kind = action.binding.kind
    return sorted({*kind.reads, *kind.writes, *(key.split(".")[0] for key in action.binding.late.values())})
