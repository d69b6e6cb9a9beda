"""HAND_OVER: give the held object to a person."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from enum import Enum
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import ForceArm
from handcart.backends.capabilities.camera import AnyCamera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.files.suggest import suggest
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import collision_model
from handcart.primitives.motions.grip import close, open_to
from handcart.primitives.motions.pushing import relax
from handcart.primitives.objects.holding.carrying import stow
from handcart.primitives.objects.holding.hold_watch import HoldWatch
from handcart.primitives.objects.holding.offering import is_outside, offering_joints
from handcart.primitives.objects.holding.placing_plan import withdrawn
from handcart.primitives.objects.holding.pull_watch import PullWatch, direction_words
from handcart.primitives.objects.knowledge import object_causes
from handcart.primitives.objects.knowledge.object_names import name_in_world
from handcart.primitives.objects.knowledge.objects import HeldObject, Objects
from handcart.primitives.objects.looking.floor_look import FloorLook, look_at_floor
from handcart.primitives.objects.site.object_site import held_box, kind_of
from handcart.primitives.objects.site.roomy_motion import (
    move_straight_with_room,
    move_with_room,
    surroundings_to_try,
)
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.preconditions.hand_use import LETS_GO
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import MIN_HELD_WIDTH_M, Snapshot, is_holding
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.numerics.arrays import FloatArray

GRAVITY_M_S2 = 9.81
CARRIED_SHARE = 1.5  # of the least pull, that a force on the way has before it counts
TAKING_TIME_S = 1.0  # that a person has to take the object out of the open fingers
CALM_TIMEOUT_S = 30.0  # that a pull may last before the arm goes back
PERSISTENT_S = 1.0  # that a force lasts beyond the arm's stop if a person pulls
UPRIGHT_TOLERANCE_RAD = math.radians(15.0)


class HeldPhase(Enum):
    """Phase of the hand-over of an object to a person: carried, offered to the person, or released by the
    fingers.
    """

    CARRIED = "carried"
    OFFERED = "offered"
    RELEASED = "released"


class HandOver(ActionPrimitive):
    """Hold the object out to a person, wait until the person pulls at it, and let it go.

    The arm brings the object ahead of the robot, upright, or moves to a named posture. The fingers open once
    a force has pulled at the hand for a while; a bump or a push is no pull. Then the closing fingers must
    show that the hand is empty, and a picture of the floor must show that the object has not fallen.
    """

    posture: Annotated[str, Field(min_length=1)] | None = None
    """Posture of the robot's file in which the object is offered (default: computed)."""
    height_mm: Annotated[float, Field(ge=200.0, le=1600.0)] = 1000.0
    """Height of the middle of the offered object over the floor, as nearly as the arm reaches."""
    pull_n: Annotated[float, Field(ge=1.0, le=60.0)] = 6.0
    """Least pull that opens the fingers."""
    wait_s: Annotated[float, Field(ge=1.0, le=3600.0)] = 30.0
    """Time that a person has to begin a pull."""
    floor: FloorLook = "plain"
    """Look of the floor: on a plain one, anything with an edge below the hand counts as the fallen object;
    on a patterned one, only its tags.
    """
    stow: bool = True
    """Bring the arm home in the end, as it must be before the base drives away."""

    needs: ClassVar = (ForceArm, Gripper, AnyCamera)
    reads: ClassVar = ("map", "sensed_cells", "objects", "detectors", "sightings")
    writes: ClassVar = ("held_object", "handed_over")
    hand: ClassVar = LETS_GO
    asks_permission: ClassVar = True

    _before: HeldObject | None = PrivateAttr(default=None)
    _phase: HeldPhase = PrivateAttr(default=HeldPhase.CARRIED)
    _hold: HoldWatch = PrivateAttr(default_factory=HoldWatch)
    _watch: PullWatch | None = PrivateAttr(default=None)
    _is_gone: bool = PrivateAttr(default=False)

    @override
    def thing(self, model: ModelView) -> str:
        held = model.of(Objects).held_object or self._before
        return "" if held is None else name_in_world(held.object)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return why the object can't be handed over; empty if it can."""
        if model.of(Objects).held_object is None:
            return "no object was picked"
        known = robot.spec.arm.postures if robot.spec.arm is not None else {}
        if self.posture is not None and self.posture not in known:
            return f"the robot's file has no posture {self.posture!r}{suggest(self.posture, known)}"
        if not robot.arm.hand_force().any():  # a held object weighs something
            return "nothing measures the force on the hand: it reads exactly 0 with an object in it"
        return ""

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        objects = model.of(Objects)
        held = objects.held_object
        assert held is not None  # the precondition
        self._before, watch = held, PullWatch(robot, self.pull_n)
        mass = kind_of(model, held.object).mass_kg
        yield from watch.measure_rest(None if mass is None else mass * GRAVITY_M_S2)
        self._watch = watch
        joints = yield from self._planned(robot, model, held)
        yield from self._bring(robot, model, joints, watch)
        foot = robot.base_T("hand") @ held.hand_T_object
        self.found(offered_mm=round(1e3 * (float(foot[2, 3]) + kind_of(model, held.object).size[2] / 2)))
        yield from watch.rest_here()
        yield from self._await_pull(robot, watch)
        self._phase = HeldPhase.RELEASED
        self.point_of_no_return(f"the fingers let {held.object} go")
        yield from open_to(robot)
        objects.held_object = None
        objects.handed_over = tuple(dict.fromkeys((*objects.handed_over, held.object)))
        released = (robot.base_T("hand") @ held.hand_T_object)[:3, 3]
        yield from self._check_hand(robot, model)
        seen = yield from look_at_floor(robot, model, self.evidence, held.object, released, self.floor)
        self.found(floor=seen)
        if self.stow:
            yield from stow(robot, model)

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Check in this period that the object has not slipped out of the hand, unless it is being offered.

        Raises:
            NeedsPerson: the object has slipped.
        """
        if self._phase is HeldPhase.CARRIED and self._hold.has_slipped(robot):
            raise self._hold.slipped(robot)

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the hand is empty after the object was released."""
        return self._is_gone and not is_holding(robot)
        yield

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Return the intended contact of the hand with the object."""
        held = model.of(Objects).held_object or self._before
        return () if held is None else (MeantContact("hand", name_in_world(held.object)),)

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Wait until nobody pulls at the held object, then play the motion backwards, with the object in the
        hand.
        """
        self._phase = HeldPhase.CARRIED
        if self._watch is not None and not self._watch.is_calm:
            yielding = Trace(robot)
            for _ in self._await_calm(robot, self._watch):
                yielding.record()
                yield
            trace = trace.left_after(yielding)
        yield from retrace(robot, start, trace)

    def _planned(self, robot: Robot, model: ModelView, held: HeldObject) -> Generator[None, None, FloatArray]:
        """Return the joints (n,) that offer the object, in [rad] or [m]."""
        kind, grip = kind_of(model, held.object), held.hand_T_object
        if self.posture is None:
            height = 1e-3 * self.height_mm
            for around in surroundings_to_try(robot, model):
                found = yield from robot.compute(offering_joints, robot, kind, grip, height, around)
                if found is not None:
                    return found
            raise Discrepancy(f"the arm can't hold {held.object} out freely", cause=causes.OUT_OF_REACH)
        joints = np.array(robot.spec.posture(self.posture))
        base_T_hand = robot.arm_model.forward(joints)
        up = float((base_T_hand @ grip)[2, 2])
        tilt = math.acos(min(1.0, max(-1.0, up)))
        if kind.upright and tilt > UPRIGHT_TOLERANCE_RAD:
            tilted = Measured("Arm", "tilt", math.degrees(tilt), math.degrees(UPRIGHT_TOLERANCE_RAD), "deg")
            raise Discrepancy(
                f"the posture {self.posture!r} tilts {held.object}", measured=tilted, cause=causes.UNSUITABLE
            )
        if not is_outside(robot, base_T_hand):
            raise Discrepancy(
                f"the posture {self.posture!r} holds nothing out of the robot's outline",
                cause=causes.UNSUITABLE,
            )
        tried = (
            collision_model(robot, held_box(kind, grip), around)
            for around in surroundings_to_try(robot, model)
        )
        hits = [collision.contacts(joints) for collision in tried]
        if all(hits):
            (one, other), *_ = hits[-1]
            words = f"in the posture {self.posture!r} {one} would touch {other}"
            raise Discrepancy(words, cause=causes.OUT_OF_REACH)
        return joints

    def _bring(self, robot: Robot, model: ModelView, joints: FloatArray, watch: PullWatch) -> Periods:
        """Bring the object to the joints (n,) that offer it, in [rad] or [m]; stop if a force lasts.

        Raises:
            NeedsPerson: somebody pulls.
            Discrepancy: something was in the way.
        """
        held = model.of(Objects).held_object
        assert held is not None
        shape = held_box(kind_of(model, held.object), held.hand_T_object)
        for _ in move_with_room(robot, model, joints, shape):
            yield
            watch.feel()
            force = watch.lasting(CARRIED_SHARE)
            if force is not None:
                yield from self._stop_at(robot, watch, held.object, force)

    def _stop_at(self, robot: Robot, watch: PullWatch, name: str, force: FloatArray) -> Periods:
        """Stop at a force (3,) in [N], and distinguish its source by an arm that yields.

        The force of a contact then ends, and the handing over fails; the force of a person stays, and a
        person is called.
        """
        felt = Measured(
            "Arm", "force on the way", float(np.linalg.norm(force)), CARRIED_SHARE * self.pull_n, "N"
        )
        yield from relax(robot)
        end = robot.time + PERSISTENT_S
        while robot.time < end:
            yield
            watch.feel()
            if watch.is_calm:
                raise Discrepancy(f"something pushed {name}", measured=felt, cause=causes.ARM_BLOCKED)
        raise NeedsPerson(f"somebody pulls at {name} before it is offered", felt, cause=object_causes.PULLED)

    def _await_pull(self, robot: Robot, watch: PullWatch) -> Periods:
        """Wait until somebody pulls, and still pulls as the fingers are about to open.

        Raises:
            Discrepancy: nobody pulls in time.
            NeedsPerson: the object slips out of the hand, and nobody pulls.
        """
        self._phase = HeldPhase.OFFERED
        begun = robot.time
        while robot.time <= begun + self.wait_s:
            yield
            watch.feel()
            if self._hold.has_slipped(robot):
                if not watch.is_strong:
                    raise self._hold.slipped(robot)
                self.found(pull="out of the closed fingers")
                return
            pull = watch.pull()
            if pull is None:
                continue
            yield from self.intend("the fingers let the object go to the person who pulls")
            watch.feel()
            if watch.lasts(pull):
                self.found(
                    waited_s=round(robot.time - begun, 2),
                    pull_n=round(float(np.linalg.norm(pull)), 1),
                    pull=direction_words(pull),
                )
                return
        early = "" if watch.is_rested else ": the force at the hand never came to rest there"
        waited = Measured("Arm", "time without a pull", robot.time - begun, self.wait_s, "s")
        raise Discrepancy(f"nobody takes the object{early}", measured=waited, cause=object_causes.NOT_TAKEN)

    def _await_calm(self, robot: Robot, watch: PullWatch) -> Periods:
        """Wait until nobody pulls, with an arm that yields: one that presses on something never gets calm."""
        yield from relax(robot)
        end = robot.time + CALM_TIMEOUT_S
        while not watch.is_calm:
            if robot.time > end:
                raise NeedsPerson("somebody keeps pulling at the object", cause=object_causes.PULLED)
            yield
            watch.feel()

    def _check_hand(self, robot: Robot, model: ModelView) -> Periods:
        """Leave the object to the person, and close the fingers: nothing may be between them.

        Raises:
            NeedsPerson: something is between the fingers.
        """
        yield from robot.wait(TAKING_TIME_S)
        try:
            yield from move_straight_with_room(robot, model, withdrawn(robot.base_T("hand")))
        except Discrepancy as no_way:
            if no_way.cause is not causes.NO_ARM_PATH:
                raise
        yield from close(robot)
        width = robot.gripper.width()
        if exceeds(width, MIN_HELD_WIDTH_M):
            left = Measured("Gripper", "opening", 1e3 * width, 1e3 * MIN_HELD_WIDTH_M, "mm")
            raise NeedsPerson("something is still between the fingers", left, cause=object_causes.NOT_TAKEN)
        self._is_gone = True
        self.found(closed_mm=round(1e3 * width, 2))
