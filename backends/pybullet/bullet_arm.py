"""The arm of the simulated robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from backends.arm import Arm
from backends.limits import checked_joints
from backends.robot_file import RobotFile
from backends.scene.arm_error import ArmError
from backends.scene.keyed_noise import keyed
from backends.scene.swing import is_swing, swing_yaw
from robotics.kinematics.arm_model import ArmModel

from .physics import Physics
from .robot_body import RobotBody

GIVES = 0.03  # off its command by this, a drive gives all its torque [rad]
DAMPING = 0.03  # a speed that is off counts as this much angle that is off [s]
BREAKAWAY = 0.03  # share of its torque that a drive always has to give
CATCHES_UP = 0.02  # time constant of the position loop [s]

Vector = NDArray[np.float64]


class BulletArm(Arm):
    """Joints under position control with torque limits, their own weight and the load's compensated.

    Between two commands the set-point moves evenly. A drive is a velocity servo whose torque is limited by
    how far it is off, up to the URDF's effort: it gives like a spring where something is in its way.
    The joints stand off what their encoders read, by `ArmError`.
    """

    def __init__(
        self, robot: RobotFile, model: ArmModel, body: RobotBody, physics: Physics, seed: int
    ) -> None:
        """Take the arm's joints over, where they stand."""
        self._model, self._body, self._physics, self._seed = model, body, physics, seed
        self._errors = robot.errors
        top = np.inf if robot.arm is None else np.radians(robot.arm.top_speed_deg_s)
        self._most = np.minimum(model.velocity, top) * robot.period_s
        self._joints = [body.joint_index[name] for name in model.joint_names]
        self._effort = np.array([body.effort[name] for name in model.joint_names])
        self._motions, self._moving = 0, False
        self._command = body.states(self._joints)[0]
        self._error = ArmError(robot.errors, model, seed)
        self._offset = self._error.offset(self._command, 0)
        for name, angle in zip(model.joint_names, self._command + self._offset, strict=True):
            body.reset(name, float(angle))
        self._from = self._command.copy()
        self._set_out = self._hand_on_floor()
        self.swung = False
        """Whether a swing of the arm ended in this period: `is_swing`."""
        self._readings = dict[str, tuple[int, Vector]]()
        self._now = 0
        self.force: Vector = np.zeros(3)
        """What truly acts on the hand, (3,) in [N] in its frame, as measured in this period."""
        self.load: tuple[float, Vector] = (0.0, np.zeros(3))
        """Mass in [kg] of what is held, and its middle of mass in the base frame, (3,) in [m]."""

    def move(self, joints: Vector) -> None:
        """See `Arm`."""
        self._command = checked_joints(self._model, joints, self._from, self._most)

    def command(self) -> Vector:
        """See `Arm`."""
        return self._command.copy()

    def joints(self) -> Vector:
        """See `Arm`."""
        return self._read("joints", self.true_joints() - self._offset, self._errors.encoder_mrad / 1e3)

    def true_joints(self) -> Vector:
        """Where the joints are, (n,) in [rad]."""
        return self._body.states(self._joints)[0]

    def hand_force(self) -> Vector:
        """See `Arm`."""
        return self._read("hand force", self.force, self._errors.hand_force_n)

    def halt(self) -> None:
        """Forget a command that hasn't begun; hold."""
        self._command = self._from.copy()

    def begin(self, period: int) -> None:
        """A period begins."""
        self._now = period
        changed = bool((self._command != self._from).any())
        if changed and not self._moving:
            self._motions += 1
            self._set_out = self._hand_on_floor()
        if changed:
            self._offset = self._error.offset(self._command, self._motions)
        ended = self._moving and not changed
        self.swung = ended and is_swing(
            self._errors, self.load[0] > 0.0, self._set_out, self._hand_on_floor()
        )
        self._moving = changed

    def swing_yaw(self) -> float:
        """By how much the swing that has ended turned the base, in [rad]."""
        return swing_yaw(self._errors, self._seed, self._motions)

    def act(self, share: float, period: float) -> None:
        """Command the drives for the next chunk, when `share` of the `period` in [s] has passed."""
        way = self._command - self._from
        angles, speeds = self._body.states(self._joints)
        rate = way / period
        off = self._from + share * way + self._offset - angles
        wanted = rate + off / CATCHES_UP
        strain = np.abs(off) + DAMPING * np.abs(rate - speeds)
        most = self._effort * np.minimum(strain / GIVES + BREAKAWAY, 1.0)  # never negative
        p, client = self._physics.p, self._physics.client
        p.setJointMotorControlArray(
            self._body.id,
            self._joints,
            p.VELOCITY_CONTROL,
            targetVelocities=wanted.tolist(),
            forces=(most / self._physics.substeps).tolist(),
            physicsClientId=client,
        )
        p.setJointMotorControlArray(
            self._body.id, self._joints, p.TORQUE_CONTROL, forces=self._weight(angles), physicsClientId=client
        )

    def end(self) -> None:
        """A period has ended."""
        self._from = self._command.copy()

    def _weight(self, angles: Vector) -> list[float]:
        """Torques (n,) in [Nm] that carry arm and load."""
        torque = self._model.gravity_torque(angles)
        mass, middle = self.load
        if mass > 0.0:
            torque = torque + self._model.load_torque(angles, middle, mass)
        torques: list[float] = torque.tolist()
        return torques

    def _hand_on_floor(self) -> Vector:
        """x and y (2,) of the hand in the base frame where it is commanded to, in [m]."""
        return self._model.forward(self._from)[:2, 3].copy()

    def _read(self, sensor: str, truth: Vector, sigma: float) -> Vector:
        last = self._readings.get(sensor)
        if last is None or last[0] != self._now:
            noise = sigma * keyed(self._seed, sensor, self._now).standard_normal(len(truth))
            last = self._readings[sensor] = (self._now, truth + noise)
        return last[1].copy()
