"""PICK: take a seen object off its surface."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import AnyCamera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import move_straight
from handcart.primitives.motions.felt_force import awaited_force
from handcart.primitives.motions.grip import close, holds, open_to, width_off
from handcart.primitives.motions.pushing import push
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.holding.carrying import stow
from handcart.primitives.objects.holding.clearing import lift_clear
from handcart.primitives.objects.holding.grasp_plan import (
    LIFT_M,
    OPENING_CLEARANCE_M,
    PlannedGrasp,
    gripped,
    plan_grasps,
)
from handcart.primitives.objects.holding.placing_plan import goals_on, plan_placing, showing_tags
from handcart.primitives.objects.knowledge.object_names import (
    ObjectName,
    SpotName,
    SurfaceName,
    name_in_world,
)
from handcart.primitives.objects.knowledge.objects import HeldObject, Objects, ObjectSighting
from handcart.primitives.objects.looking.depth_readings import obstacles
from handcart.primitives.objects.looking.object_look import ObjectLook, base_T_top, conclude, look_closely
from handcart.primitives.objects.looking.tag_readings import Located
from handcart.primitives.objects.site.object_site import (
    base_T_map,
    held_box,
    kind_of,
    surface_of,
)
from handcart.primitives.objects.site.roomy_motion import move_with_room, rooms, surroundings_to_try
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.preconditions.hand_use import TAKES_OBJECT
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import MIN_HELD_WIDTH_M, Seen, Snapshot, settle
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.numerics.arrays import FloatArray

GRASP_SPEED_M_S = 0.10
GRASP_TOUCH_FORCE_N = 6.0  # more means that a finger is on the object
WIDTH_TOLERANCE_M = 0.003
MAX_SHIFT_M = 0.06  # between where it was seen before and where it is now
MIN_WEIGHT_ERROR_N = 1.0  # of the weight that is felt
MAX_WEIGHT_ERROR_SHARE = 0.5  # of the weight in the file
WEIGHING_PERIODS = 5
GRAVITY_M_S2 = 9.81


class Pick(ActionPrimitive):
    """Take an object that was seen before; keep it upright if its kind demands that.

    A close look comes first. Of the grasps that touch nothing else, those with more clearance, and those
    straight from above, are preferred. The hand goes straight to the object and stops at a resistance; the
    fingers close, and their opening has to be the object's width. The object is lifted and weighed; a picture
    shows that it has left its place.
    """

    object: ObjectName
    """Name of the object."""
    grasp: Literal["best", "next"] = "best"
    """Choice among the free grasps: the best one, or the best one from another side or with another turn."""
    to: SurfaceName | None = None
    """Surface to which the object goes; grasps with which it can be put down there come first."""
    spot: SpotName | None = None
    """Spot of the surface `to` (default: any)."""
    stow: bool = True
    """Bring the object within the robot's outline in the end, as it must be before the base drives away."""

    needs: ClassVar = (Arm, Gripper, AnyCamera)
    reads: ClassVar = ("map", "sensed_cells", "objects", "detectors")
    writes: ClassVar = ("sightings", "held_object", "surface_poses", "places")
    hand: ClassVar = TAKES_OBJECT

    _look: ObjectLook = PrivateAttr(default_factory=ObjectLook)
    _start: Located | None = PrivateAttr(default=None)
    _why_unseen: Discrepancy | None = PrivateAttr(default=None)
    _beside: Sequence[Solid] = PrivateAttr(default=())
    _held: bool = PrivateAttr(default=False)
    _known: tuple[ObjectSighting, ...] = PrivateAttr(default=())

    @override
    def thing(self, model: ModelView) -> str:
        return name_in_world(self.object)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the object was not seen yet; an empty text otherwise."""
        seen = model.of(Objects).seen(self.object)
        return "" if seen is not None else f"{self.object} wasn't seen yet; LOOK_FOR finds it"

    def observe(self, robot: Robot, model: ModelView) -> Generator[None, None, Seen]:
        """Return the measured position of the object in the base frame, in [m], by the object's name; empty
        if the object is not seen.
        """
        objects = model.of(Objects)
        seen = objects.seen(self.object) or next(
            (item for item in self._known if item.object == self.object), None
        )
        if seen is None:
            return {}
        if self._start is None:
            yield from model.of(Objects).measure(robot, model, seen.surface, self.found)
        surface = surface_of(model, seen.surface)
        expected = base_T_map(robot) @ seen.pose.lift(surface.height_m)
        look = ObjectLook()
        try:
            yield from look_closely(robot, model, self.object, expected, look, self.evidence)
            yield from look.understand(robot, model, seen.surface)
            found = conclude(robot, model, self.object, seen.surface, look, expected)
        except Discrepancy as why:
            self._why_unseen = why
            return {}
        if self._start is None:
            self._start, self._look = found, look
        x, y, z = found.base_T_object[:3, 3].tolist()
        return {self.object: (x, y, z)}

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        objects, kind = model.of(Objects), kind_of(model, self.object)
        if self._start is None:
            raise self._why_unseen or Discrepancy(f"{self.object} isn't seen", cause=causes.NOT_SEEN)
        self._known = objects.sightings
        base_T_object = self._start.base_T_object
        self._check_shift(robot, model, base_T_object)
        plan = yield from self._planned(robot, model, kind, base_T_object)
        empty = yield from self._close_on(robot, model, kind, plan, base_T_object)
        hand_T_object = gripped(robot.base_T("hand"), base_T_object, kind.is_round)
        held = held_box(kind, hand_T_object)
        self._held = True
        objects.sightings = objects.without(self.object)
        objects.held_object = HeldObject(self.object, hand_T_object)
        lifted = robot.arm_model.forward(robot.arm.command())
        lifted[2, 3] += LIFT_M
        yield from move_straight(robot, lifted, held)
        yield from self._weigh(robot, kind, empty)
        yield from self._check_gone(robot, model, base_T_object)
        old_place = kind.body("the place that it was at").seen_from(base_T_object)
        yield from lift_clear(robot, model, held, (*self._beside, old_place))
        if self.stow:
            yield from stow(robot, model, kind, hand_T_object)
        self.found(
            width_mm=round(1e3 * robot.gripper.width(), 2),
            from_side=plan.grasp.face,
            clearance_mm=round(1e3 * plan.clearance, 1),
        )

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Raise a Discrepancy if the object slips out of the hand."""
        if self._held and not robot.gripper.closed_on_something():
            slipped = Measured("Gripper", "opening", 1e3 * robot.gripper.width(), unit="mm")
            raise Discrepancy(
                f"{self.object} slipped out of the hand", measured=slipped, cause=causes.SLIPPED
            )

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the fingers press on something as wide as a side of the object."""
        kind = kind_of(model, self.object)
        return any(holds(robot, side, WIDTH_TOLERANCE_M) for side in kind.size)
        yield

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Return the allowed contacts: of the hand with the object to take, and of that object with what it
        lies on.
        """
        seen, surfaces = model.of(Objects).seen(self.object), model.of(Objects).objects.surfaces
        on = dict.fromkeys(item.surface for item in (seen, *self._known) if item is not None)
        own = seen or next((item for item in self._known if item.object == self.object), None)
        touched = [name for item in on for name in surfaces[item].contact_names(item)]
        if own is not None:
            radius = model.of(Objects).objects.kind_of(self.object).foot_radius
            touched += model.of(Objects).touched_names(own.surface, *own.pose[:2], radius)
        return (
            MeantContact("hand", name_in_world(self.object)),
            *(MeantContact("held", name) for name in dict.fromkeys(touched)),
        )

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Play the motion backwards: the object is on its surface again before the fingers open."""
        self._held = False
        yield from retrace(robot, start, trace)
        objects = model.of(Objects)
        objects.held_object = None
        if self._known:
            objects.sightings = self._known

    def _check_shift(self, robot: Robot, model: ModelView, base_T_object: Transform) -> None:
        seen = model.of(Objects).seen(self.object)
        if seen is None:
            return
        expected = base_T_map(robot) @ seen.pose.lift(surface_of(model, seen.surface).height_m)
        off = float(np.linalg.norm(base_T_object[:2, 3] - expected[:2, 3]))
        self.found(shift_mm=round(1e3 * off, 1))
        if exceeds(off, MAX_SHIFT_M):
            moved = Measured("Camera", "object off its place", 1e3 * off, 1e3 * MAX_SHIFT_M, "mm")
            raise Discrepancy(
                f"{self.object} isn't where it was seen", measured=moved, cause=causes.MISPLACED
            )

    def _planned(
        self, robot: Robot, model: ModelView, kind: ObjectKind, base_T_object: Transform
    ) -> Generator[None, None, PlannedGrasp]:
        self._beside = self._seen_beside(robot, model, kind, base_T_object)
        target = kind.body(name_in_world(self.object)).seen_from(base_T_object)
        *roomy, last = surroundings_to_try(robot, model, self.object)
        for bodies in (*roomy[:: len(rooms(robot, model))], last):
            around = (*bodies, *self._beside)
            choice = yield from robot.compute(plan_grasps, robot, kind, base_T_object, around, target)
            if choice.planned:
                break
        self.found(grasps_tried=choice.tried, grasps_free=len(choice.planned))
        if not choice.planned:
            free = Measured("Arm", f"of {choice.reached} grasps within reach those that are free", 0, 1)
            if not choice.reached:
                raise Discrepancy(f"{self.object} is out of reach", measured=free, cause=causes.OUT_OF_REACH)
            raise Discrepancy(f"no grasp of {self.object} is free", measured=free, cause=causes.NO_ARM_PATH)
        first = yield from self._leading_on(robot, model, kind, base_T_object, choice.planned)
        if self.grasp == "best":
            return first
        others = [item for item in choice.planned if not _alike(item, first)]
        if not others:
            raise Discrepancy(f"{self.object} has only one free grasp", cause=causes.NO_ARM_PATH)
        return (yield from self._leading_on(robot, model, kind, base_T_object, others))

    def _seen_beside(
        self, robot: Robot, model: ModelView, kind: ObjectKind, base_T_object: Transform
    ) -> Sequence[Solid]:
        """Return boxes around what a depth camera saw beside the object, in the base frame."""
        seen = model.of(Objects).seen(self.object) or next(
            (item for item in self._known if item.object == self.object), None
        )
        if seen is None:
            return ()
        return list(obstacles(self._look.found, base_T_top(robot, model, seen.surface), base_T_object, kind))

    def _leading_on(
        self,
        robot: Robot,
        model: ModelView,
        kind: ObjectKind,
        base_T_object: Transform,
        planned: Sequence[PlannedGrasp],
    ) -> Generator[None, None, PlannedGrasp]:
        """Return the first grasp with which the object can be put down where it goes; if there is none, the
        first one.
        """
        if self.to is None:
            return planned[0]
        surface = surface_of(model, self.to)
        place = model.places.get(surface.place or self.to)
        if place is None:
            return planned[0]
        every = [
            np.asarray(inverse(place.pose.lift()) @ transform) for transform in goals_on(surface, self.spot)
        ]
        goals = showing_tags(every, model.of(Objects).objects.tags_of(self.object))
        around = [box.seen_from(inverse(place.pose.lift())) for box in surface.boxes(self.to)]
        for grasp in planned:
            hand_T_object = gripped(grasp.base_T_grip, base_T_object, kind.is_round)
            found = yield from robot.compute(
                plan_placing, robot, kind, hand_T_object, goals, around, grasp.grasp.width
            )
            if found is not None:
                self.found(leads_on=True)
                return grasp
        self.found(leads_on=False)
        return planned[0]

    def _close_on(
        self, robot: Robot, model: ModelView, kind: ObjectKind, plan: PlannedGrasp, base_T_object: Transform
    ) -> Generator[None, None, _Weighing]:
        """Go to the object and close the fingers on it; return the force on the empty hand."""
        target = kind.body(name_in_world(self.object)).seen_from(base_T_object)
        around = (*self._beside, target)
        yield from open_to(robot, plan.grasp.width + OPENING_CLEARANCE_M)
        yield from move_with_room(robot, model, plan.before, also_around=around, without=self.object)
        pushed = yield from push(robot, plan.base_T_grip, GRASP_SPEED_M_S, GRASP_TOUCH_FORCE_N)
        if pushed.met:
            felt = Measured("Arm", "force that resists the hand", pushed.force, GRASP_TOUCH_FORCE_N, "N")
            raise Discrepancy("the hand runs into something", measured=felt, cause=causes.ARM_BLOCKED)
        empty = yield from _felt_weight(robot)
        yield from self.intend(f"the fingers close on {self.object}")
        yield from close(robot)
        width = robot.gripper.width()
        if not width > MIN_HELD_WIDTH_M or not holds(robot, plan.grasp.width, WIDTH_TOLERANCE_M):
            nothing = width <= MIN_HELD_WIDTH_M
            wrong = "the fingers closed on nothing" if nothing else f"the fingers don't hold {self.object}"
            off = width_off(robot, plan.grasp.width, WIDTH_TOLERANCE_M, "the object's width")
            raise Discrepancy(wrong, measured=off, cause=causes.NOT_HELD)
        return empty

    def _weigh(self, robot: Robot, kind: ObjectKind, empty: _Weighing) -> Periods:
        """Compare the force on the hand before the fingers closed and after the lift with the weight."""
        loaded = yield from _felt_weight(robot)
        felt = loaded.newtons - empty.newtons
        self.found(weight_n=round(felt, 2))
        if kind.mass_kg is None:
            return
        weight = GRAVITY_M_S2 * kind.mass_kg
        off, most = abs(felt - weight), max(MIN_WEIGHT_ERROR_N, MAX_WEIGHT_ERROR_SHARE * weight)
        if exceeds(off, most) and loaded.stands_still and not empty.stands_still:
            raise Discrepancy("the reading of the force stands still", cause=causes.SENSOR_FAULT)
        if exceeds(off, most):
            wrong = Measured("Arm", f"felt weight off that of {self.object}", off, most, "N")
            raise Discrepancy(
                f"the held object doesn't weigh as much as {self.object}",
                measured=wrong,
                cause=causes.NOT_HELD,
            )

    def _check_gone(self, robot: Robot, model: ModelView, base_T_object: Transform) -> Periods:
        """Take a picture: the object must not be seen at its old place."""
        yield from settle(robot)
        yield
        look = ObjectLook()
        yield from look.picture(robot, model, self.evidence, self.object)
        for read in look.of(self.object):
            assert read.base_T_object is not None
            off = float(np.linalg.norm(read.base_T_object[:3, 3] - base_T_object[:3, 3]))
            if off < LIFT_M / 2:
                left = Measured("Camera", "object off its old place", 1e3 * off, 500.0 * LIFT_M, "mm")
                raise Discrepancy(f"{self.object} is still there", measured=left, cause=causes.NOT_HELD)


def _alike(one: PlannedGrasp, other: PlannedGrasp) -> bool:
    """Return whether two grasps come from one side and close in one direction."""
    a, b = one.grasp, other.grasp
    same_turn = math.isclose(a.tilt, b.tilt)
    return a.face == b.face and same_turn and bool(abs(a.box_T_hand[:3, 1] @ b.box_T_hand[:3, 1]) > 0.9)


class _Weighing(NamedTuple):
    """Downward force on the hand at rest."""

    newtons: float
    """Mean of some readings, in [N]."""
    stands_still: bool
    """True if all readings are the same."""


def _felt_weight(robot: Robot) -> Generator[None, None, _Weighing]:
    """Return the downward force on the hand at rest."""
    yield from settle(robot)
    readings: list[FloatArray] = []
    down: list[float] = []
    for _ in range(WEIGHING_PERIODS):
        readings.append((yield from awaited_force(robot)))
        down.append(-float((robot.base_T("hand")[:3, :3] @ readings[-1])[2]))
        yield
    return _Weighing(float(np.mean(down)), not np.ptp(readings, axis=0).any())
