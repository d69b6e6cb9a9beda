"""Rooms of activities: by BEHAVIOR-1K's evaluator, they begin and end as the definition says."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

pytest.importorskip("bddl", reason="the package bddl isn't installed: pip install 'handcart[bddl]'")

from handcart.evaluation.activities.bddl_judge import judge_goal
from handcart.evaluation.activities.definition import Definition, load_definition
from handcart.evaluation.activities.ground_options import ground_options
from handcart.evaluation.activities.listing import ListedActivity, summary_lines
from handcart.evaluation.activities.making import plan_activity
from handcart.evaluation.activities.room import Room
from handcart.evaluation.activities.slots import ThingSlot
from handcart.evaluation.activities.thing_table import thing_table
from handcart.evaluation.activities.true_relations import TrueThing
from handcart.files.errors import FileError
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box

from .judged_start import start_holds

ACTIVITIES = (
    "bringing_in_kindling",  # next to a fireplace, on another floor
    "collecting_wood",  # from one floor to another
    "hiding_Easter_eggs",  # out of a basket, next to a tree, with a condition that must not hold
    "make_the_ultimate_spa_basket",  # into a basket on a table
    "packing_books_into_car",  # out of a bag that is not carried
    "putting_meal_in_fridge_at_work",  # from a plate on a table
)


def true_state(definition: Definition, room: Room, slots: Mapping[str, ThingSlot]) -> dict[str, TrueThing]:
    """Return everything where the room has it, and things in their slots."""
    found: dict[str, TrueThing] = {}
    for piece in room.pieces:
        parts = [
            Box(piece.in_room(part.x, part.y).lift(part.above + part.size[2] / 2), part.size, part.name)
            for part in piece.parts()
        ]
        if parts:
            found[piece.term] = TrueThing(piece.term, tuple(parts))
    for term, slot in slots.items():
        x, y, z = (side / 1e3 for side in room.sizes[term].size_mm)
        found[term] = TrueThing(term, (Box(slot.pose.lift(slot.level.height + z / 2), (x, y, z), term),))
    for category, terms in definition.terms.items():
        entry = thing_table().furniture.get(category)
        for term in terms if entry is not None and entry.form == "floor" else ():
            x0, y0, x1, y1 = room.floors.get(term, (-50.0, -50.0, 50.0, 50.0))
            pose = transform(((x0 + x1) / 2, (y0 + y1) / 2, -0.5))
            found[term] = TrueThing(term, (Box(pose, (x1 - x0, y1 - y0, 1.0), term),))
        if category == "agent.n.01":
            body = Box(room.home.lift(0.2), (0.4, 0.4, 0.4), "robot")
            found |= {term: TrueThing(term, (body,)) for term in terms}
    return found


@pytest.mark.parametrize("name", ACTIVITIES)
def test_room_begins_and_ends_as_the_definition_says(name: str) -> None:
    definition, room, _ = plan_activity(name, 0, "librarian", False)
    begun = true_state(definition, room, room.at_first)
    assert start_holds(definition, begun)
    assert not judge_goal(definition, begun).holds
    assert judge_goal(definition, true_state(definition, room, {**room.at_first, **room.at_end})).holds


def test_nextto_of_a_goal_is_not_read_as_ontop() -> None:
    """bddl's own backend for names calls it ontop."""
    options = list(ground_options(load_definition("store_baking_soda")))
    assert {literal[0] for literal in options[0]} == {"inside", "nextto"}


def test_neighbours_without_room_for_the_fingers_are_refused() -> None:
    with pytest.raises(FileError, match="only with gaps up to 19 mm; allowed: at least 30 mm"):
        plan_activity("store_baking_soda", 0, "librarian", False)


def test_thing_that_stays_but_no_finger_gets_around_is_refused() -> None:
    """A file of objects with it would be refused."""
    with pytest.raises(FileError, match=r"hand_blower.*no side narrow enough for the fingers: 90 mm"):
        plan_activity("dispose_of_batteries", 0, "librarian", False)


def test_furniture_that_has_to_be_carried_is_refused() -> None:
    with pytest.raises(FileError, match=r"furniture(, which)? isn't carried"):
        plan_activity("putting_away_games", 0, "librarian", False)


def test_condition_that_must_not_hold_has_to_be_simulated() -> None:
    """The refrigerator has to be closed in the end: the judge broke on it after the run."""
    with pytest.raises(FileError, match="the condition 'open' isn't simulated; allowed: ontop, inside"):
        plan_activity("bringing_water", 0, "librarian", False)


def test_list_counts_reasons_once_for_each_activity() -> None:
    no_size = "no size is known for 'rag.n.01'; did you mean 'bag.n.06'? allowed: book.n.02"
    twice = ("box.n.01_1 is too wide: 9 mm; allowed: less", "box.n.01_2 is too wide: 9 mm; allowed: less")
    listed = [ListedActivity("a", 3, ()), ListedActivity("b", 0, (no_size,)), ListedActivity("c", 0, twice)]
    lines = "\n".join(summary_lines(listed))
    assert "1 of 3 activities can be made" in lines
    assert "   1  no size is known for 'rag.n.01'\n" in lines
    assert "   1  box.n.01 is too wide: 9 mm" in lines
