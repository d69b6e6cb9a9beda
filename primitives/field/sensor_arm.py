"""Arm that carries a sensor to its target, shared by DEPLOY and MOVE_TO."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.field import field_causes
from handcart.primitives.motions.arm_motion import collision_model, follow
from handcart.primitives.motions.felt_force import awaited_force
from handcart.primitives.motions.grip import close, hand_to_tips, open_to
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.restoring.snapshot import is_holding
from handcart.robotics.manipulation.arms.resolved_rate import RateLimits, ResolvedRate, line_postures, way_to
from handcart.robotics.manipulation.arms.scara import world_to_base
from handcart.robotics.manipulation.motions.collision_model import HELD_NAME
from handcart.robotics.numerics.arrays import FloatArray

from .field import Field
from .scara_arm import scara_of

SLIDE_SPEED_M_S = 0.15  # of the slide
TOUCH_FORCE_N = 5.0
WIDTH_ERROR = 0.004  # [m] by which a sensor may be thicker or thinner
LINE_END_TOLERANCE_M = 3e-4  # of the tip from the end of its line
LONGEST_LINE = 30.0  # [s]
LEANING_FORCE_N = 0.35  # across a finger, from where on something leans on it
GIVES_WAY = 0.02  # [m/s] to what leans on a finger
MAX_YIELD_M = 0.06  # that it gives way
AT_HOME = 0.02  # [rad] and [m] of a joint's command from the posture `home`
FREE_TIME_S = 0.4  # without a push, until nothing leans there any more
FORCE_SMOOTHING_S = 0.1  # over which the force is smoothed


class SensorArm:
    """Motions by which a SCARA arm with fingers takes a sensor, brings it over a place, and returns.

    Places are x and y (2,) in [m] in the arm's own frame, whose origin is on the axis of the arm's first
    joint.
    """

    def __init__(self, robot: Robot, field: Field) -> None:
        """Read the geometry of the robot's arm; raise `Discrepancy` if it is not a SCARA arm."""
        self._robot, self._field = robot, field
        self.scara = scara_of(robot)
        self.below = field.below(hand_to_tips(robot))
        """Height of the frame `hand` above the foot of a held sensor, in [m]."""
        self.wide = math.hypot(*field.sensor_mm[:2]) / 2e3
        """Half of a sensor's diagonal, seen from above, in [m]."""
        self._home, self._middle = (np.array(robot.spec.posture(name)) for name in ("home", "middle"))

    @property
    def holds(self) -> bool:
        """Return whether the fingers hold an object as wide as a sensor."""
        return self._robot.gripper.closed_on_something() and self._off() < WIDTH_ERROR

    def not_ready(self) -> str:
        """Return why the hand cannot take a sensor from the magazine (the robot's store of sensors); empty if
        it can take one, or holds one already.
        """
        if self.holds:
            return ""
        if is_holding(self._robot):
            width, sensor = 1e3 * self._robot.gripper.width(), self._field.sensor_mm[1]
            return f"the hand holds something {width:.1f} mm thick, which is no sensor of {sensor:.1f} mm"
        off = np.abs(self._robot.arm.command() - self._home)
        if float(off.max()) > AT_HOME:
            return "the arm is not at home, where the magazine gives it a sensor"
        return ""

    def _off(self) -> float:
        return abs(self._robot.gripper.width() - self._field.sensor_mm[1] / 1e3)

    def take(self) -> Periods:
        """Close the fingers on the sensor in the magazine, with the arm in its posture `home`.

        Raises:
            Discrepancy: the fingers hold no sensor.
        """
        if not self.holds:
            yield from open_to(self._robot)
            yield from self._robot.wait(2 * self._robot.period)
            yield from close(self._robot)
        off = self._off()
        if exceeds(off, WIDTH_ERROR):
            read = Measured("Gripper", "opening off a sensor's width", 1e3 * off, 1e3 * WIDTH_ERROR, "mm")
            raise Discrepancy(
                "the magazine gives no sensor",
                permanent=True,
                measured=read,
                cause=field_causes.MAGAZINE_EMPTY,
            )

    def place_of(self, point: FloatArray) -> FloatArray:
        """Convert a point on the ground to the arm's own frame; return x and y (2,), in [m].

        The conversion uses the estimated pose and tilt of the base.

        Args:
            point: (2,) in the field's frame, in [m].
        """
        robot = self._robot
        return self.place_beside(
            world_to_base(robot.pose, robot.localization.tilt, np.array([*point, 0.0]))[:2]
        )

    def place_beside(self, point: FloatArray) -> FloatArray:
        """Convert a point from the base frame to the arm's own frame; return x and y (2,), in [m].

        Args:
            point: (2,) in the base frame, in [m].
        """
        mount = self.scara.mount
        cos, sin = math.cos(mount[3]), math.sin(mount[3])
        return np.asarray((point - np.array(mount[:2])) @ np.array([[cos, -sin], [sin, cos]]))

    def check_near(self, place: FloatArray, unsure: float) -> None:
        """Check that a place may be in the arm's reach, given the place's uncertainty.

        Args:
            place: (2,) in the arm's own frame, in [m].
            unsure: possible error of the place, in [m].

        Raises:
            Discrepancy: the place is out of reach by more than `unsure`.
        """
        if math.hypot(*place) > self.scara.upper + self.scara.fore + unsure:
            raise _out_of_reach(place)

    def reach(self, place: FloatArray) -> Periods:
        """Bring the arm's tip over a place, from posture `home` through posture `middle`.

        It is checked beforehand that the arm touches nothing on its path.

        Args:
            place: (2,) in the arm's own frame, in [m].

        Raises:
            Discrepancy: the place is out of reach, or the path is not free.
        """
        here = self._robot.arm.command()
        begin = self._middle if here[0] > self._middle[0] else here
        way = way_to(self.scara, begin, place)
        if way is None:
            raise _out_of_reach(place)
        yield from self._robot.compute(self._check_free, begin, way)
        if begin is self._middle:
            yield from follow(self._robot, np.array([here, begin]))
        for end in way:
            yield from self.lead(end)

    def _check_free(self, begin: FloatArray, way: list[FloatArray]) -> None:
        """Raise `Discrepancy` if links, hand or sensor would touch wheels or body on the way.

        Args:
            begin: (3,) joints from which the tip is led, in [rad] and [m].
            way: ends (2,) of the straight lines in the arm's own frame, in [m].
        """
        collision = collision_model(self._robot, self._field.held(hand_to_tips(self._robot), HELD_NAME))
        path = [self._robot.arm.command(), begin]
        for end in way:
            line = line_postures(self.scara, path[-1], end)
            if line is None:
                raise Discrepancy(
                    "the arm can't lead the sensor to the target within its limits", cause=causes.OUT_OF_REACH
                )
            path += [np.array([*angles, begin[2]]) for angles in line[1:]]
        path.append(np.array([*path[-1][:2], self.scara.slide[1]]))
        if not collision.path_free(np.array(path), step=0.03):
            hits = next((found for q in path if (found := collision.contacts(q))), [("the arm", "the robot")])
            raise Discrepancy(
                f"{hits[0][0]} would touch {hits[0][1]} on the way to the target", cause=causes.NO_ARM_PATH
            )

    def line_free(self, place: FloatArray) -> bool:
        """Return whether the arm's tip can move level and straight to a place, then down to the slide's end.

        The arm must be able to follow this path, and touch nothing on it.

        Args:
            place: (2,) in the arm's own frame, in [m].
        """
        here = self._robot.arm.command()
        line = line_postures(self.scara, here, place)
        if line is None or not self.scara.within(line[-1], working=True):
            return False
        collision = collision_model(self._robot, self._field.held(hand_to_tips(self._robot), HELD_NAME))
        path = [np.array([*angles, here[2]]) for angles in line]
        path.append(np.array([*path[-1][:2], self.scara.slide[1]]))
        return collision.path_free(np.array(path), step=0.03)

    def lead(self, end: FloatArray) -> Periods:
        """Bring the tip to a place in a straight line, by resolved-rate control (through the Jacobian).

        Args:
            end: (2,) place in the arm's own frame, in [m].

        Raises:
            Discrepancy: the arm does not get to the end of its line.
        """
        robot, joints = self._robot, self._robot.arm.command()
        rates = ResolvedRate(self.scara, self.scara.tip(joints), end, RateLimits(rate=self._top()))
        begun = robot.time
        while rates.left(joints) > LINE_END_TOLERANCE_M:
            if robot.time - begun > LONGEST_LINE:
                raise Discrepancy("the arm doesn't come to the end of its line", cause=causes.OFF_GOAL)
            joints = joints.copy()
            joints[:2] += robot.period * rates.command(joints[:2], robot.period)
            robot.arm.move(joints)
            yield

    def _top(self) -> float:
        """Return the speed limit of the two turning joints, in [rad/s]."""
        return float(self._robot.joint_speeds[:2].min()) * (1.0 - 1e-6)

    def slide(self, goal: float, speed: float = SLIDE_SPEED_M_S) -> Generator[None, None, float]:
        """Move the arm's vertical slide to a position; on its way down, stop when the hand touches something.

        Args:
            goal: position of the slide, in [m]; larger is lower.
            speed: speed of the slide, in [m/s].

        Returns:
            Force from below that has stopped the hand, in [N]; 0 if the slide has reached its goal.
        """
        robot = self._robot
        step = min(speed, float(robot.joint_speeds[2])) * robot.period * (1.0 - 1e-6)
        while abs(goal - (at := robot.arm.command()[2])) > 1e-6:
            joints = robot.arm.command()
            joints[2] = at + max(-step, min(step, goal - at))
            robot.arm.move(joints)
            yield
            force = -float((yield from awaited_force(robot))[0])
            if goal > at and force > TOUCH_FORCE_N:
                return force
        return 0.0

    def give_way(self) -> Periods:
        """Move the open fingers in the direction in which a sensor leans on one of them.

        The motion ends when the sensor is upright by itself, or the fingers have moved by `MAX_YIELD_M`.
        """
        robot, push, gone, free = self._robot, 0.0, 0.0, 0.0
        share = min(1.0, robot.period / FORCE_SMOOTHING_S)
        while free < FREE_TIME_S and gone < MAX_YIELD_M:
            yield
            push += share * (float((yield from awaited_force(robot))[1]) - push)
            free = free + robot.period if abs(push) <= LEANING_FORCE_N else 0.0
            if not free:
                gone += GIVES_WAY * robot.period
                self._shift(math.copysign(GIVES_WAY * robot.period, push))

    def _shift(self, way: float) -> None:
        """Move the tip along the fingers' stroke by `way` in [m]; the sign is that of the hand's y axis."""
        joints = self._robot.arm.command()
        angle = self.scara.mount[3]
        turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        stroke = self._robot.base_T("hand")[:2, 1] @ turned
        joints[:2] += np.linalg.solve(self.scara.jacobian(joints), way * stroke)
        if self.scara.within(joints):
            self._robot.arm.move(joints)

    def stow(self) -> Periods:
        """Raise the arm, move it through posture `middle` of the robot's file to its posture `home`, and open
        the fingers.
        """
        yield from self.slide(float(self._home[2]))
        if self._robot.arm.command()[0] <= self._middle[0]:
            yield from self._back_to_middle()
        yield from follow(self._robot, np.array([self._robot.arm.command(), self._home]))
        yield from open_to(self._robot)

    def _back_to_middle(self) -> Periods:
        end = self.scara.tip(self._middle)
        if line_postures(self.scara, self._robot.arm.command(), end) is not None:
            yield from self.lead(end)
        yield from follow(self._robot, np.array([self._robot.arm.command(), self._middle]))


def _out_of_reach(place: FloatArray) -> Discrepancy:
    return Discrepancy(
        f"the arm doesn't reach the target from here: it is at ({place[0]:.2f}, {place[1]:.2f}) m",
        cause=causes.OUT_OF_REACH,
    )
