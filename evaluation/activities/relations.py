"""Initial conditions and goal of an activity as relations between carried things and furniture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from handcart.files.errors import FileError, Finding
from handcart.files.suggest import suggest

from .definition import Definition, Literal
from .thing_table import CarriedEntry, FurnitureEntry, thing_table

AGENT = "agent.n.01"
FORMS_OF = {"ontop": ("table", "shelf"), "inside": ("shelf", "box")}
"""Forms of furniture that can have a thing on top or inside."""


class ThingRelation(NamedTuple):
    """A thing is on top of, or inside, a piece of furniture."""

    kind: str
    """`ontop` or `inside`."""
    thing: str
    """Term of the carried thing."""
    furniture: str
    """Term of the furniture."""


@dataclass(frozen=True)
class ActivityRelations:
    """An activity as it is and as it shall be."""

    initial: tuple[ThingRelation, ...]
    moves: tuple[ThingRelation, ...]
    """One for each thing that has to be moved, by where it goes."""

    def terms(self) -> list[str]:
        """Return all furniture that something is on or in, in a fixed order."""
        found = [each.furniture for each in (*self.initial, *self.moves)]
        return list(dict.fromkeys(found))


def relations_of(definition: Definition) -> ActivityRelations:
    """Return the relations of a definition.

    Raises:
        FileError: with everything in it that our worlds or robots do not have.
    """
    found = list(_unknown_things(definition))
    initial: list[ThingRelation] = []
    for literal in definition.initial:
        relation = _relation(definition, literal)
        if isinstance(relation, Finding):
            found.append(relation)
        elif relation is not None:
            initial.append(relation)
    if found:
        raise FileError(found)
    return ActivityRelations(tuple(initial), _moves(definition, initial))


def entry_of(definition: Definition, term: str) -> CarriedEntry | FurnitureEntry | None:
    """Return the size of a thing; None if its category is unknown."""
    category, table = definition.category(term), thing_table()
    return table.carried.get(category) or table.furniture.get(category)


def _unknown_things(definition: Definition) -> Iterator[Finding]:
    """Yield the categories of unknown size that occur in a condition."""
    table = thing_table()
    used = definition.goal_words() | {word for each in definition.initial for word in each}
    known = {**table.carried, **table.furniture}
    for category, terms in definition.terms.items():
        if category not in (AGENT, *known) and (category in used or used & set(terms)):
            wrong = f"no size is known for {category!r}{suggest(category, known)}"
            yield definition.finding([category], wrong)


def _relation(definition: Definition, literal: Literal) -> ThingRelation | Finding | None:
    """Return the relation that a literal states; None for the robot and for furniture on the floor."""
    predicate, *terms = literal
    if predicate not in FORMS_OF or len(terms) != 2:
        words = f"the condition {predicate!r} isn't simulated; allowed: {', '.join(FORMS_OF)}"
        return definition.finding(literal, words)
    thing, other = (entry_of(definition, each) for each in terms)
    on_floor = isinstance(other, FurnitureEntry) and other.form == "floor"
    if definition.category(terms[0]) == AGENT or (isinstance(thing, FurnitureEntry) and on_floor):
        return None
    if thing is None or other is None:
        return None  # reported as an unknown thing
    words = f"{terms[0]} is {predicate} {terms[1]}"
    if isinstance(thing, FurnitureEntry):
        return definition.finding(literal, f"{words}: furniture isn't carried; allowed: on the floor")
    if isinstance(other, CarriedEntry):
        return definition.finding(literal, f"{words}: that isn't furniture; allowed: on or in furniture")
    if other.form not in FORMS_OF[predicate]:
        allowed = f"allowed: {predicate} of a {' or '.join(FORMS_OF[predicate])}"
        return definition.finding(literal, f"{words}: not for the form {other.form!r}; {allowed}")
    return ThingRelation(predicate, terms[0], terms[1])


def _moves(definition: Definition, initial: Sequence[ThingRelation]) -> tuple[ThingRelation, ...]:
    """Return the moves of the way to the goal with the fewest of them.

    Raises:
        FileError: no way consists of such relations alone; with the problems of the nearest one.
    """
    best: tuple[ThingRelation, ...] | None = None
    problems: list[Finding] = []
    for option in ground_options(definition):
        wrong: list[Finding] = []
        moves: dict[str, ThingRelation] = {}
        for literal in option:
            found = _relation(definition, literal)
            if isinstance(found, Finding):
                wrong.append(found)
            elif found is not None and found not in initial:
                if found.thing in moves and moves[found.thing] != found:
                    words = f"{found.thing} would have to be in two places; allowed: in one"
                    wrong.append(definition.finding(literal, words))
                moves[found.thing] = found
        if wrong:
            problems = min((problems, wrong), key=len) if problems else wrong
        elif best is None or len(moves) < len(best):
            best = tuple(moves.values())
    if best is None:
        words = "no way to the goal was found; allowed: a goal of ontop and inside"
        raise FileError(problems or [definition.finding([":goal"], words)])
    return best


def ground_options(definition: Definition) -> Iterator[list[Literal]]:
    """Yield the ways to the goal that `bddl` finds, each as ground literals; it lists a few of many."""
    from bddl.activity import get_goal_conditions, get_ground_goal_state_options, get_object_scope
    from bddl.trivial_backend import TrivialBackend

    conditions, backend = definition.conditions, TrivialBackend()
    scope: dict[str, Any] = get_object_scope(conditions)
    scope.update({term: term for term in scope})
    goal = get_goal_conditions(conditions, backend, scope)
    try:
        options = get_ground_goal_state_options(conditions, backend, scope, goal)
    except AssertionError:  # its only report of a goal without any way
        return
    for option in options:
        yield [_flat(each.body) for each in option]


def _flat(body: Iterable[Any]) -> Literal:
    predicate, *rest = body
    if predicate == "not":
        return ("not", *_flat(rest[0]))
    return (predicate, *(each.lstrip("?") for each in rest))
