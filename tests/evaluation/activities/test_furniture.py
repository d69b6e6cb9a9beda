"""Furniture of activities: where its surfaces are, things are on or in it as the definitions mean it."""

from __future__ import annotations

import pytest

from handcart.evaluation.activities.furniture import Piece
from handcart.evaluation.activities.thing_table import FurnitureEntry, thing_table
from handcart.evaluation.activities.true_relations import TrueThing, is_inside, is_on_top
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.shapes import Box

POSE = Pose2(2.0, 1.0, 0.5)
CARRYING = [(name, item) for name, item in thing_table().furniture.items() if item.form != "floor"]


def body(piece: Piece) -> TrueThing:
    boxes = [
        Box(piece.in_room(part.x, part.y).lift(part.above + part.size[2] / 2), part.size, part.name)
        for part in piece.parts()
    ]
    return TrueThing(piece.term, tuple(boxes))


@pytest.mark.parametrize(("name", "entry"), CARRYING)
def test_thing_on_each_level_has_the_relation_of_that_level(name: str, entry: FurnitureEntry) -> None:
    piece = Piece("piece", f"{name}_1", entry, POSE)
    for level in piece.levels():
        pose = piece.in_room(level.x, level.y).lift(level.height + 0.05)
        thing = TrueThing("thing", (Box(pose, (0.05, 0.1, 0.1), "thing"),))
        holds = is_inside if level.relation == "inside" else is_on_top
        other = is_on_top if level.relation == "inside" else is_inside
        assert holds(thing, body(piece)), level
        if entry.form != "box":  # on the bottom of an open box, a thing is on top of it as well
            assert not other(thing, body(piece)), level


@pytest.mark.parametrize(("name", "entry"), CARRYING)
def test_parts_of_furniture_have_names_of_their_own(name: str, entry: FurnitureEntry) -> None:
    piece = Piece("piece", f"{name}_1", entry, POSE)
    names = [part.name for part in piece.parts()]
    assert len(names) == len(set(names))
    assert {level.name for level in piece.levels()} <= set(names)


@pytest.mark.parametrize(
    ("name", "entry"), [(name, entry) for name, entry in CARRYING if entry.form == "shelf"]
)
def test_ceiling_of_a_shelf_ends_at_its_top(name: str, entry: FurnitureEntry) -> None:
    """A thinner one let the arm carry a book into the roof of a car."""
    inner = [
        level for level in Piece("piece", f"{name}_1", entry, POSE).levels() if level.relation == "inside"
    ]
    assert inner
    for level in inner:
        assert level.clearance is not None
        assert level.height + level.clearance + level.ceiling == pytest.approx(entry.size_m[2])
