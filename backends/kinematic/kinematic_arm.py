"""The arm of the kinematic robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from backends.arm import Arm
from backends.limits import checked_joints
from backends.robot_file import RobotFile
from backends.scene.arm_error import ArmError
from backends.scene.hand import Hand
from backends.scene.keyed_noise import keyed
from backends.scene.swing import is_swing, swing_yaw

Vector = NDArray[np.float64]


class KinematicArm(Arm):
    """Joints that reach their command within the period, but for a contact and for repeatability.

    The joints stand off what their encoders read by an offset that is drawn anew whenever the arm sets out
    from rest: gears and links give, which no encoder sees.
    """

    def __init__(self, robot: RobotFile, hand: Hand, seed: int) -> None:
        self._hand, self._seed = hand, seed
        self._errors, self._period = robot.errors, robot.period_s
        top = np.inf if robot.arm is None else np.radians(robot.arm.top_speed_deg_s)
        self._top = np.minimum(hand.arm.velocity, top)
        self._command = hand.scene.joints.copy()
        self._reached = self._command.copy()
        self._motions, self._moving, self._settled = 0, False, False
        self._set_out = self._hand_on_floor()
        """Where the hand was when the arm last set out."""
        self.swung = False
        """Whether the arm came to rest in this period."""
        self._error = ArmError(robot.errors, hand.arm, seed)
        self._offset = self._error.offset(self._command, 0)
        hand.scene.joints = self._command + self._offset
        self._touching: frozenset[tuple[str, str]] = frozenset()
        self._now, self._readings = 0, dict[str, tuple[int, Vector]]()

    def move(self, joints: Vector) -> None:
        """See `Arm`."""
        most = self._top * self._period
        self._command = checked_joints(self._hand.arm, joints, self._reached, most)

    def command(self) -> Vector:
        """See `Arm`."""
        return self._command.copy()

    def joints(self) -> Vector:
        """See `Arm`."""
        motor = self._hand.scene.joints - self._offset
        return self._read("joints", motor, self._errors.encoder_mrad / 1e3)

    def hand_force(self) -> Vector:
        """See `Arm`."""
        return self._read("hand force", self._hand.scene.hand_force, self._errors.hand_force_n)

    def halt(self) -> None:
        """Forget a command that hasn't begun; hold."""
        self._command = self._reached.copy()

    def advance(self, period: int, disturbed: bool) -> frozenset[tuple[str, str]]:
        """Move for a period; gives what touches. `disturbed`: the fingers have moved."""
        self._now = period
        changed = bool((self._command != self._reached).any())
        if changed and not self._moving:
            self._motions += 1
            self._set_out = self._hand_on_floor()
        if changed:
            self._offset = self._error.offset(self._command, self._motions)
        self.swung = self._moving and not changed and self._is_swing()
        self._moving = changed
        self._reached = self._command.copy()
        if not changed and not disturbed and self._settled:
            return self._touching
        self._settled = not changed
        self._touching = self._hand.move(self._command + self._offset)
        return self._touching

    def swing_yaw(self) -> float:
        """By how much the swing that has ended turned the base, in [rad]."""
        return swing_yaw(self._errors, self._seed, self._motions)

    def _is_swing(self) -> bool:
        loaded = self._hand.scene.held is not None
        return is_swing(self._errors, loaded, self._set_out, self._hand_on_floor())

    def _hand_on_floor(self) -> Vector:
        """x and y (2,) of the hand in the base frame, in [m]."""
        return self._hand.arm.forward(self._reached)[:2, 3].copy()

    def _read(self, sensor: str, truth: Vector, sigma: float) -> Vector:
        last = self._readings.get(sensor)
        if last is None or last[0] != self._now:
            noise = sigma * keyed(self._seed, sensor, self._now).standard_normal(len(truth))
            last = self._readings[sensor] = (self._now, truth + noise)
        return last[1].copy()
