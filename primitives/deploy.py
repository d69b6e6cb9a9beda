"""DEPLOY: lay a sensor on its target in the field."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field as Limited
from pydantic import PrivateAttr

from backends.arm import Arm
from backends.gripper import Gripper
from backends.imu import Imu
from backends.robot import Robot
from robotics.manipulation.collision_model import HELD
from robotics.manipulation.resolved_rate import RateLimits, ResolvedRate, line_postures, way_to
from robotics.manipulation.scara import Scara, base_to_world, world_to_base

from .action_primitive import ActionPrimitive, Periods
from .arm_motion import collision_model, follow
from .discrepancy import Discrepancy, Measured
from .field import Field
from .grip import close, hand_to_tips, open_to
from .place_name import TargetName
from .scara_arm import scara_of
from .snapshot import settle
from .target import Laid, Target
from .world_model import ModelView

FAST, SLOW = 0.15, 0.03  # [m/s] of the slide
NEAR = 0.03  # [m] above the ground, from where the sensor is lowered slowly
PAST = 0.05  # [m] below where the ground should be
TOUCHES = 5.0  # [N]
WIDTH_ERROR = 0.004  # [m] by which a sensor may be thicker or thinner
ARRIVED = 3e-4  # [m] of the tip from the end of its line
REFINED = 0.002  # [m] by which a better estimate moves the tip once more
REFINED_MOST = 0.3  # [m] by which it may, just above the ground
ROOM = 0.010  # [m] that the fingers open wider than the sensor
LONGEST_LINE = 30.0  # [s]

Vector = NDArray[np.float64]


class Deploy(ActionPrimitive):
    """Lay a sensor on its target: the base stands to the left of it (Ohki et al. 2012, section V-B).

    The fingers close on the sensor that the magazine gives them. The base stands until it is known well
    enough where the target is; the arm goes through its middle state, its tip then on straight lines to above
    the target by resolved rates, roll and pitch of the base taken into account; what the fixes told meanwhile
    corrects it. The sensor is lowered until it touches the ground and let go, which can't be undone; then the
    arm goes back the way it came.
    """

    target: TargetName
    """Which."""
    settle_s: Annotated[float, Limited(ge=0.0, le=600.0)] = 0.0
    """How long the base stands at least before the arm moves."""
    sure_mm: Annotated[float, Limited(gt=0.0)] = 250.0
    """One sigma of where the target is, along the worst direction: it stands until it is that well known."""
    longest_s: Annotated[float, Limited(ge=0.0, le=3600.0)] = 120.0
    """How long it stands for that at most; then it Fails."""

    needs: ClassVar = (Arm, Gripper, Imu)
    reads: ClassVar = ("targets", "field")
    writes: ClassVar = ("laid",)

    _arm: Scara | None = PrivateAttr(default=None)

    def hindrance(self, robot: Robot, model: ModelView) -> str:
        """No such target, or it is laid already."""
        if model.field is None or self.target not in model.targets:
            return f"there is no target {self.target!r} in the field"
        if any(laid.name == self.target for laid in model.laid):
            return f"the sensor of target {self.target!r} is laid already"
        return ""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        field, target = self._told(model)
        self._arm = scara_of(robot)
        yield from self._take(robot, field)
        yield from self._be_sure(robot, target)
        yield from self._reach(robot, field, target)
        yield from self._lower(robot, field, target)
        yield from self.intend("the fingers let the sensor go")
        self.point_of_no_return("the sensor is let go")
        robot.note_place()
        model.laid = (*model.laid, self._laid(robot, field))
        yield from open_to(robot, field.sensor_mm[1] / 1e3 + ROOM)
        yield from self._withdraw(robot)

    def finish(self, robot: Robot, model: ModelView) -> Periods:
        """Lift the slide and bring the arm back."""
        yield from settle(robot)
        yield from self._withdraw(robot)

    def _told(self, model: ModelView) -> tuple[Field, Target]:
        if model.field is None or self.target not in model.targets:
            raise Discrepancy(f"there is no target {self.target!r} in the field", permanent=True)
        return model.field, model.targets[self.target]

    @property
    def _scara(self) -> Scara:
        if self._arm is None:
            raise Discrepancy("the arm isn't known yet")
        return self._arm

    # Before the arm moves

    def _take(self, robot: Robot, field: Field) -> Periods:
        """Close the fingers on the sensor in the magazine."""
        wide = field.sensor_mm[1] / 1e3
        if not (robot.gripper.closed_on_something() and abs(robot.gripper.width() - wide) < WIDTH_ERROR):
            yield from open_to(robot)
            yield from robot.wait(2 * robot.period)
            yield from close(robot)
        off = abs(robot.gripper.width() - wide)
        if off > WIDTH_ERROR:
            read = Measured("Gripper", "opening off a sensor's width", 1e3 * off, 1e3 * WIDTH_ERROR, "mm")
            raise Discrepancy("the magazine gives no sensor", permanent=True, measured=read)

    def _be_sure(self, robot: Robot, target: Target) -> Periods:
        """Stand until it is known well enough where the target is."""
        yield from robot.wait(self.settle_s)
        begun = robot.time
        while (sigma := self._sigma(robot, target)) > self.sure_mm / 1e3:
            if robot.time - begun > self.longest_s:
                known = Measured("Gps", "sigma of where the target is", 1e3 * sigma, self.sure_mm, "mm")
                raise Discrepancy("it isn't known well enough where the target is", measured=known)
            yield
        self.found(stood_s=round(robot.time - begun + self.settle_s, 2), sigma_mm=round(1e3 * sigma, 1))

    def _sigma(self, robot: Robot, target: Target) -> float:
        """Of the target in the base's frame, along the worst direction, in [m]."""
        away = np.array([target.x - robot.pose.x, target.y - robot.pose.y])
        return math.sqrt(float(np.linalg.eigvalsh(_spread(robot, away))[-1]))

    # Over the target

    def _reach(self, robot: Robot, field: Field, target: Target) -> Periods:
        middle = np.array(robot.spec.posture("middle"))
        place = self._place(robot, target)
        way = way_to(self._scara, middle, place)
        if way is None:
            x, y = world_to_base(robot.pose, robot.tilt, np.array([target.x, target.y, 0.0]))[:2]
            raise Discrepancy(f"the arm doesn't reach the target from here: it is at ({x:.2f}, {y:.2f}) m")
        yield from robot.compute(self._check_free, robot, field, middle, way)
        yield from follow(robot, np.array([robot.arm.command(), middle]))
        for end in way:
            yield from self._lead(robot, end)

    def _refine(self, robot: Robot, target: Target) -> Periods:
        """Just above the ground: move to where the target is by what is known by now."""
        better = self._place(robot, target)
        joints = robot.arm.command()
        moved = float(np.hypot(*(better - self._scara.tip(joints))))
        line = line_postures(self._scara, joints, better)
        free = line is not None and self._scara.within(line[-1], working=True)
        self.found(refined_mm=round(1e3 * moved, 1))
        if moved > REFINED_MOST or (moved > REFINED and not free):
            off = Measured("Gps", "where the target is by now, off the tip", 1e3 * moved, 1e3 * REFINED, "mm")
            raise Discrepancy("by what is known now the target is out of reach from here", measured=off)
        if moved > REFINED:
            yield from self._lead(robot, better)

    def _place(self, robot: Robot, target: Target) -> Vector:
        """(2,) where the tip is over the target, in the arm's frame, by what is known now, in [m]."""
        point = world_to_base(robot.pose, robot.tilt, np.array([target.x, target.y, 0.0]))
        shoulder = np.array(self._scara.mount[:2])
        cos, sin = math.cos(self._scara.mount[3]), math.sin(self._scara.mount[3])
        return np.asarray((point[:2] - shoulder) @ np.array([[cos, -sin], [sin, cos]]))

    def _check_free(self, robot: Robot, field: Field, middle: Vector, way: list[Vector]) -> None:
        """Raise `Discrepancy` where links, hand or sensor come to wheels or body on the way there."""
        sensor = field.held(hand_to_tips(robot), HELD)
        collision = collision_model(robot, sensor)
        path = [robot.arm.command(), middle]
        for end in way:
            line = line_postures(self._scara, path[-1], end)
            if line is None:
                raise Discrepancy("the arm can't lead the sensor to the target within its limits")
            path += [np.array([*angles, 0.0]) for angles in line[1:]]
        path.append(np.array([*path[-1][:2], self._scara.slide[1]]))
        if not collision.path_free(np.array(path), step=0.03):
            hits = next((found for q in path if (found := collision.contacts(q))), [("the arm", "the robot")])
            raise Discrepancy(f"{hits[0][0]} would touch {hits[0][1]} on the way to the target")

    def _lead(self, robot: Robot, end: Vector) -> Periods:
        """Bring the tip to a place (2,) in the arm's frame in a straight line, by resolved rates."""
        scara, joints = self._scara, robot.arm.command()
        rates = ResolvedRate(scara, scara.tip(joints), end, RateLimits(rate=float(self._top(robot).min())))
        begun = robot.time
        while rates.left(joints) > ARRIVED:
            if robot.time - begun > LONGEST_LINE:
                raise Discrepancy("the arm doesn't come to the end of its line")
            joints = joints.copy()
            joints[:2] += robot.period * rates.command(joints[:2], robot.period)
            robot.arm.move(joints)
            yield

    def _top(self, robot: Robot) -> Vector:
        """(2,) what the turning joints may do, in [rad/s]."""
        spec = robot.spec.arm
        most = math.radians(spec.top_speed_deg_s) if spec else math.inf
        return np.minimum(robot.arm_model.velocity[:2], most) * (1.0 - 1e-6)

    # Down, and up again

    def _lower(self, robot: Robot, field: Field, target: Target) -> Periods:
        """Down until the sensor stands on the ground."""
        point = world_to_base(robot.pose, robot.tilt, np.array([target.x, target.y, 0.0]))
        down = self._scara.mount[2] - field.below(hand_to_tips(robot)) - float(point[2])
        if not 0.0 < down + PAST <= self._scara.slide[1]:
            low = Measured(
                "Arm", "what the slide would have to go down", down + PAST, self._scara.slide[1], "m"
            )
            raise Discrepancy("the slide doesn't reach the ground", measured=low)
        force = yield from self._slide(robot, down - NEAR, FAST)
        if force > TOUCHES:
            felt = Measured("Arm", "force from below", force, TOUCHES, "N")
            raise Discrepancy("something lies where the sensor goes", measured=felt)
        yield from self._refine(robot, target)
        force = yield from self._slide(robot, down + PAST, SLOW)
        if force <= TOUCHES:
            felt = Measured("Arm", "force from below", force, TOUCHES, "N")
            raise Discrepancy("there is no ground below the sensor", measured=felt)
        robot.arm.move(robot.arm.joints().clip(robot.arm_model.lower, robot.arm_model.upper))
        yield
        self.found(
            lowered_mm=round(1e3 * (float(robot.arm.command()[2])), 1),
            off_mm=round(1e3 * (float(robot.arm.command()[2]) - down), 1),
        )

    def _slide(self, robot: Robot, goal: float, speed: float) -> Generator[None, None, float]:
        """Move the slide to `goal` [m], or until the hand meets something; gives the force from below."""
        step = min(speed, float(robot.arm_model.velocity[2])) * robot.period * (1.0 - 1e-6)
        while abs(goal - (at := robot.arm.command()[2])) > 1e-6:
            joints = robot.arm.command()
            joints[2] = at + max(-step, min(step, goal - at))
            robot.arm.move(joints)
            yield
            force = -float(robot.arm.hand_force()[0])
            if goal > at and force > TOUCHES:
                return force
        return 0.0

    def _laid(self, robot: Robot, field: Field) -> Laid:
        """What is believed of the sensor that is about to be let go."""
        below = field.below(hand_to_tips(robot))
        foot = self._scara.base_tip(robot.arm.joints()) - (0.0, 0.0, below)
        x, y, _ = base_to_world(robot.pose, robot.tilt, foot).tolist()
        spread = _spread(robot, np.array([x - robot.pose.x, y - robot.pose.y]))
        covariance = (float(spread[0, 0]), float(spread[0, 1]), float(spread[1, 1]))
        self.found(laid_x_m=round(x, 3), laid_y_m=round(y, 3))
        ahead, left = robot.pose.inverse().apply(np.array([[x, y]])).reshape(2).tolist()
        return Laid(self.target, x, y, covariance, (ahead, left), robot.time)

    def _withdraw(self, robot: Robot) -> Periods:
        """Up, through the middle state, home."""
        home, middle = (np.array(robot.spec.posture(name)) for name in ("home", "middle"))
        yield from self._slide(robot, float(home[2]), FAST)
        here = robot.arm.command()
        if here[0] <= middle[0]:
            yield from self._back_to(robot, middle)
        yield from follow(robot, np.array([robot.arm.command(), home]))
        yield from open_to(robot)

    def _back_to(self, robot: Robot, middle: Vector) -> Periods:
        scara = self._scara
        end = scara.tip(middle)
        if line_postures(scara, robot.arm.command(), end) is not None:
            yield from self._lead(robot, end)
        yield from follow(robot, np.array([robot.arm.command(), middle]))


def _spread(robot: Robot, away: Vector) -> Vector:
    """(2, 2) covariance in [m²] of a point that is `away` (2,) from the base in the field's axes, in [m]."""
    by_pose = np.array([[1.0, 0.0, -away[1]], [0.0, 1.0, away[0]]])
    return np.asarray(by_pose @ robot.pose_covariance @ by_pose.T)
