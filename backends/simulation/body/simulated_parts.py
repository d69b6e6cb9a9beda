"""Common parts of simulated wheels, arms and grippers: commands, and readings with errors."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.arm import ForceArm
from handcart.backends.capabilities.base import Base, DriveCommand, HolonomicBase, WheelTravel
from handcart.backends.commanded_parts import CommandedGripper
from handcart.backends.description.robot_file import GripperSpec, RobotFile
from handcart.backends.description.simulated_errors import Errors
from handcart.backends.limits import checked_command, checked_joints
from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.body.swing import is_swing, swing_yaw
from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.small_solve import lapack_solved

_DAMPING = 1e-8 * np.eye(6)
_GIVES = 5e-3  # [rad] by which joints give together at most


class CommandedBase(Base):
    """Base class of simulated bases, which checks and stores the commanded speeds; a command is valid for the
    next period only.
    """

    STATE: ClassVar[Kinds] = {"_command": DriveCommand, "_travel": WheelTravel}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, robot: RobotFile) -> None:
        self._drive, self._period = robot.drive, robot.period_s
        self._command = DriveCommand()
        self._travel = WheelTravel(0.0, 0.0)

    @override
    def drive(self, speed: float, turn_rate: float) -> None:
        self._command = checked_command(self._drive, speed, turn_rate)

    @override
    def wheel_travel(self) -> WheelTravel:
        return self._travel

    def halt(self) -> None:
        """Drop the command, so that the wheels stop in the next period."""
        self._command = DriveCommand()

    def _take_command(self) -> DriveCommand:
        """Return the command of the period that begins."""
        command, self._command = self._command, DriveCommand()
        return command


class CommandedHolonomicBase(CommandedBase, HolonomicBase):
    """Base class of simulated bases that drive in any direction, which checks and stores the commanded
    speeds.
    """

    @override
    def drive(self, speed: float, turn_rate: float, sideways: float = 0.0) -> None:
        self._command = checked_command(self._drive, speed, turn_rate, sideways)


class SimulatedArm(ForceArm):
    """Base class of simulated arms that checks commands, counts motions, and adds noise to readings.

    The true joints differ from the encoders' readings by an offset (`ArmError`) for the elasticity of gears
    and links, which is drawn again whenever the arm starts from rest.
    """

    STATE: ClassVar[Kinds] = {
        "_command": FloatArray,
        "_from": FloatArray,
        "_motions": int,
        "_moving": bool,
        "_set_out": FloatArray,
        "swung": bool,
        "_offset": FloatArray,
        "_readings": dict[str, tuple[int, FloatArray]],
        "_now": int,
    }
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, robot: RobotFile, model: ArmModel, stands: FloatArray, seed: int) -> None:
        """Create an arm whose encoders first read the joints `stands` (n,), in [rad] or [m]."""
        self._model, self._errors, self._seed = model, robot.errors, seed
        top = np.inf if robot.arm is None else robot.joint_speeds()
        self._most = np.minimum(model.velocity, top) * robot.period_s
        self._command, self._from = stands.copy(), stands.copy()
        self._motions, self._moving = 0, False
        self._set_out = self._hand_on_floor()
        """Commanded position (2,) of the hand when the arm last started from rest, x and y in the base frame,
        in [m].
        """
        self.swung = False
        """True if a motion of the arm ended in this period that counts as a swing, see `is_swing`."""
        self._error = ArmError(robot.errors, model, seed)
        self._offset = self._error.offset(self._command, 0)
        self._readings = dict[str, tuple[int, FloatArray]]()
        self._now = 0

    @abstractmethod
    def true_joints(self) -> FloatArray:
        """Return the true joint positions (n,), in [rad] or [m], without errors of the encoders."""

    @abstractmethod
    def _true_force(self) -> FloatArray:
        """Return the true force (3,) of the surroundings on the hand, in [N], in the hand frame."""

    @override
    def move(self, joints: FloatArray) -> None:
        self._command = checked_joints(self._model, joints, self._from, self._most)

    @override
    def command(self) -> FloatArray:
        return self._command.copy()

    @override
    def joints(self) -> FloatArray:
        return self._read(
            "joints", lambda: self.true_joints() - self._offset, self._errors.encoder_mrad / 1e3
        )

    @override
    def hand_force(self) -> FloatArray:
        return self._read("hand force", self._true_force, self._errors.hand_force_n)

    def halt(self) -> None:
        """Discard a command that is not executed yet, so that the arm holds its position."""
        self._command = self._from.copy()

    def swing_yaw(self) -> float:
        """Return the angle by which the arm's last motion turned the base to the left, in [rad].

        To be called only if that motion was a swing (`swung`). A swing moves the loaded hand by at least
        `swing_from_mm` of the robot's file; if this key is 0, any motion is a swing.
        """
        return swing_yaw(self._errors, self._seed, self._motions)

    def _begin(self, period: int, loaded: bool) -> bool:
        """Begin a period; return whether the arm moves in it.

        Args:
            period: number of the period.
            loaded: True if the hand holds something.
        """
        self._now = period
        changed = bool((self._command != self._from).any())
        if changed and not self._moving:
            self._motions += 1
            self._set_out = self._hand_on_floor()
        if changed:
            self._offset = self._error.offset(self._command, self._motions)
        ended = self._moving and not changed
        self.swung = ended and is_swing(self._errors, loaded, self._set_out, self._hand_on_floor())
        self._moving = changed
        return changed

    def _hand_on_floor(self) -> FloatArray:
        """Return the commanded position (2,) of the hand in the base frame, x and y in [m]."""
        return self._model.forward(self._from)[:2, 3].copy()

    def _read(self, sensor: str, truth: Callable[[], FloatArray], sigma: float) -> FloatArray:
        last = self._readings.get(sensor)
        if last is None or last[0] != self._now:
            true = truth()
            noise = sigma * keyed_normal(self._seed, sensor, self._now, len(true))
            last = self._readings[sensor] = (self._now, true + noise)
        return last[1].copy()


class SimulatedGripper(CommandedGripper):
    """Base class of simulated grippers that checks commands, and adds noise to the measured opening."""

    STATE: ClassVar[Kinds] = {"_command": float, "_now": int, "_pressing": bool}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, spec: GripperSpec, errors: Errors, width: float, seed: int) -> None:
        """Create a gripper with an opening of `width` at first, in [m]."""
        self._spec, self._seed = spec, seed
        self._sigma = errors.opening_mm / 1e3
        self._command = width
        self._now, self._pressing = 0, False

    @abstractmethod
    def true_width(self) -> float:
        """Return the true opening of the fingers, in [m], without the noise of the measurement."""

    @override
    def width(self) -> float:
        noise = self._sigma * float(keyed_normal(self._seed, "width", self._now, 1)[0])
        return float(max(0.0, self.true_width() + noise))

    @override
    def closed_on_something(self) -> bool:
        return self._pressing

    def halt(self) -> None:
        """Stop the fingers if they move; fingers that press on something continue to press."""
        if not self._pressing:
            self._command = min(max(0.0, self.true_width()), self._spec.opening_mm / 1e3)


class ArmError:
    """Model of an arm's positioning error, the offset of the true joints from the encoders' readings.

    It represents the elasticity of gears and links. The random part is drawn again whenever the arm starts
    from rest: Gaussian in the joints, and Gaussian and uniform in the hand's position. The systematic part is
    drawn once for a seed: a smooth function of the hand's position, a sine along each axis.
    """

    def __init__(self, errors: Errors, arm: ArmModel, seed: int) -> None:
        self._errors, self._arm, self._seed = errors, arm, seed
        rng = keyed(seed, "arm's systematic error")
        ways = rng.standard_normal((3, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        self._waves = 2 * math.pi / errors.hand_systematic_wave_m * ways
        self._phases = rng.uniform(-math.pi, math.pi, 3)
        self._drawn = (-1, np.zeros(0), np.zeros(3))
        self._of_hand = max(errors.hand_systematic_mm, errors.hand_repeat_mm, errors.hand_uniform_mm) > 0.0

    def offset(self, joints: FloatArray, motion: int) -> FloatArray:
        """Return the error of the arm, which is true joint positions (n,) minus encoders' readings, in [rad]
        or [m].

        Args:
            joints: (n,) commanded joints, in [rad] or [m].
            motion: number of the arm's motion, for which a random part of the error is drawn.
        """
        _, offset, wrong = self._draw(motion, len(joints))
        if not self._of_hand:
            return offset
        hand = self._arm.forward(joints)[:3, 3]
        systematic = self._errors.hand_systematic_mm / math.sqrt(3.0)
        off = wrong + systematic * np.sin(self._waves @ hand + self._phases)
        J = self._arm.jacobian(joints)
        twist = np.zeros(6)
        twist[:3] = off / 1e3
        damped = J @ J.T + _DAMPING
        gives = J.T @ lapack_solved(damped, twist)
        if (most := float(np.linalg.norm(gives))) > _GIVES:
            gives *= _GIVES / most
        return np.asarray(offset + gives)

    def _draw(self, motion: int, dof: int) -> tuple[int, FloatArray, FloatArray]:
        """Return the number of a motion and its errors: of the joints (n,) in [rad] or [m], and of the hand's
        position (3,) in the base frame, in [mm].

        Args:
            motion: number of the arm's motion.
            dof: number of joints.
        """
        if self._drawn[0] != motion:
            errors, rng = self._errors, keyed(self._seed, "joint repeatability", motion)
            offset = errors.joint_repeatability_mrad / 1e3 * rng.standard_normal(dof)
            wrong = errors.hand_repeat_mm * rng.standard_normal(3)
            wrong += errors.hand_uniform_mm * rng.uniform(-1.0, 1.0, 3)
            self._drawn = (motion, offset, wrong)
        return self._drawn
