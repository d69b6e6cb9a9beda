"""Relation of a carried thing to furniture, as a condition of an activity states it."""

from __future__ import annotations

from typing import NamedTuple

from handcart.files.errors import Finding

from .definition import Definition, Literal
from .thing_table import CarriedEntry, FurnitureEntry, thing_table

AGENT = "agent.n.01"
FORMS_OF = {"ontop": ("table", "shelf", "tray", "floor"), "inside": ("shelf", "box")}
"""Forms of furniture that can have a thing on top or inside."""
STANDING_FORMS = ("box", "tray")
"""Forms of furniture that may be on top of another piece."""


class ThingRelation(NamedTuple):
    """Relation of a carried thing that is on top of, or inside, a piece of furniture."""

    kind: str
    """`ontop` or `inside`."""
    thing: str
    """Term of the carried thing."""
    furniture: str
    """Term of the furniture, or of the floor."""
    beside: str | None = None
    """Term of a thing or a piece of furniture that it has to be next to."""


def entry_of(definition: Definition, term: str) -> CarriedEntry | FurnitureEntry | None:
    """Return the entry with the size of a thing or piece of furniture; None if its category is unknown.

    Args:
        definition: definition of a BDDL activity, which assigns a category to each term.
        term: name of the thing or piece of furniture in the definition.
    """
    category, table = definition.category(term), thing_table()
    return table.carried.get(category) or table.furniture.get(category)


def is_floor(term: str) -> bool:
    """Return whether a term of BDDL, such as `floor.n.01_1`, names a floor, a lawn or the like."""
    entry = thing_table().furniture.get(term.rpartition("_")[0])
    return entry is not None and entry.form == "floor"


def is_support(definition: Definition, literal: Literal) -> bool:
    """Return whether a condition (literal) of an activity states that furniture is on a floor or other
    furniture.
    """
    predicate, *terms = literal
    if predicate != "ontop" or len(terms) != 2:
        return False
    upper, lower = (entry_of(definition, term) for term in terms)
    if not isinstance(upper, FurnitureEntry) or not isinstance(lower, FurnitureEntry):
        return False
    return lower.form == "floor" or (lower.form == "table" and upper.form in STANDING_FORMS)


def relation_of(definition: Definition, literal: Literal) -> ThingRelation | Finding | None:
    """Return the relation of a thing to furniture that a condition (literal) of an activity states.

    Returns:
        The relation, or a finding if the simulated worlds do not support it. None for a literal about the
        robot or about a thing of unknown size, for which the caller reports a finding.
    """
    predicate, *terms = literal
    if predicate not in FORMS_OF or len(terms) != 2:
        words = f"the condition {predicate!r} isn't simulated; allowed: {', '.join(FORMS_OF)}"
        return definition.finding(literal, words)
    thing, other = (entry_of(definition, term) for term in terms)
    if definition.category(terms[0]) == AGENT:
        return None
    if thing is None or other is None:
        return None  # reported as an unknown thing
    words = f"{terms[0]} is {predicate} {terms[1]}"
    if isinstance(thing, FurnitureEntry):
        return definition.finding(literal, f"{words}: furniture isn't carried; allowed: where it is at first")
    if isinstance(other, CarriedEntry):
        return definition.finding(literal, f"{words}: that isn't furniture; allowed: on or in furniture")
    if other.form not in FORMS_OF[predicate]:
        allowed = f"allowed: {predicate} of a {' or '.join(FORMS_OF[predicate])}"
        return definition.finding(literal, f"{words}: not for the form {other.form!r}; {allowed}")
    return ThingRelation(predicate, terms[0], terms[1])
