"""DEPLOY: lay a sensor on its target in the field."""

from __future__ import annotations

import math
from collections.abc import Generator
from collections.abc import Sequence as Several
from contextlib import suppress
from typing import Annotated, ClassVar

import numpy as np
from py_trees.behaviour import Behaviour
from py_trees.composites import Selector, Sequence
from pydantic import Field as Limited
from pydantic import PrivateAttr

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.imu import Imu
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.contract.tree_primitive import Step, TreePrimitive, leaves
from handcart.primitives.field import field_causes
from handcart.primitives.field.target import TargetName
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.felt_force import awaited_force
from handcart.primitives.motions.grip import open_to
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.preconditions.hand_use import Hand, HandUse
from handcart.primitives.restoring.arm_command import hold_measured
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.manipulation.arms.scara import base_to_world, world_to_base
from handcart.robotics.numerics.arrays import FloatArray

from .field import Field
from .field_work import FieldWork
from .scara_arm import scara_of
from .sensor_arm import TOUCH_FORCE_N, SensorArm
from .target import Laid, Target

LOWERING_SPEED_M_S = 0.03  # of the slide
SLOW_DESCENT_M = 0.03  # above the ground, from where the sensor is lowered slowly
GROUND_TOLERANCE_M = 0.12  # by which the ground may be higher or lower there than under the wheels
REFINEMENT_TOLERANCE_M = 0.002  # by which a better estimate moves the tip once more
REFINED_MOST = 0.3  # [m] by which it may, just above the ground
MAX_GROUND_SLOPE = 0.2  # [m/m] by which the ground may rise aside of where the sensor is
LIFT_MAX_TRIES = 4  # times that a sensor that touches something on its way aside is lifted
OPENING_CLEARANCE_M = 0.010  # that the fingers open wider than the sensor
LOOSEN_CYCLES = 12  # times that they let go and catch it before they open: on a slope it turns between them
LOOSE_S = 0.075  # [s] for which they let go
CAUGHT_S = 0.1  # [s] for which they hold it again
OPENING_SPEED_M_S = 0.01  # at which they open then: it comes to lean on one of them
FEEL_CLEARANCE_M = 0.02  # over the sensor's top, from where closed fingers are lowered onto it
MAX_TOP_DROP_M = 0.02  # by which its top may be lower than upright
REACH_SIGMAS = 3.0  # sigmas within which a target is taken to be
GROUND_NAMES = ("the ground", "floor")  # as worlds call it
DRIVE_LIFT_M = 0.145  # that the fingers are lifted further before the base drives on


class Deploy(TreePrimitive):
    """Lay a sensor on its target, with the base to the left of it (Ohki et al. 2012, section V-B).

    The base stays at rest until the target's position is known well enough. The fingers take the sensor from
    the magazine. The arm moves to its posture `middle`, and then its tip moves on straight lines to above the
    target (resolved-rate control). Roll and pitch of the base are taken into account, and position fixes that
    arrive meanwhile. The sensor is lowered until it touches the ground and released in small steps, which
    cannot be undone. If the sensor leans on a finger, the hand moves until the sensor is upright by itself.
    The fingers feel for the sensor's top; then the arm returns along the same path.

    With `together`, arm and base move at the same time. The primitive MOVE_TO before this one has then
    brought the sensor over the target, and the MOVE_TO after it brings the arm back. In the end the arm is
    only lifted, except for the last sensor.
    """

    target: TargetName
    """Name of the target."""
    settle_s: Annotated[float, Limited(ge=0.0, le=600.0)] = 0.0
    """Minimum time at rest before the arm moves."""
    sure_mm: Annotated[float, Limited(gt=0.0)] = 250.0
    """Maximum standard deviation of the target's position, along the worst direction: the base waits for
    it.
    """
    longest_s: Annotated[float, Limited(ge=0.0, le=3600.0)] = 120.0
    """Maximum time to wait for that accuracy; then the action Fails."""
    together: bool = False
    """Bring the arm back while the base departs, in the next MOVE_TO."""

    needs: ClassVar = (Arm, Gripper, Imu)
    reads: ClassVar = ("targets", "field")
    writes: ClassVar = ("laid",)
    hand: ClassVar = HandUse(Hand.ANY, Hand.EMPTY)

    _arm: SensorArm = PrivateAttr()
    _target: Target = PrivateAttr()
    _let_go_whole: bool = PrivateAttr(default=False)
    _top: float = PrivateAttr()
    _stands: bool | None = PrivateAttr(default=None)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return why the sensor cannot be laid, or "".

        Its target may be unknown or out of reach, or have its sensor already; the hand may hold another
        object, or the arm may not be in its posture `home` to take a sensor.
        """
        work = model.of(FieldWork)
        if work.field is None or self.target not in work.targets:
            return f"unknown target {self.target!r} in the field"
        if any(laid.name == self.target for laid in work.laid):
            return f"the sensor of target {self.target!r} is laid already"
        try:
            arm = SensorArm(robot, work.field)
            if robot.localization.doubt is None:
                self._check_near(robot, arm, work.targets[self.target])
        except Discrepancy as refused:
            return refused.reason
        return arm.not_ready()

    def _check_near(self, robot: Robot, arm: SensorArm, target: Target) -> None:
        """Raise `Discrepancy` if the target is out of reach, even if its position is off by 3 sigma."""
        place = arm.place_of(np.array([target.x, target.y]))
        arm.check_near(place, REACH_SIGMAS * self._sigma(robot, target))

    def tree(self, robot: Robot, model: ModelView) -> Behaviour:
        """Return the behaviour tree that lays a sensor on the target, one step after another.

        The last step moves the arm to its posture `home`; if the next action is a drive that does so itself,
        it only lifts the fingers off the sensor.
        """
        steps: dict[str, Step] = {
            "stand until the target is known well enough": lambda: self._be_sure(robot, model),
            "take the sensor from the magazine": lambda: self._arm.take(),
            "bring the sensor over the target": lambda: self._reach(self._arm, self._target),
            "lower it until it touches the ground": lambda: self._lower(robot, self._arm, self._target),
            "let it go": lambda: self._let_go(robot, model, self._arm),
            "feel whether it stands": lambda: self._feel(robot, model, self._arm),
        }
        back: dict[str, Step] = {
            "lift the fingers, where the next drive brings the arm back": lambda: self._lift(robot, model),
            "bring the arm home": lambda: self._arm.stow(),
        }
        leave = Selector("leave it", memory=True, children=leaves(back))
        return Sequence("lay the sensor on its target", memory=True, children=[*leaves(steps), leave])

    def _reach(self, arm: SensorArm, target: Target) -> Periods:
        yield from arm.reach(arm.place_of(np.array([target.x, target.y])))

    def _let_go(self, robot: Robot, model: ModelView, arm: SensorArm) -> Periods:
        work = model.of(FieldWork)
        field, _ = self._field_and_target(model)
        yield from self.intend("the fingers let the sensor go")
        self.point_of_no_return("the sensor is let go")
        robot.localization.mark()
        work.laid = (*work.laid, self._laid(robot, arm))
        self._top = float(robot.arm.command()[2]) - field.gripped_mm / 1e3
        yield from self._release(robot, field)

    def _release(self, robot: Robot, field: Field) -> Periods:
        yield from self._loosen(robot, field.sensor_mm[1] / 1e3 + OPENING_CLEARANCE_M)
        yield from self._arm.give_way()
        self._let_go_whole = True

    def _loosen(self, robot: Robot, wide: float) -> Periods:
        """Open the fingers to `wide` [m] so that the sensor comes to lie on a slope without a swing.

        Across the fingers it falls a little each time that they let go, and is caught; along their stroke it
        comes to lean on one of them. Let go at once it would fall over on slopes of 10 degrees, rocking from
        one edge of its foot to the other (Housner 1963, inelastic impacts).
        """
        for _ in range(LOOSEN_CYCLES):
            robot.gripper.move(wide)
            yield from robot.wait(LOOSE_S)
            robot.gripper.move(0.0)
            yield from robot.wait(CAUGHT_S)
        at = robot.gripper.width()
        while at < wide:
            at = min(wide, at + OPENING_SPEED_M_S * robot.period)
            robot.gripper.move(at)
            yield
        yield from open_to(robot, wide)

    def _feel(self, robot: Robot, model: ModelView, arm: SensorArm) -> Periods:
        """Lower the nearly closed fingers onto the sensor's top; raise `Discrepancy` if it fell over."""
        field, _ = self._field_and_target(model)
        top = self._top
        yield from arm.slide(max(0.0, top - FEEL_CLEARANCE_M))
        yield from open_to(robot, field.sensor_mm[1] / 2e3)
        force = yield from arm.slide(top + MAX_TOP_DROP_M, LOWERING_SPEED_M_S)
        self._stands = force > TOUCH_FORCE_N
        if not self._stands:
            felt = Measured("Arm", "force where the sensor's top should be", force, TOUCH_FORCE_N, "N")
            raise Discrepancy(
                "the sensor fell over", permanent=True, measured=felt, cause=field_causes.TOPPLED
            )
        self.found(top_mm=round(1e3 * (top - float(robot.arm.command()[2])), 1))
        yield from arm.slide(max(0.0, top - FEEL_CLEARANCE_M))

    def _lift(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Lift the arm and return True if the base drives on to another target; otherwise return False."""
        work = model.of(FieldWork)
        if not self.together or len(work.laid) >= len(work.targets):
            return False
        yield from self._arm.slide(max(0.0, float(robot.arm.command()[2]) - DRIVE_LIFT_M))
        return True

    def base_room(self, robot: Robot, model: ModelView) -> float:
        """Return how far the base may be off its planned position so that the arm still reaches the target,
        in [m]; infinity if the target is unknown or out of reach anyway.
        """
        work = model.of(FieldWork)
        if self.target not in work.targets:
            return math.inf
        target = work.targets[self.target]
        beside = target.stand.inverse().apply(np.array([[target.x, target.y]])).reshape(2)
        room = 0.0
        with suppress(Discrepancy):
            room = scara_of(robot).room_beside(beside, math.radians(robot.spec.tolerance.base_deg))
        return room or math.inf  # an unreachable target needs no room

    def meant_contacts(self, model: WorldModel) -> Several[MeantContact]:
        """Return the intended contacts of the hand with the sensor, and of the sensor with the ground."""
        return model.of(FieldWork).sensor_contact(self.target), *(
            MeantContact("held", name) for name in GROUND_NAMES
        )

    def finish(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Open the fingers completely, and stow the arm; after a fault of the robot, first feel whether the
        sensor is upright.

        Fingers that are half open would drag the sensor.

        Returns:
            True if the sensor was felt to be upright.
        """
        yield from settle(robot)
        if not self._let_go_whole:
            field, _ = self._field_and_target(model)
            yield from self._release(robot, field)
        if self._stands is None and self.met_fault:
            try:
                yield from self._feel(robot, model, self._arm)
            except Discrepancy as fallen:
                self.found(felt=fallen.reason)
        yield from self._arm.stow()
        return self._stands is True

    def _field_and_target(self, model: ModelView) -> tuple[Field, Target]:
        work = model.of(FieldWork)
        if work.field is None or self.target not in work.targets:
            raise Discrepancy(
                f"unknown target {self.target!r} in the field", permanent=True, cause=causes.NOT_KNOWN
            )
        return work.field, work.targets[self.target]

    def _be_sure(self, robot: Robot, model: ModelView) -> Periods:
        """Wait at rest until the target's position is known well enough."""
        field, target = self._field_and_target(model)
        self._arm, self._target = SensorArm(robot, field), target
        yield from robot.wait(self.settle_s)
        begun = robot.time
        while True:
            sigma, doubt = self._sigma(robot, target), robot.localization.doubt
            if doubt is None:
                self._check_near(robot, self._arm, target)
            if doubt is None and sigma <= self.sure_mm / 1e3:
                break
            if robot.time - begun > self.longest_s:
                if doubt is not None:
                    why = f"the target's place is not determined: {doubt.why}"
                    raise Discrepancy(why, measured=Measured(*doubt[1:]), cause=causes.UNDETERMINED)
                known = Measured(
                    robot.localization.source, "sigma of where the target is", 1e3 * sigma, self.sure_mm, "mm"
                )
                raise Discrepancy(
                    "it isn't known well enough where the target is",
                    measured=known,
                    cause=causes.UNDETERMINED,
                )
            yield
        self.found(stood_s=round(robot.time - begun + self.settle_s, 2), sigma_mm=round(1e3 * sigma, 1))

    def _sigma(self, robot: Robot, target: Target) -> float:
        """Return the standard deviation of the target in the base frame, in the worst direction, in [m]."""
        away = np.array([target.x - robot.pose.x, target.y - robot.pose.y])
        return math.sqrt(float(np.linalg.eigvalsh(_spread(robot, away))[-1]))

    def _lower(self, robot: Robot, arm: SensorArm, target: Target) -> Periods:
        """Lower the sensor to the ground."""
        point = world_to_base(robot.pose, robot.localization.tilt, np.array([target.x, target.y, 0.0]))
        down = arm.scara.mount[2] - arm.below - float(point[2])
        lowest = arm.scara.slide[1]
        if not -GROUND_TOLERANCE_M < down <= lowest + GROUND_TOLERANCE_M:
            most = 1e3 * (lowest + GROUND_TOLERANCE_M)
            low = Measured("Arm", "travel of the slide that is needed", 1e3 * down, most, "mm")
            raise Discrepancy("the slide doesn't reach the ground", measured=low, cause=causes.OUT_OF_REACH)
        force = yield from arm.slide(min(max(0.0, down - SLOW_DESCENT_M), lowest))
        if force > TOUCH_FORCE_N:
            yield from self._lift_off(robot, arm, down, force)
        yield from self._refine(robot, arm, target)
        force = yield from arm.slide(min(down + GROUND_TOLERANCE_M, lowest), LOWERING_SPEED_M_S)
        if force <= TOUCH_FORCE_N:
            felt = Measured("Arm", "force from below", force, TOUCH_FORCE_N, "N")
            raise Discrepancy("no ground is below the sensor", measured=felt, cause=causes.NO_SUPPORT)
        yield from hold_measured(robot)
        self.found(
            lowered_mm=round(1e3 * (float(robot.arm.command()[2])), 1),
            off_mm=round(1e3 * (float(robot.arm.command()[2]) - down), 1),
        )

    def _lift_off(self, robot: Robot, arm: SensorArm, down: float, force: float) -> Periods:
        """Lift a sensor that touches uneven ground early; raise `Discrepancy` if the contact is too high."""
        at = float(robot.arm.command()[2])
        if at < down - GROUND_TOLERANCE_M:
            felt = Measured("Arm", "force from below", force, TOUCH_FORCE_N, "N")
            raise Discrepancy("something lies where the sensor goes", measured=felt, cause=causes.OCCUPIED)
        yield from arm.slide(at - SLOW_DESCENT_M)

    def _refine(self, robot: Robot, arm: SensorArm, target: Target) -> Periods:
        """Just above the ground, move to the target's position by the latest estimate."""
        better = arm.place_of(np.array([target.x, target.y]))
        moved = float(np.hypot(*(better - arm.scara.tip(robot.arm.command()))))
        self.found(refined_mm=round(1e3 * moved, 1))
        if moved <= REFINEMENT_TOLERANCE_M:
            return
        free = moved <= REFINED_MOST and (yield from robot.compute(arm.line_free, better, takes=0.05))
        if not free:
            what = "where the target is by now, off the tip"
            off = Measured(robot.localization.source, what, 1e3 * moved, 1e3 * REFINEMENT_TOLERANCE_M, "mm")
            raise Discrepancy(
                "by what is known now the target is out of reach from here",
                measured=off,
                cause=causes.OUT_OF_REACH,
            )
        yield from self._lead_clear(robot, arm, better, moved)

    def _lead_clear(self, robot: Robot, arm: SensorArm, place: FloatArray, way: float) -> Periods:
        """Lead the tip to a place (2,) in the arm's own frame, in [m]; lift the sensor where it touches
        rising ground.

        Args:
            robot: the robot.
            arm: its arm, with a sensor.
            place: (2,) the place.
            way: distance to the place, in [m].
        """
        yield from arm.slide(max(0.0, float(robot.arm.command()[2]) - MAX_GROUND_SLOPE * way))
        for _ in range(LIFT_MAX_TRIES):
            for _ in arm.lead(place):
                yield
                force = float(np.linalg.norm((yield from awaited_force(robot))))
                if force > TOUCH_FORCE_N:
                    break
            else:
                return
            yield from arm.slide(max(0.0, float(robot.arm.command()[2]) - SLOW_DESCENT_M))
        felt = Measured("Arm", "force on the sensor above the ground", force, TOUCH_FORCE_N, "N")
        raise Discrepancy("an obstacle is at the sensor's target", measured=felt, cause=causes.OCCUPIED)

    def _laid(self, robot: Robot, arm: SensorArm) -> Laid:
        """Return the believed position of the sensor that is about to be released."""
        foot = arm.scara.base_tip(robot.arm.joints()) - (0.0, 0.0, arm.below)
        x, y, _ = base_to_world(robot.pose, robot.localization.tilt, foot).tolist()
        spread = _spread(robot, np.array([x - robot.pose.x, y - robot.pose.y]))
        covariance = (float(spread[0, 0]), float(spread[0, 1]), float(spread[1, 1]))
        self.found(laid_x_m=round(x, 3), laid_y_m=round(y, 3))
        ahead, left = robot.pose.inverse().apply(np.array([[x, y]])).reshape(2).tolist()
        return Laid(self.target, x, y, covariance, (ahead, left), robot.time)


def _spread(robot: Robot, away: FloatArray) -> FloatArray:
    """Return (2, 2) covariance in [m²] of a point that is `away` (2,) from the base in the field's axes, in
    [m].
    """
    by_pose = np.array([[1.0, 0.0, -away[1]], [0.0, 1.0, away[0]]])
    by_arm = (robot.spec.arm.accuracy_mm / 1e3) ** 2 if robot.spec.arm else 0.0
    return np.asarray(by_pose @ robot.localization.covariance @ by_pose.T + by_arm * np.eye(2))
