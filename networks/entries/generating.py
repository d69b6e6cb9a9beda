"""Generation of a network from conditions: all situations of a run (paper 003, section 2.6)."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from handcart.files.suggest import listed
from handcart.networks.graph.network import MAX_ACTIONS, Fact

from .condition_entry import ConditionEntry, Conditions
from .copied import Copied, Copies
from .entry import OTHER_CAUSES, listed_names
from .fact_space import Change, Condition, FactSpace, State
from .goals_in_order import goal_copy

MAX_SITUATIONS = 50_000
"""Maximum number of situations that conditions may span."""


class NotGenerated(ValueError):
    """Error in conditions from which no valid network can be generated; the message gives the reason."""

    def __init__(self, message: str, key: str = "facts") -> None:
        super().__init__(message)
        self.key = key
        """Key of the task's file that is to blame."""


class Generated(NamedTuple):
    """A network that was generated from conditions, with its goal, the facts of its situations, and further
    goals.
    """

    copies: Copies
    facts: Mapping[str, Mapping[str, Fact]]
    """Physical facts of each situation."""
    goal: str
    otherwise: tuple[str, ...]
    interrupts: tuple[tuple[str, ...], ...] = ()
    """Situations that end each of the file's interrupts."""


class _Place(NamedTuple):
    """Situation that was found and whose actions are still to be followed."""

    state: State
    number: int
    """Number of the goal that is pursued, from 0."""


@dataclass(frozen=True)
class _Rule:
    """Action of the file with its conditions and effects as numbers."""

    number: int
    condition: Condition
    endings: tuple[Change, ...]
    fails: tuple[Change, ...]
    """Effects of Fails of named causes."""
    otherwise: Change
    """Effect of all other Fails."""
    renews: bool
    """True if its Success gives attempts back, so that it is useful where it changes nothing."""

    def holds(self, state: State) -> bool:
        return all(state[fact] in values for fact, values in self.condition)


class NetworkGenerator:
    """Generator of a task's network from the conditions that each action requires and the facts that it
    changes.

    From the start, it follows every action whose conditions hold to the situations that the action leads to.
    All situations in which the goal's conditions hold are merged into one.
    """

    def __init__(
        self,
        space: FactSpace,
        entries: Mapping[int, ConditionEntry],
        goals: Sequence[Conditions],
    ) -> None:
        """Prepare the generation.

        Args:
            space: the facts of the task.
            entries: the file's actions, by number; all their names and values are known.
            goals: conditions of the goals, in order.
        """
        self._space, self._goals = space, [space.condition(goal) for goal in goals]
        self._goal_name = goal_copy(space.words(goals[-1]), len(goals) - 1)
        renewing = {
            do
            for condition_entry in entries.values()
            for do in listed_names(condition_entry.limit.fresh_after)
        }
        self._rules = [_rule(space, number, entry, renewing) for number, entry in entries.items()]
        self._names: dict[_Place, str] = {}
        self._waiting: deque[_Place] = deque()
        self._goal_facts: dict[str, Fact] | None = None

    def generated(
        self,
        start: Mapping[str, Fact],
        otherwise: Sequence[Conditions] = (),
        interrupts: Sequence[Conditions] = (),
    ) -> Generated:
        """Return the network of all situations that can be reached from a start.

        Args:
            start: values by fact at the start; all other facts have the first of their values.
            otherwise: conditions of the situations to go to when no route to the goal is left, the most
                preferred first.
            interrupts: for each interrupt in the task's file (a detour, for example to charge), conditions
                of the situations that end it.

        Raises:
            NotGenerated: the network has more than `MAX_SITUATIONS` situations or `MAX_ACTIONS` actions, or a
                Fail leads to the goal, although not all facts of the goal are determined.
        """
        first = self._name(_Place(self._space.start(start), 0))
        actions: list[Copied] = []
        while self._waiting:
            actions += self._actions(self._waiting.popleft())
            if len(actions) > MAX_ACTIONS:
                raise NotGenerated(self._too_many(f"{MAX_ACTIONS} actions"))
        facts = {name: self._space.facts_of(place.state) for place, name in self._names.items()}
        if self._goal_facts is not None:
            facts = {**facts, self._goal_name: self._goal_facts}
        facts.setdefault(self._goal_name, {})  # no action leads there, which is reported later
        self._check_fails(actions, facts)
        situations = dict.fromkeys(facts)
        copies = Copies({name: (name, None) for name in situations}, tuple(actions), first)
        ends = tuple(tuple(self._meeting([interrupt])) for interrupt in interrupts)
        return Generated(copies, facts, self._goal_name, tuple(self._meeting(otherwise)), ends)

    def _name(self, place: _Place) -> str:
        """Return the name of a situation, which is followed later if it is new."""
        state, number = place
        while number < len(self._goals) and _holds(self._goals[number], state):
            number += 1
        place = _Place(state, number)
        if number == len(self._goals):
            here = self._space.facts_of(state)
            before = here if self._goal_facts is None else self._goal_facts
            self._goal_facts = {name: value for name, value in before.items() if here[name] == value}
            return self._goal_name
        if place not in self._names:
            if len(self._names) >= MAX_SITUATIONS:
                raise NotGenerated(self._too_many(f"{MAX_SITUATIONS} situations"))
            self._names[place] = goal_copy(self._space.name_of(state), number)
            self._waiting.append(place)
        return self._names[place]

    def _actions(self, place: _Place) -> Iterator[Copied]:
        (state, number), changed = place, self._space.changed
        for rule in self._rules:
            if not rule.holds(state):
                continue
            ends = [changed(state, ending) for ending in rule.endings]
            fails = [changed(state, fail) for fail in (rule.otherwise, *rule.fails)]
            if not rule.renews and all(end == state for end in (*ends, *fails)):
                continue
            usual, *others = (self._name(_Place(end, number)) for end in ends)
            on_fail, *by_cause = (None if e == state else self._name(_Place(e, number)) for e in fails)
            ends_in = tuple(others), tuple(by_cause)
            yield Copied(self._names[place], usual, on_fail, rule.number, None, *ends_in)

    def _check_fails(self, actions: Sequence[Copied], facts: Mapping[str, Mapping[str, Fact]]) -> None:
        """Raise if a Fail leads to the goal, and would change physical facts there."""
        goal = self._goal_name
        for action in actions:
            if goal in (action.on_fail, *action.fails) and facts[action.source] != facts[goal]:
                missing = listed(name for name in facts[action.source] if name not in facts[goal])
                wrong = f"a Fail leads to it, and {missing} may have several values in it"
                raise NotGenerated(f"{wrong}; allowed: a goal that names all facts", "goal")

    def _meeting(self, conditions: Sequence[Conditions]) -> Iterator[str]:
        """Yield the situations that meet one of these conditions, in order of preference."""
        seen: set[str] = set()
        for condition in conditions:
            needed = self._space.condition(condition)
            for place, name in self._names.items():
                if name not in seen and _holds(needed, place.state):
                    seen.add(name)
                    yield name

    def _too_many(self, limit: str) -> str:
        counts: Counter[str] = Counter()
        for number, name in enumerate(self._space.values):
            counts[name] = len({place.state[number] for place in self._names})
        most = listed(f"{name} ({count} values)" for name, count in counts.most_common(3))
        wrong = f"the conditions span more than {limit}; facts with the most values: {most}"
        return f"{wrong}; allowed: fewer facts or values, or conditions that exclude more"


def _rule(space: FactSpace, number: int, entry: ConditionEntry, renewing: set[str]) -> _Rule:
    fails = tuple(space.change(fail_entry.known) for fail_entry in entry.fail_entries.values())
    unnamed = entry.fails.get(OTHER_CAUSES)
    endings = tuple(space.change(ending.changes) for ending in entry.endings)
    left = space.change(unnamed.known) if unnamed else ()
    return _Rule(number, space.condition(entry.condition), endings, fails, left, entry.do in renewing)


def _holds(condition: Condition, state: State) -> bool:
    return all(state[fact] in values for fact, values in condition)
