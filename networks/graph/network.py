"""The action network: situations joined by actions, fixed before anything moves."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import networkx as nx
from pydantic import ValidationError

from handcart.files.errors import InputError
from handcart.files.suggest import suggest
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.knowledge.world_model import UnknownFact, WorldModel

Fact = str | bool | int | float

MAX_COST_S = 86_400.0
"""Maximum cost of an action, in [s]: a day."""
MAX_ATTEMPTS = 20
"""Maximum attempts of an action; with `MAX_COST_S` it keeps doubled weights below `SKIP_WEIGHT`."""


MAX_ACTIONS = 200_000
"""The most actions: a plan over half as many takes 0.13 s, so none ever takes 2 s (rows N10, N14)."""


class NetworkError(InputError):
    """Situations and actions that are not a valid network; the message says why."""


class NotBound(Exception):
    """A late-bound parameter has no fitting value now; the action counts as failed before it starts."""


@dataclass(frozen=True)
class Binding:
    """A kind of primitive with fixed parameters and those that come from the world model."""

    kind: type[ActionPrimitive]
    fixed: Mapping[str, Any] = field(default_factory=dict)
    """Checked values, by parameter."""
    late: Mapping[str, str] = field(default_factory=dict)
    """Names in the world model, such as `cup.size`, by parameter."""

    @classmethod
    def of(cls, primitive: ActionPrimitive) -> Binding:
        """Return a binding of a primitive all of whose parameters are known."""
        return cls(type(primitive), {name: getattr(primitive, name) for name in type(primitive).model_fields})

    @cached_property
    def label(self) -> str:
        """The primitive's name in files."""
        return self.kind.label()

    def make(self, model: WorldModel) -> ActionPrimitive:
        """Return a new instance for one attempt, with all its parameters.

        Raises:
            NotBound: the world model does not know a value yet, or the parameter does not accept it.
        """
        if not self.late:
            return self.kind.model_validate(self.fixed)
        try:
            known = {name: model.lookup(key) for name, key in self.late.items()}
            return self.kind.model_validate({**self.fixed, **known})
        except UnknownFact as unknown:
            raise NotBound(str(unknown)) from None
        except ValidationError as error:
            wrong = error.errors(include_url=False)[0]
            raise NotBound(f"{'.'.join(map(str, wrong['loc']))}: {wrong['msg']}") from None

    def said(self) -> dict[str, Any]:
        """Return the parameters as a file would contain them."""
        late = {name: {"model": key} for name, key in self.late.items()}
        if not self.fixed:
            return late
        dumped = self.kind.model_construct(**self.fixed).model_dump(mode="json", include=set(self.fixed))
        return {**dumped, **late}

    def given(self) -> dict[str, Any]:
        """Return the parameters as a file would contain them, without those at the primitive's defaults."""
        usual = {name: field.default for name, field in self.kind.model_fields.items()}
        said = self.said()
        return {name: said[name] for name in said if name in self.late or self.fixed[name] != usual.get(name)}


@dataclass(frozen=True)
class Situation:
    """A named planning state of robot and world."""

    name: str
    facts: Mapping[str, Fact] = field(default_factory=dict)
    """Physical facts that hold in it; facts that only describe knowledge belong in the name."""
    element: str | None = None
    """Element of a `repeat` that it belongs to; facts learned for it are forgotten when it is left."""


@dataclass(frozen=True)
class Action:
    """A transition from one situation to another by a primitive with its parameters, and its cost."""

    source: str
    target: str
    binding: Binding | None
    """The primitive; None for a skip, which does nothing but leave an element of a `repeat` undone."""
    cost_s: float = 1.0
    attempts: int = 3
    on_fail: str | None = None
    """Situation after a Fail, which may differ in knowledge only; None: the situation remains as it is."""
    index: int = -1
    """Number of the action in the network."""
    permit: bool = False
    """True if the operator has to permit it each time."""
    time_out_s: float | None = None
    """Time after which an attempt is stopped, in [s] of the robot's time; None: never."""

    @property
    def do(self) -> str:
        """The primitive's name in files, SKIP for a skip."""
        return self.binding.label if self.binding else "SKIP"

    def __str__(self) -> str:
        return f"{self.do} ({self.source} to {self.target})"


@dataclass(frozen=True)
class ActionNetwork:
    """Situations and actions as a directed multigraph that never changes.

    Each edge has its action's number as key and the action under `action`.
    """

    graph: nx.MultiDiGraph[str]
    situations: Mapping[str, Situation]
    actions: tuple[Action, ...]
    start: str
    goal: str

    @classmethod
    def build(
        cls, situations: Iterable[Situation], actions: Iterable[Action], start: str, goal: str
    ) -> ActionNetwork:
        """Build a network of these situations and actions."""
        every = list(situations)
        known = {each.name: each for each in every}
        numbered = tuple(replace(action, index=number) for number, action in enumerate(actions))
        if len(numbered) > MAX_ACTIONS:
            raise NetworkError(f"the network has {len(numbered)} actions; allowed: at most {MAX_ACTIONS}")
        wrong = [f"the situation {name!r} is there twice" for name in _doubled(each.name for each in every)]
        for role, name in (("start", start), ("goal", goal)):
            if name not in known:
                wrong.append(f"{role}: unknown situation {name!r}{suggest(name, known)}")
        wrong += [
            f"{action}: {key}: {fault}" for action in numbered for key, fault in faults_of(action, known)
        ]
        if wrong:
            raise NetworkError("\n".join(wrong))
        graph: nx.MultiDiGraph[str] = nx.MultiDiGraph()
        graph.add_nodes_from(known)
        graph.add_edges_from((a.source, a.target, a.index, {"action": a}) for a in numbered)
        return cls(nx.freeze(graph), MappingProxyType(known), numbered, start, goal)

    def bound(self) -> int:
        """The most actions that any run can start, whatever fails: (A + 1)(V - 1) + A.

        V situations, A attempts of all actions together: between two counted attempts a run visits no
        situation twice.
        """
        attempts = sum(action.attempts for action in self.actions)
        return (attempts + 1) * (len(self.situations) - 1) + attempts

    def fingerprint(self) -> str:
        """Return a checksum of everything that planning depends on, in hexadecimal."""
        digest = hashlib.sha256(repr((self.start, self.goal)).encode())
        for each in self.situations.values():
            digest.update(repr((each.name, sorted(each.facts.items()), each.element)).encode())
        for action in self.actions:
            said = action.binding.said() if action.binding else {}
            row = (action.do, action.source, action.target, action.on_fail, action.cost_s, action.attempts)
            digest.update(repr((row, said, action.permit, action.time_out_s)).encode())
        return digest.hexdigest()


def faults_of(action: Action, known: Mapping[str, Situation]) -> list[tuple[str, str]]:
    """Return the faults of an action among these situations.

    Args:
        action: the action.
        known: all situations of the network, by name.

    Returns:
        Pairs of the key in files, and the fault with the allowed values.
    """
    named = {"from": action.source, "to": action.target, "on_fail": action.on_fail}
    wrong = [
        (key, f"unknown situation {name!r}{suggest(name, known)}")
        for key, name in named.items()
        if name is not None and name not in known
    ]
    if not (math.isfinite(action.cost_s) and 0 < action.cost_s <= MAX_COST_S):
        wrong.append(("cost_s", f"cost_s is {action.cost_s}; allowed: above 0, at most {MAX_COST_S:g}"))
    if not 1 <= action.attempts <= MAX_ATTEMPTS:
        wrong.append(("attempts", f"attempts is {action.attempts}; allowed: 1 to {MAX_ATTEMPTS}"))
    before, after = known.get(action.source), known.get(action.on_fail or "")
    if before and after and dict(before.facts) != dict(after.facts):
        said = f"{after.name!r} has other physical facts than {before.name!r}, and a Fail changes none"
        wrong.append(("on_fail", f"{said}; allowed: a situation with the same facts"))
    return wrong


def _doubled(names: Iterable[str]) -> list[str]:
    seen: set[str] = set()
    return [name for name in names if name in seen or seen.add(name)]  # type: ignore[func-returns-value]
