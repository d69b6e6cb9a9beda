"""Moving one axis by hand: hold-to-run, slowly."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import InputError
from handcart.files.suggest import suggest

from .operator import Held

CapabilityT = TypeVar("CapabilityT", bound=Capability)

KEY_LEASE_S = 0.3
"""Time for which a pressed key counts as held without a repeat, in [s] (row U6)."""
HAND_SPEED = 0.25
"""Maximum speed of every part of the robot until it is signed off, in [m/s]."""
TOP_TURN = math.radians(30.0)
"""Maximum speed of a joint, in [rad/s], however near the hand is to its axis."""
_SETTLE = 2.0  # [s] in which an axis comes to rest
_STILL = 1e-4  # [m], [rad] in a period
_CREEP = 0.005  # [m/s], [rad/s] with which it arrives


class KeyLease:
    """Test whether a key is still held, by the repeats that a held key sends.

    After 300 ms without a repeat the key counts as released, and later repeats do not count.
    """

    def __init__(self, pressed: Callable[[], bool], clock: Callable[[], float] = time.monotonic) -> None:
        """Begin; the key has 300 ms from now.

        Args:
            pressed: returns whether the key was repeated since the last call.
            clock: gives the time in [s].
        """
        self._pressed, self._clock = pressed, clock
        self._until = clock() + KEY_LEASE_S
        self._over = False

    def __call__(self) -> bool:
        """Return whether the key is still held."""
        now = self._clock()
        self._over = self._over or now > self._until
        if self._pressed() and not self._over:
            self._until = now + KEY_LEASE_S
        return not self._over


class UnknownAxis(InputError):
    """Error for the name of an axis that the robot does not have."""

    def __init__(self, name: str, axes: list[str]) -> None:
        super().__init__(f"unknown axis {name!r}{suggest(name, axes)}")


class Jogged(NamedTuple):
    """Result of moving one axis with `Jogger.jog`, with travel, duration and reason of the end."""

    way: float
    """Signed travel by the encoder, in [m] or [rad]."""
    seconds: float
    top_speed: float
    """Largest commanded speed, in [m/s] or [rad/s]."""
    ended: str
    """Reason of the end, `there` (way done), `let go` (key released) or `limit` (limit of the joint)."""


@dataclass
class Jogger:
    """Controller that moves single axes of a robot through its backend while a key is held.

    Axes are named as in the section `can` of the robot's file.
    """

    backend: Backend
    robot: RobotFile

    def __post_init__(self) -> None:
        self._base: Base = _part(self.backend.get(Base))  # type: ignore[type-abstract]
        self._arms = self.backend.get(Arm)  # type: ignore[type-abstract]
        self._grippers = self.backend.get(Gripper)  # type: ignore[type-abstract]
        self._model = None if self.robot.arm is None else self.robot.arm_model()

    @property
    def _arm(self) -> Arm:
        return _part(self._arms)

    @property
    def _gripper(self) -> Gripper:
        return _part(self._grippers)

    @property
    def axes(self) -> list[str]:
        """Names of the axes of the robot's CAN drives, each of which an operator can jog."""
        return [name for name, _ in self.robot.can.axes()] if self.robot.can else []

    def jog(self, axis: str, way: float, held: Held, slower: float = 1.0) -> Jogged:
        """Move an axis while a key is held, and stop it; the axis is at rest afterwards.

        Args:
            axis: name of the axis.
            way: travel after which the axis stops at the latest, in [m] or [rad]; negative towards the lower
                limit.
            held: returns whether the key is still held.
            slower: factor of the axis' top speed, at most 1.

        Raises:
            UnknownAxis: the robot has no axis of that name.
        """
        if axis not in self.axes:
            raise UnknownAxis(axis, self.axes)
        begun, fastest, periods, ended = self.position(axis), 0.0, 0, "there"
        last = 0.0
        while abs(self.position(axis) - begun) < abs(way):
            if not held():
                ended = "let go"
                break
            left = abs(way) - abs(self.position(axis) - begun)
            speed = math.copysign(min(slower * self.top_speed(axis), self._braked(axis, left, last)), way)
            last = abs(speed)
            if not self._command(axis, speed):
                ended = "limit"
                break
            fastest, periods = max(fastest, abs(speed)), periods + 1
            self.backend.step()
        if ended == "limit":
            self.settle()  # the drive is still on its way there
        self.backend.stop()
        self.settle()
        return Jogged(self.position(axis) - begun, periods * self.backend.period, fastest, ended)

    def position(self, axis: str) -> float:
        """Return the position of an axis by its encoder, in [m] or [rad]."""
        kind, number = _parts(axis)
        if kind == "wheel":
            travel = self._base.wheel_travel()
            return travel.left if number == 0 else travel.right
        if kind == "joint":
            return float(self._arm.joints()[number])
        return self._gripper.width()

    def limits(self, axis: str) -> tuple[float, float]:
        """Return the lower and upper limit of an axis, in [rad] or [m].

        Wheels and joints that turn without end have infinite limits.
        """
        kind, number = _parts(axis)
        if kind == "wheel":
            return -math.inf, math.inf
        if kind == "gripper":
            assert self.robot.gripper is not None
            return 0.0, self.robot.gripper.opening_mm / 1e3
        assert self._model is not None
        if self._model.endless[number]:
            return -math.inf, math.inf
        return float(self._model.lower[number]), float(self._model.upper[number])

    def top_speed(self, axis: str) -> float:
        """Return the highest speed of an axis at which no part of the robot exceeds 250 mm/s, in [m/s] or
        [rad/s].
        """
        kind, number = _parts(axis)
        if kind == "wheel":
            # One wheel alone: the robot turns about the other, and the hand with it.
            tread = self.robot.drive.tread_m
            return min(HAND_SPEED * tread / max(tread, tread / 2 + self._reach()), self._rim_limit())
        if kind == "joint":
            assert self._model is not None
            lever = float(np.linalg.norm(self._model.jacobian(self._arm.joints())[:3, number]))
            top = min(TOP_TURN, float(self.robot.joint_speeds()[number]))
            return min(HAND_SPEED / max(lever, 0.1), top)
        assert self.robot.gripper is not None
        return min(HAND_SPEED, self.robot.gripper.speed_mm_s / 1e3)

    def _braked(self, axis: str, left: float, last: float) -> float:
        """Return the largest speed from which an axis stops within `left`; the command `last` acts for two
        more periods.
        """
        kind, number = _parts(axis)
        of_joints, of_base = self.robot.joint_accelerations(), self.robot.drive.acceleration_m_s2
        rate = float(of_joints[number]) if kind == "joint" else of_base
        room = left - 2 * self.backend.period * last
        return max(math.sqrt(2 * rate * max(room, 0.0)), _CREEP)

    def settle(self) -> float:
        """Run control periods until no axis moves, or a time-out; return the elapsed time, in [s]."""
        before, passed = self._positions(), 0.0
        while passed < _SETTLE:
            self.backend.step()
            passed += self.backend.period
            now = self._positions()
            if np.abs(now - before).max(initial=0.0) < _STILL:
                break
            before = now
        return passed

    def _command(self, axis: str, speed: float) -> bool:
        """Command a period's motion within the limits; return whether that moves the axis."""
        kind, number = _parts(axis)
        if kind == "wheel":
            turn = speed / self.robot.drive.tread_m
            self._base.drive(speed / 2, -turn if number == 0 else turn)
            return True
        way = speed * self.backend.period
        lower, upper = self.limits(axis)
        if kind == "joint":
            wanted = self._arm.command().copy()
            before = float(wanted[number])
            wanted[number] = min(max(before + way, lower), upper)
            self._arm.move(wanted)
            return float(wanted[number]) != before
        width = self._gripper.command()
        self._gripper.move(min(max(width + way, lower), upper))
        return self._gripper.command() != width

    def _reach(self) -> float:
        """Return the distance of the hand from the base's axis, or the footprint's radius without an arm, in
        [m].
        """
        radius = self.robot.footprint_radius_m
        if self._model is None:
            return radius
        hand = self._model.forward(self._arm.joints())
        return max(radius, float(np.hypot(hand[0, 3], hand[1, 3])))

    def _rim_limit(self) -> float:
        drive = self.robot.drive
        return min(2 * drive.top_speed_m_s, math.radians(drive.top_turn_deg_s) * drive.tread_m)

    def _positions(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        return np.array([self.position(axis) for axis in self.axes])


def _part(found: CapabilityT | None) -> CapabilityT:
    """Return the capability behind an axis of the section `can`."""
    assert found is not None
    return found


def slides(robot: RobotFile, axis: str) -> bool:
    """Return whether an axis, given its name, is a sliding joint."""
    kind, number = _parts(axis)
    return kind == "joint" and number < len(robot.joint_units.slides) and robot.joint_units.slides[number]


def _parts(axis: str) -> tuple[str, int]:
    """Split an axis' name into kind and index from 0, such as `joint 3` into `joint` and 2."""
    if axis.endswith("wheel"):
        return "wheel", 0 if axis.startswith("left") else 1
    if axis.startswith("joint"):
        return "joint", int(axis.split()[1]) - 1
    return "gripper", 0
