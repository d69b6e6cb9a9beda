"""An action network as kept in a journal, sufficient for planning without the task's other files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from typing_extensions import override

from handcart.networks.deciding.option_values import RunOptionValues
from handcart.networks.graph.aims import Aims
from handcart.networks.graph.belief_prior import BeliefPrior
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Ending, FailEnding, Situation
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.restoring.patience import NO_PATIENCE, Patience


@dataclass(frozen=True)
class NamedBinding(Binding):
    """A primitive known only by name and parameters, which is enough to plan with it but not to run it."""

    kind: type[ActionPrimitive] = ActionPrimitive  # type: ignore[type-abstract]
    name: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def label(self) -> str:
        """Name of the action's primitive as task files and journals state it, such as `MOVE_TO`."""
        return self.name

    @override
    def given(self) -> dict[str, Any]:
        return dict(self.parameters)


@dataclass(frozen=True)
class JournaledNetwork:
    """An action network as it was recorded in a run's journal, with the entries of the world model that each
    action's primitive may read.
    """

    network: ActionNetwork
    uses: tuple[tuple[str, ...], ...]
    """Entries of the world model that each action's primitive may read."""

    @cached_property
    def values(self) -> RunOptionValues:
        """Cache of the time and result expected of each option, used for all decisions of a run.

        An option is an action that a run can take next.
        """
        return RunOptionValues(self.network)


def network_of(fields: Mapping[str, Any]) -> JournaledNetwork:
    """Return the network described by a journal's header.

    Raises:
        LookupError, TypeError, ValueError: the fields do not describe a valid network.
    """
    rows = [dict(zip(fields["keys"], row, strict=True)) for row in fields["actions"]]
    actions = [
        Action(
            row["from"],
            row["to"],
            None if row["do"] is None else NamedBinding(name=row["do"], parameters=row["with"]),
            row["cost_s"],
            row["attempts"],
            row["on_fail"],
            permit=row["permit"],
            time_out_s=row["time_out_s"],
            p=row.get("p"),
            p_give_up=row.get("p_give_up", 0.0),
            others=tuple(Ending(*item) for item in row.get("others", ())),
            unlimited=row.get("unlimited", False),
            renewals=row.get("renewals", 0),
            fresh_after=tuple(row.get("fresh_after", ())),
            budget=row.get("budget", ""),
            fail_endings=tuple(FailEnding(*item) for item in row.get("fails", ())),
        )
        for row in rows
    ]
    elements = fields["elements"]
    situations = [Situation(name, facts, elements.get(name)) for name, facts in fields["situations"].items()]
    otherwise = tuple(fields.get("otherwise", ()))
    network = ActionNetwork.build(situations, actions, fields["start"], fields["goal"], otherwise)
    network = replace(
        network,
        policy=fields.get("policy", "rule"),
        person_s=float(fields.get("person_s", 600.0)),
        restoring=Patience(*fields.get("restoring", NO_PATIENCE)),
        aims=Aims.of(dict(fields)),
        belief=BeliefPrior.read(fields),
    )
    return JournaledNetwork(network, tuple(tuple(row["uses"]) for row in rows))
