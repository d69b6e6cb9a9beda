"""Things of an activity in a simulated world, by the terms of its definition."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from handcart.primitives.activities.activity import ActivityFile
from handcart.primitives.objects.knowledge.object_names import name_in_world
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box

from .definition import Definition
from .thing_relation import AGENT
from .thing_table import thing_table
from .true_relations import TrueThing

if TYPE_CHECKING:
    from handcart.backends.simulation.world.scene import Scene

FLOOR = Box(transform((0.0, 0.0, -0.5)), (1000.0, 1000.0, 1.0), "floor")


def true_things(definition: Definition, file: ActivityFile, scene: Scene) -> Mapping[str, TrueThing]:
    """Return the true bodies of an activity's things, floors and robot, by their terms in the definition."""
    solids = {solid.box.name: solid.box for solid in scene.solids}
    bodies = {thing.name: thing.box() for thing in scene.things()}
    found: dict[str, TrueThing] = {}
    for term, parts in file.furniture.items():
        boxes = tuple(solids[part] for part in parts if part in solids)
        if boxes:
            found[term] = TrueThing(term, boxes)
    for term, name in file.objects.items():
        if name_in_world(name) in bodies:
            found[term] = TrueThing(term, (bodies[name_in_world(name)],))
    for category, terms in definition.terms.items():
        entry = thing_table().furniture.get(category)
        if entry is not None and entry.form == "floor":
            found |= {term: TrueThing(term, (_floor(file, term),)) for term in terms}
        elif category == AGENT:
            base = Box(scene.base.lift(0.2), (0.4, 0.4, 0.4), "robot")
            found |= {term: TrueThing(term, (base,)) for term in terms}
    return found


def _floor(file: ActivityFile, term: str) -> Box:
    """Return what a floor's term means: a part of the floor, or all of it."""
    if term not in file.floors:
        return FLOOR
    x0, y0, x1, y1 = file.floors[term]
    return Box(transform(((x0 + x1) / 2, (y0 + y1) / 2, -0.5)), (x1 - x0, y1 - y0, 1.0), "floor")
