"""The doors and drawers of a simulated world."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import ClassVar

from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.grasp import Pads, fits
from handcart.backends.simulation.world.hand_rule import HandRule
from handcart.backends.simulation.world.props import Props
from handcart.backends.simulation.world.solids import MIN_BODY_HEIGHT_M, FloorPlan, Solid
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.arm_model import ArmModel

from .door_part import FRONT, HANDLE, DoorPart, middle_of, new_part, part_at
from .door_rule import DoorRule
from .spec import DoorsSection


class DoorProps(Props[DoorsSection]):
    """Doors and drawers of a simulated world by name, each a front and a handle on one hinge or slide."""

    section = DoorsSection
    STATE: ClassVar[Kinds] = {"parts": dict[str, DoorPart], "openings": dict[str, float]}

    @override
    def set_up(self) -> None:
        self.parts = {
            part.name: part
            for spec in self.spec.doors
            for part in (new_part(spec, kind, spec.opened) for kind in (FRONT, HANDLE))
        }
        self.openings = {spec.name: spec.opened for spec in self.spec.doors}
        self._plan: tuple[tuple[float, ...], FloorPlan] | None = None
        self.scene.changes += 1

    @override
    def things(self) -> Iterable[DoorPart]:
        return self.parts.values()

    @override
    def hand_rule(self, arm: ArmModel) -> HandRule | None:
        if not self.parts:
            return None
        return DoorRule(self.scene, arm, self.opening_of, self.put, lambda: self.base_gap(self.scene.base))

    @override
    def base_gap(self, base: Pose2) -> tuple[float, str]:
        if not self.parts:
            return math.inf, ""
        key = tuple(self.openings.values())
        if self._plan is None or self._plan[0] != key:
            solids = [Solid(part.box()) for part in self.parts.values()]
            self._plan = key, FloorPlan(solids, MIN_BODY_HEIGHT_M, self.scene.robot.body_height)
        return self._plan[1].gap(base, self.scene.robot.footprint_shape, self.scene.time)

    @override
    def fits(self, thing: Thing, pads: Pads) -> bool:
        return isinstance(thing, DoorPart) and thing.is_handle and fits(thing, pads)

    @override
    def let_go(self, thing: Thing) -> None:
        thing.rest = Rest.TABLE

    @override
    def rested(self, thing: Thing) -> None:
        thing.rest = Rest.TABLE
        self._note_opening(thing)

    @override
    def taken(self, thing: Thing) -> None:
        super().taken(thing)
        self._note_opening(thing)

    def opening_of(self, name: str) -> float:
        """Return the present opening of the door called `name` in [rad], or of a drawer in [m]; 0 is
        closed.
        """
        return self.openings[name]

    def put(self, name: str, opening: float) -> None:
        """Set the opening of a door, and move its front and handle there; only in a world without physics.

        Args:
            name: name of the door in the world's file.
            opening: opening in [rad], or of a drawer in [m].
        """
        spec = self.parts[f"{FRONT} {name}"].spec
        self.openings[name] = opening
        for part in (FRONT, HANDLE):
            self.parts[f"{part} {name}"].pose = part_at(spec, part, opening)
        self.scene.changes += 1

    def _note_opening(self, thing: Thing) -> None:
        if isinstance(thing, DoorPart) and thing.is_handle:
            self.openings[thing.spec.name] = thing.spec.true_joint().opening_at(middle_of(thing))
