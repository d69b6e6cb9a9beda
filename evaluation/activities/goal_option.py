"""One way to the goal of an activity, as moves of single things."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from handcart.files.errors import Finding

from .bddl_judge import PREDICATES
from .definition import Definition, Literal
from .thing_relation import ThingRelation, entry_of, is_floor, is_support, relation_of
from .thing_table import CarriedEntry, FurnitureEntry


class GoalOption:
    """One of several alternatives for an activity's goal, a set of conditions that must hold together.

    `add` takes the conditions one by one; `moves` then returns the things that have to be moved, and where.
    """

    def __init__(
        self, definition: Definition, initial: Iterable[ThingRelation], supports: Mapping[str, str]
    ) -> None:
        """Begin without a condition.

        Args:
            definition: the activity.
            initial: where things are at first.
            supports: term of the support of each piece of furniture, by term of the piece.
        """
        self._definition, self._initial, self._supports = definition, tuple(initial), supports
        self._places: dict[str, ThingRelation] = {}
        self._barred: list[tuple[Literal, ThingRelation]] = []
        self._beside: dict[str, tuple[str, Literal]] = {}
        self.wrong: list[Finding] = []
        """Conditions that can't be reached by moves of single things."""

    def add(self, literal: Literal) -> None:
        """Add a condition to this goal; if moving things one by one cannot fulfil it, add a finding to
        `wrong` instead.
        """
        if is_support(self._definition, literal):
            if self._supports.get(literal[1], literal[2]) != literal[2]:
                self._report(literal, f"{literal[1]} is furniture, which isn't carried")
        elif literal[0] == "not":
            self._add_barred(literal)
        elif literal[0] == "nextto":
            self._add_beside(literal)
        else:
            found = relation_of(self._definition, literal)
            if isinstance(found, Finding):
                self.wrong.append(found)
            elif found is not None:
                other = self._places.setdefault(found.thing, found)
                if other != found:
                    self._report(literal, f"{found.thing} would have to be in two places")

    def moves(self) -> list[ThingRelation]:
        """Return the final relation to furniture of each thing that must be moved to reach the goal.

        Conditions that contradict each other are reported in `wrong`.
        """
        for thing, (other, literal) in self._beside.items():
            self._settle(thing, other, literal)
        for literal, barred in self._barred:
            place = self._places.get(barred.thing) or self._at_first(barred.thing)
            if place is not None and (place.kind, place.furniture) == (barred.kind, barred.furniture):
                self._report(literal, f"{barred.thing} would have to be there and not there")
        return [relation for relation in self._places.values() if relation not in self._initial]

    def _add_barred(self, literal: Literal) -> None:
        _, predicate, thing, *_ = literal
        if predicate not in PREDICATES:
            words = f"the condition {predicate!r} isn't simulated; allowed: {', '.join(PREDICATES)}"
            self.wrong.append(self._definition.finding(literal, words))
            return
        is_furniture = isinstance(entry_of(self._definition, thing), FurnitureEntry)
        if is_furniture and predicate != "nextto" and not is_support(self._definition, literal[1:]):
            return  # it isn't there at first, and isn't moved
        found = relation_of(self._definition, literal[1:])
        if isinstance(found, Finding):
            self._report(literal, f"the opposite of {literal[1]!r} isn't planned for {literal[2]}")
        elif found is not None:
            self._barred.append((literal, found))

    def _add_beside(self, literal: Literal) -> None:
        """Note which thing has to be put next to something: the second one of two things."""
        _, one, other = literal
        first, second = (entry_of(self._definition, item) for item in (one, other))
        if first is None or second is None:
            return  # reported as an unknown thing
        thing, target = (one, other) if isinstance(first, CarriedEntry) else (other, one)
        if not isinstance(entry_of(self._definition, thing), CarriedEntry):
            self._report(literal, f"{one} and {other} are furniture, which isn't carried")
        elif thing in self._beside and self._beside[thing][0] != target:
            self._report(literal, f"{thing} would have to be next to two things")
        else:
            self._beside[thing] = (target, literal)

    def _settle(self, thing: str, other: str, literal: Literal) -> None:
        """Give a thing a place next to another thing or a piece of furniture."""
        place = self._places.get(thing)
        if isinstance(entry_of(self._definition, other), FurnitureEntry):
            floor = self._supports.get(other) or (place.furniture if place is not None else None)
            if floor is None or not is_floor(floor):
                self._report(literal, f"{other} isn't on a floor")
            elif place is not None and (place.kind, place.furniture) != ("ontop", floor):
                self._report(literal, f"{thing} isn't on the floor next to {other}")
            else:
                self._places[thing] = ThingRelation("ontop", thing, floor, other)
            return
        target = self._places.get(other)
        if place is None or target is None or place[2] != target[2] or place[0] != target[0]:
            self._report(literal, f"{thing} and {other} aren't moved to one piece of furniture")
        elif place in self._initial or target in self._initial:
            self._report(literal, f"{thing} or {other} isn't moved")
        else:
            self._places[thing] = place._replace(beside=other)

    def _at_first(self, thing: str) -> ThingRelation | None:
        return next((item for item in self._initial if item.thing == thing), None)

    def _report(self, literal: Literal, words: str) -> None:
        allowed = "allowed: a way to the goal by moves of single things"
        self.wrong.append(self._definition.finding(literal, f"{words}; {allowed}"))
