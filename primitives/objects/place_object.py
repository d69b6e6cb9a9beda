"""PLACE: put the held object down on a surface."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from typing import ClassVar

import numpy as np
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import AnyCamera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.files.suggest import suggest
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import move_straight
from handcart.primitives.motions.felt_force import awaited_force
from handcart.primitives.motions.grip import open_to
from handcart.primitives.motions.pushing import push, relax
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.objects.holding.carrying import stow
from handcart.primitives.objects.holding.placing_plan import (
    FOOT_MARGIN_M,
    RELEASE_CLEARANCE_M,
    PlannedPlacing,
    free_spots,
    plan_placing,
    showing_tags,
    turned,
    withdrawn,
)
from handcart.primitives.objects.knowledge.object_names import SpotName, SurfaceName, name_in_world
from handcart.primitives.objects.knowledge.objects import HeldObject, Objects, ObjectSighting
from handcart.primitives.objects.looking.object_look import (
    ObjectLook,
    conclude,
    look_closely,
    sighting,
)
from handcart.primitives.objects.looking.spot_look import HIDDEN, why_not_free
from handcart.primitives.objects.looking.tag_readings import Located, locate
from handcart.primitives.objects.site.object_site import (
    base_T_map,
    held_box,
    kind_of,
    surface_of,
)
from handcart.primitives.objects.site.roomy_motion import move_with_room, surroundings_to_try
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.preconditions.hand_use import LETS_GO
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Snapshot, settle
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, raised

FAST_M_S, SLOW_M_S = 0.08, 0.015
GUARDED_M = 0.015  # over the goal, where slow lowering begins
DESCENT_MAX_FORCE_N = 6.0
TOUCHDOWN_FORCE_N = 3.0
OVERTRAVEL_M = 0.015  # below the goal, where an object touches down at the latest
MAX_OFF_M = 0.020  # of the placed object from its goal
MAX_MOVED_M = 0.015  # of other objects
MAX_SPOTS = 8  # that are looked at


class PlaceObject(ActionPrimitive):
    """Put the held object down at a named spot, or at a free spot that the camera finds.

    A picture shows whether the spot is free. The object is lowered until it touches down; the fingers let
    it go, and the hand withdraws the way it came from. A look from nearby measures its pose, and
    whether other objects have moved.
    """

    surface: SurfaceName
    """Name of the surface on which the object is put."""
    spot: SpotName | None = None
    """Named spot of the surface (default: any free one)."""
    stow: bool = True
    """Bring the arm home in the end, as it must be before the base drives away."""

    needs: ClassVar = (Arm, Gripper, AnyCamera)
    reads: ClassVar = ("map", "sensed_cells", "objects", "detectors")
    writes: ClassVar = ("sightings", "held_object", "surface_poses", "places")
    hand: ClassVar = LETS_GO

    _before: HeldObject | None = PrivateAttr(default=None)
    _known: tuple[ObjectSighting, ...] = PrivateAttr(default=())
    _stands: Located | None = PrivateAttr(default=None)
    _goal: tuple[float, float] = PrivateAttr(default=(math.inf, math.inf))

    @override
    @classmethod
    def label(cls) -> str:
        return "PLACE"

    @override
    def thing(self, model: ModelView) -> str:
        held = model.of(Objects).held_object or self._before
        return "" if held is None else name_in_world(held.object)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return why the object can't be put on the surface; empty if it can."""
        objects = model.of(Objects)
        held, surface = objects.held_object, objects.objects.surfaces.get(self.surface)
        if held is None or surface is None:
            return "no object was picked" if held is None else f"unknown surface {self.surface!r}"
        if self.spot is not None and self.spot not in surface.spots:
            return f"{self.surface} has no spot {self.spot!r}{suggest(self.spot, surface.spots)}"
        kind = objects.objects.objects[held.object].kind
        return "" if surface.allows(kind) else f"no {kind} may stand on {self.surface}"

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        objects = model.of(Objects)
        held = objects.held_object
        assert held is not None  # the precondition
        self._before, self._known = held, objects.sightings
        kind = kind_of(model, held.object)
        yield from model.of(Objects).measure(robot, model, self.surface, self.found)
        plan = yield from self._planned(robot, model, kind, held)
        yield from move_with_room(robot, model, plan.above, held_box(kind, held.hand_T_object))
        yield from self._lower(robot, plan.base_T_hand)
        yield from self.intend(f"the fingers let {held.object} go")
        yield from open_to(robot, robot.gripper.width() + RELEASE_CLEARANCE_M)
        objects.held_object = None
        yield from move_straight(robot, withdrawn(robot.base_T("hand")))
        yield from self._verify(robot, model, held.object, plan.base_T_object)
        if self.stow:
            yield from stow(robot, model)

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the object was seen at its goal, and the fingers press on nothing."""
        return self._stands is not None and not robot.gripper.closed_on_something()
        yield

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Return the allowed contacts: of the hand with the object, and of the object with its surface."""
        held = model.of(Objects).held_object or self._before
        if held is None:
            return ()
        touched: tuple[str, ...] = (self.surface,)
        if self.surface in model.of(Objects).objects.surfaces:
            radius = model.of(Objects).objects.kind_of(held.object).foot_radius
            touched = model.of(Objects).touched_names(self.surface, *self._goal, radius)
        hand = MeantContact("hand", name_in_world(held.object))
        return hand, *(MeantContact("held", name) for name in touched)

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Retrace the motion to the start in reverse; an object that was released is gripped again on the
        way.
        """
        yield from retrace(robot, start, trace)
        objects = model.of(Objects)
        if self._before is not None:
            objects.held_object, objects.sightings = self._before, self._known

    def _planned(
        self, robot: Robot, model: ModelView, kind: ObjectKind, held: HeldObject
    ) -> Generator[None, None, PlannedPlacing]:
        """Look at spots, the named one or the nearest ones, until one is free and within reach."""
        surface = surface_of(model, self.surface)
        looked = reached = 0
        why = "nothing of it is free of known objects"
        for place, any_heading in self._candidates(robot, model, surface, kind):
            to_base = base_T_map(robot)
            every = [np.asarray(to_base @ item) for item in turned(place, surface.height_m, any_heading)]
            goals = showing_tags(every, model.of(Objects).objects.tags_of(held.object))
            plan = yield from self._plan_at(robot, model, kind, held, goals)
            if plan is None:
                why = "the arm doesn't reach it freely"
                continue
            reached += 1
            looked += 1
            spot = self.surface, surface, kind, plan.base_T_object
            why = yield from why_not_free(robot, model, self.evidence, *spot)
            if not why:
                self.found(spots_looked_at=looked)
                self._goal = (place.x, place.y)
                return plan
            if looked >= MAX_SPOTS:
                break
        name = f"the spot {self.spot!r} of {self.surface}" if self.spot else f"any spot of {self.surface}"
        seen = Measured("Camera", f"of {looked} spots looked at those that are free", 0, 1)
        if not reached:
            raise Discrepancy(f"{name} can't be used: {why}", measured=seen, cause=causes.OUT_OF_REACH)
        if why == HIDDEN:
            raise Discrepancy(f"{name} can't be used: {why}", measured=seen, cause=causes.NOT_SEEN)
        raise Discrepancy(f"{name} can't be used: {why}", measured=seen, cause=causes.OCCUPIED)

    def _plan_at(
        self,
        robot: Robot,
        model: ModelView,
        kind: ObjectKind,
        held: HeldObject,
        goals: Sequence[Transform],
    ) -> Generator[None, None, PlannedPlacing | None]:
        """Plan to put the object down at one of several poses, away from walls if there is room; None if none
        is free.

        Args:
            robot: its hand holds the object.
            model: knows surfaces and objects.
            kind: kind of the object.
            held: the object in the hand.
            goals: (4, 4) base_T_object of the poses.
        """
        for around in surroundings_to_try(robot, model):
            plan = yield from robot.compute(plan_placing, robot, kind, held.hand_T_object, goals, around)
            if plan is not None:
                return plan
        return None

    def _candidates(
        self, robot: Robot, model: ModelView, surface: ObjectSurface, kind: ObjectKind
    ) -> list[tuple[Pose2, bool]]:
        """Return candidate poses on the map, clear of known objects, and whether any heading will do."""
        if self.spot is not None:
            spot = surface.spots[self.spot]
            return [(spot.pose, spot.heading_deg is None or kind.is_round)]
        radius = kind.foot_radius
        taken = [
            (object_sighting.pose, kind_of(model, object_sighting.object).foot_radius)
            for object_sighting in model.of(Objects).sightings
            if object_sighting.surface == self.surface
        ]
        ahead = robot.pose.apply(np.array([[robot.spec.footprint_radius_m + 0.2, 0.0]]))[0]
        return [
            (Pose2(x, y, robot.pose.theta), True)
            for x, y in free_spots(surface, radius, (float(ahead[0]), float(ahead[1])))
            if all(
                math.hypot(x - pose.x, y - pose.y) > radius + other + FOOT_MARGIN_M for pose, other in taken
            )
        ]

    def _lower(self, robot: Robot, base_T_hand: Transform) -> Periods:
        """Go down until the object touches; the forces are those beyond its weight."""
        yield from settle(robot)
        weight = -float((robot.base_T("hand")[:3, :3] @ (yield from awaited_force(robot)))[2])
        pushed = yield from push(
            robot, raised(base_T_hand, GUARDED_M), FAST_M_S, DESCENT_MAX_FORCE_N - weight
        )
        if pushed.met:
            felt = Measured("Arm", "force that resists", pushed.force + weight, DESCENT_MAX_FORCE_N, "N")
            raise Discrepancy("something is in the way of the object", measured=felt, cause=causes.OCCUPIED)
        pushed = yield from push(
            robot, raised(base_T_hand, -OVERTRAVEL_M), SLOW_M_S, TOUCHDOWN_FORCE_N - weight
        )
        if not pushed.met:
            felt = Measured("Arm", "force that resists", pushed.force + weight, TOUCHDOWN_FORCE_N, "N")
            raise Discrepancy(
                f"the object doesn't touch down on {self.surface}", measured=felt, cause=causes.NO_SUPPORT
            )
        self.found(touched_mm=round(1e3 * float(robot.base_T("hand")[2, 3] - base_T_hand[2, 3]), 2))
        yield from relax(robot)

    def _verify(self, robot: Robot, model: ModelView, name: str, goal: Transform) -> Periods:
        """Measure the pose of the placed object, meant to be base_T_object `goal` (4, 4), and whether others
        moved.

        Raises:
            Discrepancy: it isn't where it should be.
            NeedsPerson: another object was moved.
        """
        look, objects = ObjectLook(), model.of(Objects)
        yield from look_closely(robot, model, name, goal, look, self.evidence)
        yield from look.understand(robot, model, self.surface)
        found = conclude(robot, model, name, self.surface, look, goal)
        off = float(np.linalg.norm(found.base_T_object[:2, 3] - goal[:2, 3]))
        self.found(off_goal_mm=round(1e3 * off, 2))
        if exceeds(off, MAX_OFF_M):
            apart = Measured("Camera", "object off its goal", 1e3 * off, 1e3 * MAX_OFF_M, "mm")
            raise Discrepancy(f"{name} is next to its goal", measured=apart, cause=causes.MISPLACED)
        self._stands = found
        seen = sighting(robot, model, name, self.surface, found)
        objects.sightings = (*objects.without(name), seen)
        yield from self._check_others(robot, model, look)

    def _check_others(self, robot: Robot, model: ModelView, look: ObjectLook) -> Periods:
        """Compare other objects that were seen too with where they were; one that seems to have moved is
        looked at from nearby before a person is asked.

        Raises:
            NeedsPerson: one of them was moved or has fallen over.
        """
        surface = surface_of(model, self.surface)
        for other in self._known:
            if other.surface != self.surface or not look.of(other.object):
                continue
            if self._moved(robot, model, other, look) is None:
                continue
            expected, near = base_T_map(robot) @ other.pose.lift(surface.height_m), ObjectLook()
            try:
                yield from look_closely(robot, model, other.object, expected, near, self.evidence)
            except Discrepancy:
                near = look
            moved = self._moved(robot, model, other, near)
            if moved is not None:
                raise moved

    def _moved(
        self, robot: Robot, model: ModelView, other: ObjectSighting, look: ObjectLook
    ) -> NeedsPerson | None:
        """Return the error if another object isn't seen where it was; None if it is."""
        surface, reads = surface_of(model, self.surface), look.of(other.object)
        found = locate(reads, kind_of(model, other.object), surface) if reads else None
        if not isinstance(found, Located):
            return NeedsPerson(f"{other.object} is not in its earlier pose", cause=causes.MISPLACED)
        expected = base_T_map(robot) @ other.pose.lift(surface.height_m)
        off = float(np.linalg.norm(found.base_T_object[:2, 3] - expected[:2, 3]))
        if not exceeds(off, MAX_MOVED_M):
            return None
        moved = Measured("Camera", "another object off its place", 1e3 * off, 1e3 * MAX_MOVED_M, "mm")
        return NeedsPerson(f"{other.object} was moved", moved, cause=causes.MISPLACED)
