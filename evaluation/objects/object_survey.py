"""Figures of fetching and carrying, by the ground truth."""

from __future__ import annotations

import math
from typing import ClassVar

from typing_extensions import override

from handcart.backends.simulation.objects.object_props import ObjectProps
from handcart.backends.simulation.world.thing import Rest
from handcart.evaluation.judging.survey import FiguresSurvey
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.objects.knowledge.object_names import name_in_world
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.place_object import PlaceObject
from handcart.primitives.outcomes.outcome import Outcome, Success

from .object_effects import OBJECT_EFFECTS, SPOT_MM, sighting_errors, thing_of, true_surface


class ObjectSurvey(FiguresSurvey):
    """Evaluation of tasks that move objects, by errors of sighted and placed poses and by objects that fell
    down.
    """

    name = "objects"
    effects = OBJECT_EFFECTS
    limits: ClassVar = {"placed_off_mm": SPOT_MM}
    shown: ClassVar = frozenset({"LOOK_FOR", "PICK", "PLACE", "HAND_OVER"})

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        if isinstance(outcome, Success):
            name = primitive.thing(self.run.model.view(primitive)).removeprefix(name_in_world(""))
            if isinstance(primitive, PlaceObject):
                self._note_placed(primitive, name)
            elif primitive.label() == "LOOK_FOR":
                self._note_sighting("look", str(getattr(primitive, "object", "")))
        return []

    def faults(self) -> list[str]:
        """Return a message for each object that has fallen to the floor."""
        things = self.run.world.of(ObjectProps).things()
        return [f"{thing.name} has fallen" for thing in things if thing.rest is Rest.FLOOR]

    def _note_sighting(self, what: str, name: str) -> None:
        thing, seen = thing_of(self, name), self.run.model.of(Objects).seen(name)
        if thing is not None and seen is not None:
            off, turned = sighting_errors(thing, seen)
            self._figures[f"{what}_off_mm"] = round(off, 2)
            self._figures[f"{what}_off_deg"] = round(turned, 2)

    def _note_placed(self, primitive: PlaceObject, name: str) -> None:
        """Note how far the object is from its spot; without one, how far from where it was seen."""
        self._note_sighting("placed_seen", name)
        thing = thing_of(self, name)
        surface = true_surface(self, primitive.surface)
        if thing is not None and primitive.spot is not None:
            spot = surface.spots[primitive.spot]
            x, y = thing.pose[:2, 3].tolist()
            self._figures["placed_off_mm"] = round(1e3 * math.hypot(x - spot.x_m, y - spot.y_m), 2)
            if spot.heading_deg is not None:
                yaw = math.atan2(thing.pose[1, 0], thing.pose[0, 0])
                turned = math.remainder(yaw - spot.pose.theta, 2.0 * math.pi)
                self._figures["placed_turn_deg"] = round(abs(math.degrees(turned)), 2)
