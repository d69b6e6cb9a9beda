"""Initial conditions and goal of an activity as relations between carried things and furniture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from handcart.files.errors import FileError, Finding
from handcart.files.suggest import suggest

from .definition import Definition
from .goal_option import GoalOption
from .ground_options import ground_options
from .thing_relation import AGENT, ThingRelation, is_floor, is_support, relation_of
from .thing_table import thing_table


@dataclass(frozen=True)
class ActivityRelations:
    """Initial relations of an activity's things to furniture, and the moves that lead to its goal."""

    initial: tuple[ThingRelation, ...]
    moves: tuple[ThingRelation, ...]
    """Final relation of each thing that has to be moved."""
    supports: Mapping[str, str]
    """Term of the support of each piece of furniture, by term of the piece, if the definition states it."""

    def terms(self) -> list[str]:
        """Return the terms (names in the definition) of all furniture and floors with things on, in or next
        to them.

        The order is fixed.
        """
        things = {item.thing for item in self.initial}
        found: dict[str, None] = {}
        for item in (*self.initial, *self.moves):
            beside = item.beside if item.beside not in things else None
            if beside is None:
                found[item.furniture] = None
            else:
                found[beside] = None
        for term, below in self.supports.items():
            if self.stands_on_furniture(term):
                found |= {term: None, below: None}
        return list(found)

    def stands_on_furniture(self, term: str) -> bool:
        """Return whether the furniture with a BDDL term is on another piece of furniture, not on a floor."""
        below = self.supports.get(term)
        return below is not None and not is_floor(below)


def relations_of(definition: Definition) -> ActivityRelations:
    """Return how the things of an activity are related to furniture at the start, and the moves to its goal.

    Raises:
        FileError: the activity needs things that the simulated worlds or robots do not have; it lists all of
            them.
    """
    found = list(_unknown_things(definition))
    initial: list[ThingRelation] = []
    supports: dict[str, str] = {}
    for literal in definition.initial:
        if is_support(definition, literal):
            supports[literal[1]] = literal[2]
            continue
        relation = relation_of(definition, literal)
        if isinstance(relation, Finding):
            found.append(relation)
        elif relation is not None:
            initial.append(relation)
    if found:
        raise FileError(found)
    return ActivityRelations(tuple(initial), _moves(definition, initial, supports), supports)


def _unknown_things(definition: Definition) -> Iterator[Finding]:
    """Yield the categories of unknown size that occur in a condition."""
    table = thing_table()
    used = definition.goal_words() | {word for item in definition.initial for word in item}
    known = {**table.carried, **table.furniture}
    for category, terms in definition.terms.items():
        if category not in (AGENT, *known) and (category in used or used & set(terms)):
            wrong = f"no size is known for {category!r}{suggest(category, known)}"
            yield definition.finding([category], wrong)


def _moves(
    definition: Definition, initial: Iterable[ThingRelation], supports: Mapping[str, str]
) -> tuple[ThingRelation, ...]:
    """Return the shortest list of moves that leads to the goal.

    Raises:
        FileError: nothing has to be moved, or each list of conditions has some that moves cannot reach; with
            the problems of the list that has the fewest.
    """
    best: list[ThingRelation] | None = None
    problems: list[Finding] = []
    for literals in ground_options(definition):
        option = GoalOption(definition, initial, supports)
        for literal in literals:
            option.add(literal)
        moves = option.moves()
        if option.wrong:
            problems = min((problems, option.wrong), key=len) if problems else option.wrong
        elif best is None or len(moves) < len(best):
            best = moves
    if best is None:
        words = "no way to the goal was found; allowed: a goal of ontop, inside and nextto"
        raise FileError(problems or [definition.finding([":goal"], words)])
    if not best:
        words = "nothing has to be moved; allowed: a goal that isn't reached at first"
        raise FileError([definition.finding([":goal"], words)])
    return tuple(best)
