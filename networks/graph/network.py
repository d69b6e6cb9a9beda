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
from handcart.primitives.restoring.patience import NO_PATIENCE, Patience

from .aims import NO_AIMS, Aims
from .attempts import MAX_ATTEMPTS as MAX_ATTEMPTS
from .attempts import Attempts
from .belief_prior import BeliefPrior
from .distinctions import SiblingAction, distinctions
from .endings import Ending as Ending
from .endings import FailEnding as FailEnding

Fact = str | bool | int | float

LOCATE_NAME = "LOCATE"
"""Name of the primitive that finds the pose of the base."""
MAX_COST_S = 86_400.0
"""Maximum cost of an action, in [s]: a day."""
MAX_ACTIONS = 200_000
"""The most actions: a plan over half as many takes 0.13 s, so none ever takes 2 s (rows N10, N14)."""


MAX_ROUNDS = 20
"""Factor by which the bound of a run's actions grows if chance may lead the run in circles."""


class NetworkError(InputError):
    """Error in situations and actions that do not form a valid network; the message gives the reason."""


class NotBound(Exception):
    """Error, because the world model has no valid value for an action's parameter.

    The action counts as failed before it starts.
    """


@dataclass(frozen=True)
class Binding:
    """A kind of primitive with its parameters: fixed ones, and those read from the world model."""

    kind: type[ActionPrimitive]
    fixed: Mapping[str, Any] = field(default_factory=dict)
    """Checked values, by parameter."""
    late: Mapping[str, str] = field(default_factory=dict)
    """Names in the world model, such as `cup.size`, by parameter."""

    @classmethod
    def of(cls, primitive: ActionPrimitive) -> Binding:
        """Return a binding (a primitive with its parameters) whose parameters all have fixed values."""
        return cls(type(primitive), {name: getattr(primitive, name) for name in type(primitive).model_fields})

    @cached_property
    def label(self) -> str:
        """Name of the primitive in files, such as MOVE_TO."""
        return self.kind.label()

    def make(self, model: WorldModel) -> ActionPrimitive:
        """Return a new instance of the primitive for one attempt, with the values of all its parameters.

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
        """Return the parameters of an action's primitive in the form in which a task file contains them."""
        late = {name: {"model": key} for name, key in self.late.items()}
        if not self.fixed:
            return late
        dumped = self.kind.model_construct(**self.fixed).model_dump(mode="json", include=set(self.fixed))
        return {**dumped, **late}

    def given(self) -> dict[str, Any]:
        """Return the parameters that differ from the primitive's defaults, as a task file contains them."""
        usual = {name: field.default for name, field in self.kind.model_fields.items()}
        said = self.said()
        return {name: said[name] for name in said if name in self.late or self.fixed[name] != usual.get(name)}


@dataclass(frozen=True)
class Situation:
    """A named state of robot and world, in which actions of a task's network begin and end."""

    name: str
    facts: Mapping[str, Fact] = field(default_factory=dict)
    """Physical facts that hold in it; facts that only describe knowledge belong in the name."""
    element: str | None = None
    """Element of a `repeat` that it belongs to; facts learned for it are forgotten when it is left.

    None: it is outside the repeated parts.
    """


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
    p: float | None = None
    """Probability that an attempt ends in Success and leads to the target; None: not known."""
    p_give_up: float = 0.0
    """Probability that it ends in GiveUp; that of Fail is what remains of 1."""
    others: tuple[Ending, ...] = ()
    """Further situations that Success may lead to."""
    unlimited: bool = False
    """True if Fails never exclude it."""
    renewals: int = 0
    """Maximum number of times that its Fails are forgotten after a Success of an action in `fresh_after`."""
    fresh_after: tuple[str, ...] = ()
    """Primitives, by their names in files, after whose Success its Fails are forgotten."""
    budget: str = ""
    """Name of the attempts that it shares with other actions; empty: its own."""
    counter: int = -1
    """Number of the first action that shares its attempts."""
    fail_endings: tuple[FailEnding, ...] = ()
    """Situations that Fails of certain causes lead to; all others lead to `on_fail`."""
    distinction: str = ""
    """Distinction from other actions that do the same between the same situations, such as `looks: 8`."""

    @cached_property
    def allowance(self) -> Attempts:
        """Limit on the Fails of the action."""
        return Attempts(self.attempts, self.renewals, self.unlimited)

    @property
    def leads_to(self) -> tuple[str, ...]:
        """All situations that the action may lead to, that of Success first."""
        return (self.target, *(other.target for other in self.others), *self.fail_situations)

    @property
    def fail_situations(self) -> tuple[str, ...]:
        """Situations to which Fails may lead, each once; none for Fails that do not change the situation."""
        named = (*(ending.target for ending in self.fail_endings), self.on_fail)
        return tuple(dict.fromkeys(item for item in named if item is not None))

    def after_fail(self, cause: str = "") -> str:
        """Return the situation after a Fail with a given cause."""
        every = {ending.cause: ending.target for ending in self.fail_endings}
        return every.get(cause, self.on_fail) or self.source

    @property
    def p_success(self) -> float | None:
        """Probability that the action ends in Success, whichever situation follows; None if it is unknown."""
        return None if self.p is None else self.p + sum(other.p or 0.0 for other in self.others)

    def further(self, with_chances: bool) -> tuple[object, ...]:
        """Return data of this action that planning uses besides situations, cost and number of attempts.

        They are the situations after other results and after Fails of certain causes, and the rules for
        shared, renewed or unlimited attempts, as far as the action has any; with chances also probabilities.

        Args:
            with_chances: whether planning also depends on the probabilities of the outcomes.
        """
        found: tuple[object, ...] = ()
        if with_chances:
            found += "p", self.p, self.p_give_up
        if self.others:
            found += "then", self.p, self.others
        if self.unlimited or self.renewals or self.budget:
            found += "attempts", self.unlimited, self.renewals, self.fresh_after, self.counter
        for ending in self.fail_endings:
            found += "fail", ending.cause, ending.target, ending.p if with_chances else None
        return found

    def target_of(self, result: str) -> str:
        """Return the situation after a Success with the effect `result`; `target` if no effect has it."""
        found = (other.target for other in self.others if other.result == result)
        return next(found, self.target) if self.others else self.target

    @property
    def do(self) -> str:
        """Name of the primitive in files; SKIP if the action skips an element of a list of a `repeat`."""
        return self.binding.label if self.binding else "SKIP"

    @property
    def name(self) -> str:
        """Primitive's name, and what distinguishes it from an equal action between the same situations."""
        return f"{self.do} with {self.distinction}" if self.distinction else self.do

    def __str__(self) -> str:
        return f"{self.name} ({self.source} to {self.target})"


@dataclass(frozen=True)
class ActionNetwork:
    """Situations and actions as a directed multigraph that never changes.

    Each edge of `graph` has its action's number as key, and the action as its attribute `action`.
    """

    graph: nx.MultiDiGraph[str]
    situations: Mapping[str, Situation]
    actions: tuple[Action, ...]
    start: str
    goal: str
    otherwise: tuple[str, ...] = ()
    """Situations to be reached, in order of preference, when no route to the goal is left."""
    policy: str = "rule"
    """Policy that chooses actions: `rule`, `expected_cost` or `goal_probability`."""
    person_s: float = 600.0
    """Price of each end short of the goal, in [s]."""
    restoring: Patience = NO_PATIENCE
    """Limits on repeating the restoring after a fault."""
    aims: Aims = NO_AIMS
    """Time-out, rounds and interrupts."""
    belief: BeliefPrior | None = None
    """Beliefs in the probabilities at the start of a run; None: those of the file hold throughout."""

    @classmethod
    def build(
        cls,
        situations: Iterable[Situation],
        actions: Iterable[Action],
        start: str,
        goal: str,
        otherwise: tuple[str, ...] = (),
    ) -> ActionNetwork:
        """Build a network; raise `NetworkError` if it is invalid. `otherwise` lists next-best goals."""
        every = list(situations)
        known = {situation.name: situation for situation in every}
        numbered = _numbered(actions)
        if len(numbered) > MAX_ACTIONS:
            raise NetworkError(f"the network has {len(numbered)} actions; allowed: at most {MAX_ACTIONS}")
        wrong = [
            f"the situation {name!r} is there twice"
            for name in _doubled(situation.name for situation in every)
        ]
        for role, name in (("start", start), ("goal", goal), *(("otherwise", text) for text in otherwise)):
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
        return cls(nx.freeze(graph), MappingProxyType(known), numbered, start, goal, otherwise)

    @cached_property
    def shared(self) -> Mapping[int, tuple[Action, ...]]:
        """The actions that share a counter of Fails, by the counter's number (`Action.counter`)."""
        found: dict[int, list[Action]] = {}
        for action in self.actions:
            found.setdefault(action.counter, []).append(action)
        return {number: tuple(actions) for number, actions in found.items()}

    @cached_property
    def renewed_by(self) -> Mapping[int, tuple[int, ...]]:
        """Numbers of the counters of Fails that a Success of an action resets, by the action's number."""
        waiting: dict[tuple[str, str | None], dict[int, None]] = {}
        for action in self.actions:
            element = self.situations[action.source].element
            for do in action.fresh_after:
                waiting.setdefault((do, element), {})[action.counter] = None
        if not waiting:
            return {}
        named = ((a, waiting.get((a.do, self.situations[a.source].element))) for a in self.actions)
        return {action.index: tuple(counters) for action, counters in named if counters}

    def bound(self) -> int:
        """Return an upper bound of the number of actions that a run (or round) starts: (A + 1)(V - 1) + A.

        V is the number of situations, A that of all attempts with renewals. Between two counted attempts a
        run visits no situation twice. If a run may go in circles, has interrupts, or has another policy than
        the rule, the bound is `MAX_ROUNDS` times as large, and the run is ended there.
        """
        counters = (actions[0] for actions in self.shared.values())
        attempts = sum(counter.allowance.most * (1 + counter.renewals) for counter in counters)
        most = (attempts + 1) * (len(self.situations) - 1) + attempts
        is_led_away = self.may_circle or self.policy != "rule" or bool(self.aims.interrupts)
        return most * (MAX_ROUNDS if is_led_away else 1)

    @cached_property
    def may_circle(self) -> bool:
        """True if there is no limit to how often a run can come back to the same situation.

        That is so if a Success may lead to several situations, or if an action may Fail any number of times.
        """
        return any(action.others or action.unlimited for action in self.actions)

    def fingerprint(self) -> str:
        """Return a checksum of everything that planning depends on, in hexadecimal.

        Features that a network does not use are left out, so that runs of older versions stay resumable.
        """
        digest = hashlib.sha256(repr((self.start, self.goal)).encode())
        for situation in self.situations.values():
            digest.update(repr((situation.name, sorted(situation.facts.items()), situation.element)).encode())
        for action in self.actions:
            said = action.binding.said() if action.binding else {}
            row = (action.do, action.source, action.target, action.on_fail, action.cost_s, action.attempts)
            digest.update(repr((row, said, action.permit, action.time_out_s)).encode())
            if further := action.further(self.policy != "rule"):
                digest.update(repr(further).encode())
        if self.otherwise:
            digest.update(repr(("otherwise", self.otherwise)).encode())
        if self.policy != "rule":
            digest.update(repr((self.policy, self.person_s)).encode())
        if self.belief is not None:
            digest.update(repr(("belief", *self.belief)).encode())
        if self.restoring != NO_PATIENCE:
            digest.update(repr(("restoring", *self.restoring)).encode())
        if aims := self.aims.fields():
            digest.update(repr(aims).encode())
        return digest.hexdigest()


def _numbered(actions: Iterable[Action]) -> tuple[Action, ...]:
    """Return the actions with their numbers, and with the numbers of their counters of Fails."""
    first: dict[str, int] = {}
    found, every = [], tuple(actions)
    words = distinctions([_compared(item) for item in every])
    for number, action in enumerate(every):
        counter = first.setdefault(action.budget, number) if action.budget else number
        found.append(replace(action, index=number, counter=counter, distinction=words.get(number, "")))
    return tuple(found)


def _compared(action: Action) -> SiblingAction | None:
    if action.binding is None:
        return None
    return SiblingAction(action.do, action.source, action.target, action.binding.given, action.cost_s)


def faults_of(action: Action, known: Mapping[str, Situation]) -> list[tuple[str, str]]:
    """Return the faults of an action in a network with the given situations.

    Args:
        action: the action.
        known: all situations of the network, by name.

    Returns:
        Pairs of the key in files, and the fault with the allowed values.
    """
    named = [("from", action.source), ("to", action.target), ("on_fail", action.on_fail)]
    named += [("then", other.target) for other in action.others]
    named += [("on_fail", ending.target) for ending in action.fail_endings]
    wrong = [
        (key, f"unknown situation {name!r}{suggest(name, known)}")
        for key, name in named
        if name is not None and name not in known
    ]
    if not (math.isfinite(action.cost_s) and 0 < action.cost_s <= MAX_COST_S):
        wrong.append(("cost_s", f"cost_s is {action.cost_s}; allowed: above 0, at most {MAX_COST_S:g}"))
    if not 1 <= action.attempts <= MAX_ATTEMPTS:
        wrong.append(("attempts", f"attempts is {action.attempts}; allowed: 1 to {MAX_ATTEMPTS}"))
    before, nexts = known.get(action.source), (known.get(name) for name in action.fail_situations)
    for after in nexts:
        if before and after and dict(before.facts) != dict(after.facts):
            said = f"{after.name!r} has other physical facts than {before.name!r}, and a Fail changes none"
            wrong.append(("on_fail", f"{said}; allowed: a situation with the same facts"))
    return wrong


def _doubled(names: Iterable[str]) -> list[str]:
    seen: set[str] = set()
    return [name for name in names if name in seen or seen.add(name)]  # type: ignore[func-returns-value]
